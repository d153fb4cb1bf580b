/* Frames on a Unix or TCP socket. */
#include <stdio.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <unistd.h>

#include "send.h"
#include "transport/connection.h"
#include "transport/raw.h"

/* A Unix socket is for this user and root, whatever its file's mode has become; TCP asks for a token. */
static bool origin_is_good(const struct dmn_peer *peer, char *out_why, size_t size)
{
    if (!peer->is_local || dmn_peer_is_own(peer)) return true;
    snprintf(out_why, size, "it is of user %u", (unsigned)peer->user);
    return false;
}

static void refuse(int fd, const char *why)
{
    char unread[4096];
    size_t count;
    uint8_t *frame = dmn_send_farewell(why, PRO_PREFIX, &count);

    if (frame) {
        pro_put_length(frame, count);
        (void)!send(fd, frame, PRO_PREFIX + count, MSG_DONTWAIT | MSG_NOSIGNAL);
    }
    free(frame);
    /* A socket that is closed with bytes unread may take back what it sent. */
    (void)!recv(fd, unread, sizeof(unread), MSG_DONTWAIT);
}

static bool begin(struct dmn_connection *connection)
{
    struct pro_reader *reader = malloc(sizeof(*reader));

    if (reader) pro_reader_init(reader, PRO_MAX_TO_DAEMON);
    connection->unwrapping = reader;
    return reader;
}

static void end(struct dmn_connection *connection)
{
    if (connection->unwrapping) pro_reader_finish(connection->unwrapping);
    free(connection->unwrapping);
}

static bool read_frames(struct dmn_connection *connection, const void *bytes, size_t count,
                        char out_error[PRO_ERROR_SIZE])
{
    struct pro_reader *reader = connection->unwrapping;

    if (!pro_reader_add(reader, bytes, count)) {
        snprintf(out_error, PRO_ERROR_SIZE, "%s",
                 dmn_session_is_ready(connection->client) ? "out of memory"
                                                          : "it did not wait for an answer");
        return false;
    }
    while (dmn_session_is_ready(connection->client)) {
        Fovea__Message *message;
        enum pro_result result = pro_reader_take(reader, &message, out_error);

        if (result != PRO_MESSAGE) return result == PRO_MORE;
        if (!dmn_session_take(connection->client, message, out_error)) return false;
    }
    return true;
}

static bool is_partial(const struct dmn_connection *connection)
{
    const struct pro_reader *reader = connection->unwrapping;

    return reader->used > 0;
}

static bool write_frame(struct dmn_connection *connection, uint8_t *block, size_t count)
{
    uint8_t *frame = block + LWS_PRE;
    const size_t size = PRO_PREFIX + count;

    pro_put_length(frame, count);
    return lws_write(connection->wsi, frame, size, LWS_WRITE_RAW) >= (int)size;
}

static int on_socket(struct lws *wsi, enum lws_callback_reasons reason, void *user, void *in, size_t size)
{
    struct dmn_connection *connection = wsi ? lws_get_opaque_user_data(wsi) : NULL;

    (void)user;
    switch (reason) {
    case LWS_CALLBACK_RAW_ADOPT:
        /* Deadlines are the session's. */
        lws_set_timeout(wsi, NO_PENDING_TIMEOUT, 0);
        return dmn_connection_meet(connection) ? 0 : -1;
    case LWS_CALLBACK_RAW_RX:
        dmn_connection_read(connection, in, size);
        return 0;
    case LWS_CALLBACK_RAW_WRITEABLE:
        return dmn_connection_write(connection) ? 0 : -1;
    case LWS_CALLBACK_RAW_CLOSE:
        dmn_connection_close(connection);
        return 0;
    default:
        return 0;
    }
}

static const struct lws_protocols protocols[] = {
    {.name = "raw", .callback = on_socket, .rx_buffer_size = 4096},
    {.name = NULL},
};

const struct dmn_transport dmn_raw = {
    .name = "raw",
    .protocols = protocols,
    .adoption = LWS_ADOPT_SOCKET,
    .headroom = LWS_PRE + PRO_PREFIX,
    .origin_is_good = origin_is_good,
    .may_save = dmn_peer_is_own,
    .refuse = refuse,
    .begin = begin,
    .end = end,
    .read = read_frames,
    .is_partial = is_partial,
    .write = write_frame,
};
