/* Limits on the number of connections. */
#include <stdio.h>

#include "transport/room.h"

bool dmn_room_for_client(const struct dmn_connection *list, const struct dmn_listener *listener,
                         char *out_why, size_t size)
{
    int clients = 0, strangers = 0;

    for (const struct dmn_connection *c = list; c; c = c->next) {
        if (!c->client || c->leaving) continue;
        clients++;
        strangers += c->listener == listener && c->options.token && !c->client->greeted;
    }
    snprintf(out_why, size, "%d clients are connected, which is the most", DMN_MOST_CLIENTS);
    if (clients >= DMN_MOST_CLIENTS) return false;
    snprintf(out_why, size, "%d clients of this listener have shown no token yet, and no more are let in",
             DMN_MOST_STRANGERS);
    return !listener->token || strangers < DMN_MOST_STRANGERS;
}

void dmn_room_for_visit(struct dmn_connection *list)
{
    struct dmn_connection *oldest = NULL;
    int visits = 0;

    for (struct dmn_connection *c = list; c; c = c->next) { /* the newest comes first */
        if (c->client || c->leaving) continue;
        oldest = c;
        visits++;
    }
    if (visits >= DMN_MOST_VISITS) dmn_connection_end(oldest);
}
