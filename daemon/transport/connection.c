/* A client's connection, over any transport, and its session. */
#include <stdlib.h>
#include <unistd.h>

#include "print.h"
#include "send.h"
#include "transport/connection.h"

enum {
    BURST = 8,                        /* messages to one client before others have their turn */
    VISIT = 15 * DMN_CHECKS_A_SECOND, /* checks that a connection without a session may live */
};

static void destroy(struct dmn_connection *connection)
{
    if (!connection) return;
    connection->transport->end(connection);
    dmn_session_destroy(connection->client);
    free(connection);
}

void dmn_connection_open(struct dmn_connection **list, const struct dmn_arrival *arrival,
                         const struct dmn_client_options *options)
{
    const struct dmn_transport *transport = arrival->transport;
    struct dmn_connection *connection = calloc(1, sizeof(*connection));
    lws_adopt_desc_t adopt = {.vh = arrival->vhost,
                              .type =
                                  transport->adoption | (arrival->listener->is_tls ? LWS_ADOPT_ALLOW_SSL : 0),
                              .vh_prot_name = transport->protocols[0].name,
                              .opaque = connection};

    if (!connection) {
        close(arrival->fd);
        return;
    }
    connection->transport = transport;
    connection->listener = arrival->listener;
    connection->peer = arrival->peer;
    connection->options = *options;
    adopt.fd.sockfd = arrival->fd;
    /* On failure libwebsockets has closed the socket, and may or may not have called dmn_connection_close().
     */
    connection->wsi = lws_adopt_descriptor_vhost_via_info(&adopt);
    if (!connection->wsi) {
        dmn_print(stderr, "fovead: client %u (%s) turned away: %s\n", options->number, arrival->peer.name,
                  arrival->listener->is_tls ? "it does not speak TLS" : "it cannot be served");
        destroy(connection);
        return;
    }
    connection->list = list;
    connection->next = *list;
    *list = connection;
}

bool dmn_connection_meet(struct dmn_connection *connection)
{
    const struct dmn_transport *transport = connection->transport;

    connection->options.peer = connection->peer.name;
    connection->options.key = connection->peer.key;
    connection->options.may_save = transport->may_save(&connection->peer);
    connection->options.headroom = transport->headroom;
    return transport->begin(connection) && (connection->client = dmn_session_create(&connection->options));
}

/* Tell the client why the connection ends, if the socket takes that at once. */
static void say_farewell(struct dmn_connection *connection, const char *why)
{
    uint8_t *message;
    size_t count;

    if (lws_send_pipe_choked(connection->wsi)) return;
    message = dmn_send_farewell(why, connection->transport->headroom, &count);
    if (message) connection->transport->write(connection, message, count);
    free(message);
}

void dmn_connection_end(struct dmn_connection *connection)
{
    connection->leaving = true;
    lws_set_timeout(connection->wsi, PENDING_TIMEOUT_KILLED_BY_PARENT, LWS_TO_KILL_ASYNC);
}

static void drop(struct dmn_connection *connection, const char *why)
{
    dmn_print(stderr, "fovead: client %u (%s) dropped: %s\n", connection->client->options.number,
              connection->client->peer, why);
    say_farewell(connection, why);
    dmn_connection_end(connection);
}

void dmn_connection_refuse(struct dmn_connection *connection, const char *why)
{
    dmn_print(stderr, "fovead: client %u (%s) turned away: %s\n", connection->options.number,
              connection->peer.name, why);
    say_farewell(connection, why);
}

void dmn_connection_read(struct dmn_connection *connection, const void *bytes, size_t count)
{
    char error[PRO_ERROR_SIZE];

    if (connection->leaving) return;
    if (connection->transport->read(connection, bytes, count, error))
        dmn_connection_wake(connection);
    else
        drop(connection, error);
}

bool dmn_connection_write(struct dmn_connection *connection)
{
    if (connection->leaving) return true;
    for (int i = 0; i < BURST; i++) {
        size_t count;
        uint8_t *message = dmn_send_next(connection->client, &count);
        bool good;

        if (!message) return true;
        good = connection->transport->write(connection, message, count);
        free(message);
        if (!good) return false;
        /* The rest of a message, at most one, waits in libwebsockets. */
        if (lws_send_pipe_choked(connection->wsi)) break;
    }
    lws_callback_on_writable(connection->wsi);
    return true;
}

void dmn_connection_close(struct dmn_connection *connection)
{
    struct dmn_connection **place = connection->list;

    if (!place) return; /* it was never opened: dmn_connection_open() frees it */
    while (*place != connection) place = &(*place)->next;
    *place = connection->next;
    destroy(connection);
}

void dmn_connection_wake(struct dmn_connection *connection)
{
    if (connection->client && !connection->leaving && dmn_send_is_due(connection->client))
        lws_callback_on_writable(connection->wsi);
}

void dmn_connection_check(struct dmn_connection *connection)
{
    const struct dmn_transport *transport = connection->transport;
    char error[PRO_ERROR_SIZE];

    /* libwebsockets may have set another timeout since. */
    if (connection->leaving || (!connection->client && ++connection->checks >= VISIT))
        dmn_connection_end(connection);
    if (!connection->client || connection->leaving) return;
    dmn_session_stats(connection->client);
    if (dmn_session_check(connection->client, transport->is_partial(connection), error) &&
        transport->read(connection, NULL, 0, error))
        return;
    drop(connection, error);
}

bool dmn_connection_has_more(struct dmn_connection *connection)
{
    return connection->client && !connection->leaving &&
           (dmn_send_is_due(connection->client) || lws_partial_buffered(connection->wsi));
}
