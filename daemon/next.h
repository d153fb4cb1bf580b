/* next: which tiles a client is sent next. It decides and does nothing: what is known of tiles in, places
 * out. */
#ifndef FOVEAD_DAEMON_NEXT_H
#define FOVEAD_DAEMON_NEXT_H

#include "pyramid.h"

struct dmn_place {
    int level, x, y;
    size_t index; /* in the pyramid */
    float rank;   /* lower goes first */
};

/* The tiles that a client should be sent next, best first, at most limit of them; returns how many.
 * sent (pyramid->count of them) says what each tile was when it was last sent to this client; samples 0 if
 * never.
 *  1. What has no picture at all yet, coarsest level first, so that nothing stays black.
 *  2. The other coarse levels, the whole sphere.
 *  3. By distance from gaze: finer tiles where the mean pixel has a path or more, and tiles sent before that
 * have half as many paths again, or have converged or settled since. A tile that finer ones hide, or could
 * replace at once, is not sent again. */
size_t dmn_next(const struct dmn_pyramid *pyramid, const struct dmn_tile *sent, const float gaze[3],
                size_t limit, struct dmn_place *out_places);

/* The tile by which the client sees that place: the finest that it was sent. False if that has nothing new.
 */
bool dmn_seen_at(const struct dmn_pyramid *pyramid, const struct dmn_tile *sent, const float gaze[3],
                 struct dmn_place *out_place);

#endif
