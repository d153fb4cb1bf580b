/* connection: a client's connection, over any transport, and its session. For the loop's thread alone. */
#ifndef FOVEAD_DAEMON_TRANSPORT_CONNECTION_H
#define FOVEAD_DAEMON_TRANSPORT_CONNECTION_H

#include "session.h"
#include "transport/transport.h"

struct dmn_connection {
    struct dmn_connection **list, *next; /* the list of open connections */
    const struct dmn_transport *transport;
    struct lws *wsi;
    struct dmn_client *client;
    void *unwrapping; /* for the transport */
};

/* Serve a client whose socket was accepted, and put the connection into the list. The transport sets may_save
 * and headroom of the options. The socket is closed on failure. */
void dmn_connection_open(struct dmn_connection **list, struct lws_vhost *vhost,
                         const struct dmn_transport *transport, int fd, const struct dmn_peer *peer,
                         const struct dmn_client_options *options);

/* --- what libwebsockets says, by the transport's callback; false: the connection must be closed --- */

bool dmn_connection_read(struct dmn_connection *connection, const void *bytes, size_t count);
bool dmn_connection_write(struct dmn_connection *connection);
void dmn_connection_close(struct dmn_connection *connection); /* frees it */

/* --- what the loop does --- */

/* Ask libwebsockets to say when there is room to write, if there is something to send. */
void dmn_connection_wake(struct dmn_connection *connection);
/* Call this DMN_CHECKS_A_SECOND times per second: it makes statistics due, and drops a client that is
 * overdue. */
void dmn_connection_check(struct dmn_connection *connection);
/* Is there something that is not sent yet? */
bool dmn_connection_has_more(struct dmn_connection *connection);

#endif
