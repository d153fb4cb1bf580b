/* The page's files by HTTP, and messages by WebSocket. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "print.h"
#include "transport/room.h"
#include "transport/tls.h"
#include "transport/visit.h"
#include "transport/web.h"

enum { HEADER_SIZE = 256, HEADERS_SIZE = 2048, CHUNK = 16 << 10 };

/* --- who may come in --- */

/* Every peer may connect: the headers that tell where a request comes from are checked when they have come.
 */
static bool origin_is_good(const struct dmn_peer *peer, char *out_why, size_t size)
{
    (void)peer, (void)out_why, (void)size;
    return true;
}

/* Copy a header, or "" if the request has none. False if it is too long for the buffer: the names of honest
 * hosts are shorter. */
static bool copy_header(struct lws *wsi, enum lws_token_indexes token, char out_text[HEADER_SIZE])
{
    out_text[0] = '\0';
    return lws_hdr_total_length(wsi, token) == 0 || lws_hdr_copy(wsi, out_text, HEADER_SIZE, token) > 0;
}

/* Does the request come from a page that was served here, or from a program that is no browser? That is what
 * its headers tell. False after a line on stderr; *out_answer is then for the browser's user. */
static bool is_welcome(struct lws *wsi, const struct dmn_connection *connection, const char **out_answer)
{
    char host[HEADER_SIZE], origin[HEADER_SIZE], why[HEADER_SIZE + 64];

    *out_answer = "This request does not come from fovead's own page.\n";
    if (!copy_header(wsi, WSI_TOKEN_HOST, host) || !copy_header(wsi, WSI_TOKEN_ORIGIN, origin)) {
        snprintf(why, sizeof(why), "its Host or Origin header has %d bytes or more", HEADER_SIZE);
    } else if (!*host) {
        snprintf(why, sizeof(why), "its request has no Host header");
    } else if (!dmn_visit_host_is_good(host, connection->listener)) {
        snprintf(why, sizeof(why), "it asks for the host '%s', which is no name of this listener", host);
        *out_answer = "fovead does not know this name of its machine: use the numeric address instead.\n";
    } else if (!dmn_visit_origin_is_good(origin, host, connection->listener)) {
        snprintf(why, sizeof(why), "it asks as a page of another site does, '%s'", origin);
    } else {
        return true;
    }
    dmn_print(stderr, "fovead: client %u (%s) turned away: %s\n", connection->options.number,
              connection->peer.name, why);
    return false;
}

/* --- the page's files --- */

/* The file of the page that a connection is sent. */
struct answer {
    const struct dmn_page_file *file; /* NULL: none */
    size_t sent;                      /* bytes of it so far */
};

static const char *const HEADERS[][2] = {
    {"content-security-policy:",
     "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob:; "
     "connect-src 'self' ws: wss:; base-uri 'none'; form-action 'none'; "
     "frame-ancestors 'none'"},
    {"x-content-type-options:", "nosniff"},
    {"referrer-policy:", "no-referrer"},
    {"cache-control:", "no-store"},
    {"cross-origin-resource-policy:", "same-origin"},
};

/* Write the headers of an answer of count bytes. */
static bool write_headers(struct lws *wsi, unsigned status, const char *type, size_t count)
{
    unsigned char buffer[LWS_PRE + HEADERS_SIZE], *start = buffer + LWS_PRE, *at = start,
                                                  *end = buffer + sizeof(buffer) - 1;

    if (lws_add_http_common_headers(wsi, status, type, count, &at, end)) return false;
    for (size_t i = 0; i < sizeof(HEADERS) / sizeof(*HEADERS); i++)
        if (lws_add_http_header_by_name(wsi, (const unsigned char *)HEADERS[i][0],
                                        (const unsigned char *)HEADERS[i][1], (int)strlen(HEADERS[i][1]), &at,
                                        end))
            return false;
    return !lws_finalize_write_http_header(wsi, start, &at, end);
}

/* Write a short text and close the connection. Returns what the callback returns. */
static int answer_with(struct lws *wsi, unsigned status, const char *text)
{
    unsigned char buffer[LWS_PRE + 128];
    const size_t count = strlen(text);

    memcpy(buffer + LWS_PRE, text, count);
    if (!write_headers(wsi, status, "text/plain", count) ||
        lws_write(wsi, buffer + LWS_PRE, count, LWS_WRITE_HTTP_FINAL) != (int)count)
        return -1;
    return -1;
}

static int take_request(struct lws *wsi, const struct dmn_connection *connection, const char *path,
                        struct answer *answer)
{
    const char *text;

    if (!connection) return -1;
    if (!is_welcome(wsi, connection, &text)) return answer_with(wsi, HTTP_STATUS_FORBIDDEN, text);
    if (!lws_hdr_total_length(wsi, WSI_TOKEN_GET_URI))
        return answer_with(wsi, HTTP_STATUS_METHOD_NOT_ALLOWED, "only GET is answered\n");
    answer->file = dmn_visit_file(path);
    answer->sent = 0;
    if (!answer->file) return answer_with(wsi, HTTP_STATUS_NOT_FOUND, "there is no such file\n");
    if (!write_headers(wsi, HTTP_STATUS_OK, answer->file->type, answer->file->count)) return -1;
    lws_callback_on_writable(wsi);
    return 0;
}

/* Send the next part of the file. */
static int go_on(struct lws *wsi, struct answer *answer)
{
    unsigned char buffer[LWS_PRE + CHUNK];
    size_t count;

    if (!answer->file) return 0;
    count = answer->file->count - answer->sent;
    if (count > CHUNK) count = CHUNK;
    memcpy(buffer + LWS_PRE, answer->file->bytes + answer->sent, count);
    answer->sent += count;
    const bool ends = answer->sent == answer->file->count;
    if (lws_write(wsi, buffer + LWS_PRE, count, ends ? LWS_WRITE_HTTP_FINAL : LWS_WRITE_HTTP) != (int)count)
        return -1;
    if (!ends) {
        lws_callback_on_writable(wsi);
        return 0;
    }
    answer->file = NULL;
    return lws_http_transaction_completed(wsi) ? -1 : 0;
}

/* --- messages --- */

/* The part of a message that has come so far. A browser may send a message in several frames, and
 * libwebsockets hands over a long frame in several parts. */
struct assembly {
    uint8_t *bytes;
    size_t used, size;
    bool whole; /* the message has come whole, and waits until the session is ready to take it */
};

static bool begin(struct dmn_connection *connection)
{
    connection->unwrapping = calloc(1, sizeof(struct assembly));
    return connection->unwrapping;
}

static void end(struct dmn_connection *connection)
{
    struct assembly *assembly = connection->unwrapping;

    if (assembly) free(assembly->bytes);
    free(assembly);
}

/* False if the message grows beyond its limit, or memory is short. */
static bool add(struct assembly *assembly, const void *bytes, size_t count)
{
    const size_t needed = assembly->used + count;

    if (needed > PRO_MAX_TO_DAEMON) return false;
    if (needed > assembly->size) {
        const size_t size = needed < 4096 ? 4096 : 2 * needed;
        uint8_t *grown = realloc(assembly->bytes, size);

        if (!grown) return false;
        assembly->bytes = grown;
        assembly->size = size;
    }
    if (count) memcpy(assembly->bytes + assembly->used, bytes, count);
    assembly->used = needed;
    return true;
}

static bool read_messages(struct dmn_connection *connection, const void *bytes, size_t count,
                          char out_error[PRO_ERROR_SIZE])
{
    struct assembly *assembly = connection->unwrapping;
    struct lws *wsi = connection->wsi;
    Fovea__Message *message;

    if (bytes) {
        const char *why = assembly->whole                ? "it did not wait for an answer"
                          : !lws_frame_is_binary(wsi)    ? "it sent text, where binary messages are expected"
                          : !add(assembly, bytes, count) ? "it sent a message that is too long"
                                                         : NULL;

        if (why) {
            snprintf(out_error, PRO_ERROR_SIZE, "%s", why);
            return false;
        }
        assembly->whole = lws_is_final_fragment(wsi) && lws_remaining_packet_payload(wsi) == 0;
    }
    if (!assembly->whole || !dmn_session_is_ready(connection->client)) return true;
    message = pro_unpack_message(assembly->bytes, assembly->used, out_error);
    assembly->used = 0;
    assembly->whole = false;
    return message && dmn_session_take(connection->client, message, out_error);
}

static bool is_partial(const struct dmn_connection *connection)
{
    const struct assembly *assembly = connection->unwrapping;

    return assembly->used > 0;
}

static bool write_message(struct dmn_connection *connection, uint8_t *block, size_t count)
{
    return lws_write(connection->wsi, block + LWS_PRE, count, LWS_WRITE_BINARY) >= (int)count;
}

/* --- what libwebsockets says --- */

/* libwebsockets has closed a socket. It may tell this more than once, to each protocol that the socket had.
 */
static void leave(struct lws *wsi, struct dmn_connection *connection)
{
    lws_set_opaque_user_data(wsi, NULL);
    if (connection) dmn_connection_close(connection);
}

/* Begin the session of a browser whose WebSocket has just opened. */
static bool meet(struct lws *wsi, struct dmn_connection *connection)
{
    char why[96];

    lws_set_timeout(wsi, NO_PENDING_TIMEOUT, 0); /* deadlines are the session's */
    if (dmn_room_for_client(*connection->list, connection->listener, why, sizeof(why)))
        return dmn_connection_meet(connection);
    dmn_connection_refuse(connection, why);
    return false;
}

static int on_visit(struct lws *wsi, enum lws_callback_reasons reason, void *user, void *in, size_t size)
{
    struct dmn_connection *connection = wsi ? lws_get_opaque_user_data(wsi) : NULL;

    (void)size;
    switch (reason) {
    case LWS_CALLBACK_OPENSSL_LOAD_EXTRA_SERVER_VERIFY_CERTS:
        return dmn_tls_use(user, in) ? 0 : -1;
    case LWS_CALLBACK_FILTER_PROTOCOL_CONNECTION:
        return -1; /* a WebSocket that does not ask for the protocol "fovea" */
    case LWS_CALLBACK_HTTP:
        return take_request(wsi, connection, in, user);
    case LWS_CALLBACK_HTTP_WRITEABLE:
        return go_on(wsi, user);
    case LWS_CALLBACK_WSI_DESTROY:
        leave(wsi, connection);
        return 0;
    default:
        return 0;
    }
}

static int on_socket(struct lws *wsi, enum lws_callback_reasons reason, void *user, void *in, size_t size)
{
    struct dmn_connection *connection = wsi ? lws_get_opaque_user_data(wsi) : NULL;
    const char *text;

    (void)user;
    switch (reason) {
    case LWS_CALLBACK_FILTER_PROTOCOL_CONNECTION:
        return connection && is_welcome(wsi, connection, &text) ? 0 : -1;
    case LWS_CALLBACK_ESTABLISHED:
        return meet(wsi, connection) ? 0 : -1;
    case LWS_CALLBACK_RECEIVE:
        dmn_connection_read(connection, in, size);
        return 0;
    case LWS_CALLBACK_SERVER_WRITEABLE:
        return dmn_connection_write(connection) ? 0 : -1;
    case LWS_CALLBACK_WSI_DESTROY:
        leave(wsi, connection);
        return 0;
    default:
        return 0;
    }
}

static const struct lws_protocols protocols[] = {
    {.name = "http", .callback = on_visit, .per_session_data_size = sizeof(struct answer)},
    {.name = "fovea", .callback = on_socket, .rx_buffer_size = 4096},
    {.name = NULL},
};

const struct dmn_transport dmn_web = {
    .name = "web",
    .is_http = true,
    .protocols = protocols,
    .adoption = LWS_ADOPT_SOCKET | LWS_ADOPT_HTTP,
    .headroom = LWS_PRE,
    .origin_is_good = origin_is_good,
    .may_save = dmn_peer_is_own,
    .begin = begin,
    .end = end,
    .read = read_messages,
    .is_partial = is_partial,
    .write = write_message,
};
