/* connection: a client's connection, over any transport, and its session. For the loop's thread alone. */
#ifndef FOVEAD_DAEMON_TRANSPORT_CONNECTION_H
#define FOVEAD_DAEMON_TRANSPORT_CONNECTION_H

#include "session.h"
#include "transport/transport.h"

struct dmn_connection {
    struct dmn_connection **list, *next; /* the list of open connections */
    const struct dmn_transport *transport;
    struct lws *wsi;
    const struct dmn_listener *listener; /* where the client connected */
    struct dmn_peer peer;
    struct dmn_client_options options; /* for the session */
    struct dmn_client *client;         /* the session; NULL: none has begun */
    void *unwrapping;                  /* for the transport */
    unsigned checks;                   /* so far, before the session began */
    bool leaving;                      /* libwebsockets will close it, and nothing more is done for it */
};

/* A socket that was accepted. */
struct dmn_arrival {
    struct lws_vhost *vhost; /* of the transport */
    const struct dmn_transport *transport;
    const struct dmn_listener *listener;
    int fd;
    struct dmn_peer peer;
};

/* Serve a socket that was accepted, and put the connection into the list. The options are for its session;
 * the peer and the transport set those that depend on them. The socket is closed on failure. */
void dmn_connection_open(struct dmn_connection **list, const struct dmn_arrival *arrival,
                         const struct dmn_client_options *options);

/* --- what libwebsockets says, by the transport's callback; false: the connection must be closed --- */

bool dmn_connection_meet(struct dmn_connection *connection); /* begins the session */
void dmn_connection_read(struct dmn_connection *connection, const void *bytes, size_t count);
bool dmn_connection_write(struct dmn_connection *connection);
/* Tell a client, on which no session has begun, why it is turned away; the connection must then be closed. */
void dmn_connection_refuse(struct dmn_connection *connection, const char *why);
void dmn_connection_close(struct dmn_connection *connection); /* frees it */

/* --- what the loop does; where no session has begun, nothing --- */

/* Have libwebsockets close the connection, without waiting for the peer, before it waits for events again. */
void dmn_connection_end(struct dmn_connection *connection);
/* Ask libwebsockets to say when there is room to write, if there is something to send. */
void dmn_connection_wake(struct dmn_connection *connection);
/* Call this DMN_CHECKS_A_SECOND times per second: it makes statistics due, and drops a client that is
 * overdue. */
void dmn_connection_check(struct dmn_connection *connection);
/* Is there something that is not sent yet? */
bool dmn_connection_has_more(struct dmn_connection *connection);

#endif
