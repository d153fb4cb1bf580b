/* steering: whose view steers, of the clients that show one.
 *
 * Clients are ranked. Headsets come before windows. Within each kind the client that asked most recently
 * comes first, and those that never asked come last. The first client steers. When it leaves, the next one
 * does. Nothing here knows of sockets or gaze. For one thread. */
#ifndef FOVEAD_DAEMON_STEERING_H
#define FOVEAD_DAEMON_STEERING_H

#include "tracker.h"

/* What one client shows. All zero: nothing. */
struct dmn_shown {
    struct dmn_shown *next; /* in the order of ranks; valid while this client shows a view */
    const char *who;        /* the client, for people */
    bool shown, headset;
    uint64_t asked; /* counts who asked, from 1; 0: it has not */
    struct trk_view view;
};

/* All zero: nobody shows anything. */
struct dmn_steering {
    struct dmn_shown *first; /* whose view steers; NULL: nobody's */
    uint64_t asks;           /* so far */
    unsigned changes;        /* of first, so far */
};

/* A client shows a view, which is copied; NULL: none any more. asks: it asks to steer. A headset asks with
 * its first view, and with no later one, because its views follow the head. client lives until it shows none.
 */
void dmn_steering_show(struct dmn_steering *steering, struct dmn_shown *client,
                       const struct trk_view *view_or_null, bool headset, bool asks);

#endif
