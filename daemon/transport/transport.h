/* transport: how messages get to a client and back. A row of the table says how they are wrapped and carried,
 * and what a client on this transport may do. Sessions and the loop know no transport by name.
 *
 * Adding one is a file like raw.c and its line in table.c. */
#ifndef FOVEAD_DAEMON_TRANSPORT_TRANSPORT_H
#define FOVEAD_DAEMON_TRANSPORT_TRANSPORT_H

#include <libwebsockets.h>

#include "listen.h"

struct dmn_connection; /* connection.h */

struct dmn_transport {
    const char *name; /* of its virtual host in libwebsockets */
    /* true: serves the listeners whose address is http:, where a connection begins as a visit (room.h).
     * false: serves all other listeners, where a connection is a client from the start. */
    bool is_http;
    /* What libwebsockets serves, with an empty entry last. The callback of a connection calls
     * dmn_connection_meet() when messages can come, dmn_connection_read() on what comes in,
     * dmn_connection_write() on room to write, and at the end dmn_connection_close(). The connection is the
     * opaque user data. */
    const struct lws_protocols *protocols;
    lws_adoption_type adoption; /* how libwebsockets adopts an accepted socket */
    size_t headroom;            /* bytes that write() needs free before a message */

    /* May this peer connect? False with why not. */
    bool (*origin_is_good)(const struct dmn_peer *peer, char *out_why, size_t size);
    /* Does the daemon write files for this peer? */
    bool (*may_save)(const struct dmn_peer *peer);
    /* Tell a client whose socket was just accepted why it is turned away, if the socket takes that at once.
     * NULL if is_http: a visit is not turned away. */
    void (*refuse)(int fd, const char *why);

    /* Prepare connection->unwrapping, which holds the part of a message that has come. False if memory is
     * short. */
    bool (*begin)(struct dmn_connection *connection);
    void (*end)(struct dmn_connection *connection); /* also after begin() has failed */
    /* Take count bytes that came, which may be 0, and give the session whole messages while it is ready for
     * them. False with a line in out_error if the client must be dropped. */
    bool (*read)(struct dmn_connection *connection, const void *bytes, size_t count,
                 char out_error[PRO_ERROR_SIZE]);
    /* Has a message begun and not ended? */
    bool (*is_partial)(const struct dmn_connection *connection);
    /* Wrap and write a message of count bytes, which follow the headroom in block. What the socket does not
     * take at once waits in libwebsockets. False if the connection is broken. */
    bool (*write)(struct dmn_connection *connection, uint8_t *block, size_t count);
};

#endif
