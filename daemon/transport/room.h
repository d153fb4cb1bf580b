/* room: how many connections the daemon has room for. A visit is a connection by HTTP on which no session has
 * begun (yet): a browser loads the page's files, or waits before it loads more. Visits do not count as
 * clients, because browsers keep them open for some seconds after a page is loaded. */
#ifndef FOVEAD_DAEMON_TRANSPORT_ROOM_H
#define FOVEAD_DAEMON_TRANSPORT_ROOM_H

#include "transport/connection.h"

enum {
    DMN_MOST_CLIENTS = 64,
    DMN_MOST_STRANGERS =
        16,               /* clients of a listener whose token has not been checked: the rest is for others */
    DMN_MOST_VISITS = 32, /* a browser opens up to 6 at once */
};

/* Is there room for one more client of this listener? False with why not. */
bool dmn_room_for_client(const struct dmn_connection *list, const struct dmn_listener *listener,
                         char *out_why, size_t size);
/* Make room for one more visit: when there are as many as may be, the oldest ends. So nobody can keep others
 * from the page by visits that ask for nothing, or that do not read what they asked for. */
void dmn_room_for_visit(struct dmn_connection *list);

#endif
