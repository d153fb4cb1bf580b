/* client.c: one connection to a daemon.
 *
 * The socket never blocks. What is to be sent waits in client->out; the client's own Acknowledge and Ping are
 * put there only while it is empty, so that a daemon that does not read cannot make it grow.
 */
#include "internal.h"

#include <errno.h>
#include <math.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

static const uint64_t ping_every_ns = 1000000000;
static const int send_patience_ms = 10000;

/* Most tiles of a burst that are left unacknowledged. */
enum { BURST = 4 };

struct pro_client {
    int fd;
    char name[300]; /* of the daemon's address */
    struct pro_reader reader;
    uint64_t received_ns; /* when bytes last came */

    uint8_t *out; /* bytes that the socket has not taken yet */
    size_t out_count, out_sent;
    bool deaf; /* the daemon takes no more bytes; what it has sent is still read */

    Fovea__Message *welcome;
    Fovea__Encoding encoding; /* of tiles, as asked for */
    struct pro_picture *picture;
    float *tile; /* one tile's pixels */

    unsigned burst;          /* most tiles to leave unacknowledged */
    unsigned unacknowledged; /* tiles */
    uint64_t serial;         /* the newest of them */

    bool ping_under_way;
    uint64_t ping_ns; /* when the last Ping was sent */
    struct pro_estimate clock;
};

/* --- sending --- */

/* Send as much as the socket takes now. */
static void flush(struct pro_client *client)
{
    while (client->out && !client->deaf) {
        ssize_t sent = send(client->fd, client->out + client->out_sent, client->out_count - client->out_sent,
                            MSG_NOSIGNAL);
        if (sent < 0 && errno == EINTR) continue;
        if (sent < 0 && errno == EAGAIN) return;
        if (sent < 0) {
            client->deaf = true;
            return;
        }
        client->out_sent += (size_t)sent;
        if (client->out_sent < client->out_count) continue;
        free(client->out);
        client->out = NULL;
    }
}

/* Begin to send a message; only if nothing else waits. */
static bool start(struct pro_client *client, const Fovea__Message *message)
{
    client->out = pro_pack(message, 0, &client->out_count);
    client->out_sent = 0;
    if (!client->out) return false;
    flush(client);
    return true;
}

static void acknowledge(struct pro_client *client)
{
    Fovea__Acknowledge body = FOVEA__ACKNOWLEDGE__INIT;
    Fovea__Message message = FOVEA__MESSAGE__INIT;
    body.serial = client->serial;
    message.body_case = FOVEA__MESSAGE__BODY_ACKNOWLEDGE;
    message.acknowledge = &body;
    if (client->unacknowledged > 0 && !client->out && start(client, &message)) client->unacknowledged = 0;
}

/* When the next Ping may be sent. Only one is under way at a time, so that a Pong's round trip is known; and
 * none while other bytes wait, which wake pro_receive() when they are sent. */
static uint64_t next_ping_ns(const struct pro_client *client)
{
    if (client->ping_under_way || client->out || !client->welcome) return PRO_NEVER;
    return client->ping_ns == 0 ? 0 : client->ping_ns + ping_every_ns;
}

static void ping(struct pro_client *client)
{
    Fovea__Ping body = FOVEA__PING__INIT;
    Fovea__Message message = FOVEA__MESSAGE__INIT;
    uint64_t now = pro_now_ns();
    if (now < next_ping_ns(client)) return;
    body.client_ns = now;
    message.body_case = FOVEA__MESSAGE__BODY_PING;
    message.ping = &body;
    if (!start(client, &message)) return;
    client->ping_ns = now;
    client->ping_under_way = true;
}

/* Wait until nothing is left to send. */
static bool drain(struct pro_client *client, uint64_t deadline_ns, char out_error[PRO_ERROR_SIZE])
{
    for (flush(client); client->out && !client->deaf; flush(client))
        if (!pro_wait(client->fd, POLLOUT, deadline_ns))
            return pro_fail(out_error, "%s takes no messages", client->name);
    if (client->deaf) return pro_fail(out_error, "%s has closed the connection", client->name);
    return true;
}

bool pro_send(struct pro_client *client, const Fovea__Message *message, char out_error[PRO_ERROR_SIZE])
{
    size_t length = fovea__message__get_packed_size(message);
    if (length > PRO_MAX_TO_DAEMON)
        return pro_fail(out_error, "a message of %zu bytes, where %d is the limit", length,
                        PRO_MAX_TO_DAEMON);
    uint64_t deadline_ns = pro_deadline_ns(send_patience_ms);
    if (!drain(client, deadline_ns, out_error)) return false;
    if (!start(client, message)) return pro_fail(out_error, "memory is short");
    return drain(client, deadline_ns, out_error);
}

/* --- receiving --- */

void pro_estimate_add(struct pro_estimate *estimate, uint64_t sent_ns, uint64_t daemon_ns,
                      uint64_t received_ns)
{
    uint64_t round_trip_ns = received_ns - sent_ns;
    /* An estimate loses 200 parts per million of its age, twice the error of a poor crystal: a longer round
     * trip replaces it then. */
    uint64_t allowance_ns = (received_ns - estimate->measured_ns) / 5000;
    if (estimate->known && round_trip_ns > estimate->round_trip_ns + allowance_ns) return;
    *estimate = (struct pro_estimate){true, round_trip_ns,
                                      (int64_t)(daemon_ns - (sent_ns + round_trip_ns / 2)), received_ns};
}

static bool all_finite(const float *numbers, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (!isfinite(numbers[i])) return false;
    return true;
}

static bool take_tile(struct pro_client *client, const Fovea__Tile *tile, char out_error[PRO_ERROR_SIZE])
{
    if (tile->encoding != client->encoding)
        return pro_fail(out_error, "%s sent a tile in encoding %d, which was not asked for", client->name,
                        (int)tile->encoding);
    if (!pro_picture_has_place(client->picture, tile->level, tile->x, tile->y))
        return pro_fail(out_error, "%s sent a tile for level %u, column %u, row %u, where there is none",
                        client->name, tile->level, tile->x, tile->y);
    uint32_t size = client->welcome->welcome->tile_size;
    if (!pro_decode(tile->encoding, tile->data.data, tile->data.len, size, client->tile))
        return pro_fail(out_error, "%s sent %zu bytes that are not a tile of %u pixels", client->name,
                        tile->data.len, size);
    if (!pro_picture_put(client->picture, tile->generation, tile->level, tile->x, tile->y, client->tile))
        return pro_fail(out_error, "memory is short for the picture");
    if (client->unacknowledged == 0 || tile->serial > client->serial) client->serial = tile->serial;
    client->unacknowledged++;
    return true;
}

static void take_pong(struct pro_client *client, const Fovea__Pong *pong)
{
    if (!client->ping_under_way || pong->client_ns != client->ping_ns) return;
    client->ping_under_way = false;
    pro_estimate_add(&client->clock, client->ping_ns, pong->daemon_ns, client->received_ns);
}

static bool take_welcome(struct pro_client *client, const Fovea__Welcome *welcome,
                         char out_error[PRO_ERROR_SIZE])
{
    pro_clean(welcome->server);
    pro_clean(welcome->scene);
    pro_clean(welcome->gaze_source);
    pro_clean(welcome->distribution);
    if (welcome->version != PRO_VERSION)
        return pro_fail(out_error, "%s speaks version %u of the protocol, and this client version %d",
                        client->name, welcome->version, PRO_VERSION);
    client->picture = pro_picture_create(welcome, out_error);
    if (!client->picture) return false;
    client->tile = malloc((size_t)welcome->tile_size * welcome->tile_size * 3 * sizeof *client->tile);
    return client->tile || pro_fail(out_error, "memory is short");
}

static bool take_gaze(struct pro_client *client, const Fovea__Gaze *gaze, char out_error[PRO_ERROR_SIZE])
{
    pro_clean(gaze->state);
    pro_clean(gaze->source);
    pro_clean(gaze->why);
    return (gaze->n_direction == 3 && all_finite(gaze->direction, 3) &&
            (gaze->n_head == 0 || gaze->n_head == 4) && all_finite(gaze->head, gaze->n_head) &&
            (gaze->n_aim == 0 || gaze->n_aim == 3) && all_finite(gaze->aim, gaze->n_aim)) ||
           pro_fail(out_error, "%s sent a gaze of no direction", client->name);
}

/* Check the position of the camera, if there is one. */
static bool check_camera(const struct pro_client *client, const float *camera, size_t count,
                         char out_error[PRO_ERROR_SIZE])
{
    return ((count == 0 || count == 3) && all_finite(camera, count)) ||
           pro_fail(out_error, "%s sent an impossible position of the camera", client->name);
}

/* Check and take a message. The first one must be Welcome, or Done in its place; a second Welcome is refused.
 */
static bool take(struct pro_client *client, const Fovea__Message *message, char out_error[PRO_ERROR_SIZE])
{
    bool welcomed = client->welcome != NULL;
    switch (message->body_case) {
    case FOVEA__MESSAGE__BODY_WELCOME:
        if (welcomed) break;
        return take_welcome(client, message->welcome, out_error);
    case FOVEA__MESSAGE__BODY_DONE:
        pro_clean(message->done->text);
        if (welcomed) return check_camera(client, message->done->camera, message->done->n_camera, out_error);
        return pro_fail(out_error, "%s refused: %s", client->name, message->done->text);
    case FOVEA__MESSAGE__BODY_TILE:
        if (!welcomed) break;
        return take_tile(client, message->tile, out_error);
    case FOVEA__MESSAGE__BODY_GAZE:
        if (!welcomed) break;
        return take_gaze(client, message->gaze, out_error);
    case FOVEA__MESSAGE__BODY_PONG:
        if (!welcomed) break;
        take_pong(client, message->pong);
        return true;
    case FOVEA__MESSAGE__BODY_BYE:
        if (!welcomed) break;
        return true;
    case FOVEA__MESSAGE__BODY_VIEWING:
        if (!welcomed) break;
        pro_clean(message->viewing->who);
        return true;
    case FOVEA__MESSAGE__BODY_STATS:
        if (!welcomed) break;
        pro_clean(message->stats->gaze_source);
        pro_clean(message->stats->recording);
        pro_clean(message->stats->recording_error);
        pro_clean(message->stats->scene);
        pro_clean(message->stats->refused);
        return check_camera(client, message->stats->camera, message->stats->n_camera, out_error);
    default:
        break;
    }
    return pro_fail(out_error, "%s sent a message of kind %d out of place", client->name,
                    (int)message->body_case);
}

/* Read from the socket once. */
static bool fill(struct pro_client *client, char out_error[PRO_ERROR_SIZE])
{
    uint8_t bytes[PRO_CHUNK];
    ssize_t count = recv(client->fd, bytes, sizeof bytes, 0);
    if (count < 0 && (errno == EAGAIN || errno == EINTR)) return true;
    if (count < 0)
        return pro_fail(out_error, "the connection to %s broke: %s", client->name, strerror(errno));
    if (count == 0)
        return pro_fail(out_error, "%s has closed the connection%s", client->name,
                        client->reader.used > 0 ? " in the middle of a message" : "");
    client->received_ns = pro_now_ns();
    return pro_reader_add(&client->reader, bytes, (size_t)count) || pro_fail(out_error, "memory is short");
}

static enum pro_result receive(struct pro_client *client, uint64_t deadline_ns, Fovea__Message **out_message,
                               char out_error[PRO_ERROR_SIZE])
{
    for (bool last = false;;) {
        char why[PRO_ERROR_SIZE];
        enum pro_result result = pro_reader_take(&client->reader, out_message, why);
        if (result == PRO_BROKEN) pro_fail(out_error, "%s sent %.400s", client->name, why);
        if (result == PRO_MESSAGE && !take(client, *out_message, out_error)) {
            fovea__message__free_unpacked(*out_message, NULL);
            *out_message = NULL;
            result = PRO_BROKEN;
        }
        if (result == PRO_BROKEN) return PRO_BROKEN;
        if (client->unacknowledged >= client->burst || !pro_reader_ready(&client->reader))
            acknowledge(client);
        ping(client);
        if (result == PRO_MESSAGE || last) return result;

        uint64_t until_ns = next_ping_ns(client) < deadline_ns ? next_ping_ns(client) : deadline_ns;
        short waits = client->out && !client->deaf ? POLLIN | POLLOUT : POLLIN;
        short events = pro_wait(client->fd, waits, until_ns);
        last = pro_now_ns() >= deadline_ns;
        if (events & POLLOUT) flush(client);
        if (events & ~POLLOUT && !fill(client, out_error)) return PRO_BROKEN;
    }
}

enum pro_result pro_receive(struct pro_client *client, int timeout_ms, Fovea__Message **out_message,
                            char out_error[PRO_ERROR_SIZE])
{
    return receive(client, pro_deadline_ns(timeout_ms), out_message, out_error);
}

/* --- life --- */

static bool greet(struct pro_client *client, const Fovea__Hello *hello, uint64_t deadline_ns, int timeout_ms,
                  char out_error[PRO_ERROR_SIZE])
{
    Fovea__Hello body = *hello;
    Fovea__Message message = FOVEA__MESSAGE__INIT;
    body.version = PRO_VERSION;
    message.body_case = FOVEA__MESSAGE__BODY_HELLO;
    message.hello = &body;
    if (fovea__message__get_packed_size(&message) > PRO_MAX_TO_DAEMON)
        return pro_fail(out_error, "a Hello of more than %d bytes", PRO_MAX_TO_DAEMON);
    if (!start(client, &message)) return pro_fail(out_error, "memory is short");

    Fovea__Message *welcome;
    enum pro_result result = receive(client, deadline_ns, &welcome, out_error);
    if (result == PRO_MORE)
        return pro_fail(out_error, "%s has not answered within %g s", client->name, timeout_ms / 1e3);
    if (result == PRO_BROKEN) return false;
    client->welcome = welcome;
    return true;
}

struct pro_client *pro_connect(const struct pro_address *address, const Fovea__Hello *hello, int timeout_ms,
                               bool wait_for_daemon, char out_error[PRO_ERROR_SIZE])
{
    uint64_t deadline_ns = pro_deadline_ns(timeout_ms);
    struct pro_client *client = calloc(1, sizeof *client);
    if (!client) {
        pro_fail(out_error, "memory is short");
        return NULL;
    }
    pro_address_print(address, client->name, sizeof client->name);
    pro_reader_init(&client->reader, PRO_MAX_TO_CLIENT);
    client->encoding = hello->tiles;
    client->burst = hello->window > 0 && hello->window / 2 < BURST ? (hello->window + 1) / 2 : BURST;
    client->fd = pro_dial(address, deadline_ns, wait_for_daemon, out_error);
    if (client->fd < 0 || !greet(client, hello, deadline_ns, timeout_ms, out_error)) {
        pro_disconnect(client);
        return NULL;
    }
    return client;
}

void pro_disconnect(struct pro_client *client)
{
    if (!client) return;
    if (client->fd >= 0) close(client->fd);
    if (client->welcome) fovea__message__free_unpacked(client->welcome, NULL);
    pro_picture_destroy(client->picture);
    pro_reader_finish(&client->reader);
    free(client->tile);
    free(client->out);
    free(client);
}

const Fovea__Welcome *pro_welcome(const struct pro_client *client)
{
    return client->welcome->welcome;
}

int pro_client_fd(const struct pro_client *client)
{
    return client->fd;
}

const struct pro_picture *pro_picture(const struct pro_client *client)
{
    return client->picture;
}

bool pro_clock(const struct pro_client *client, uint64_t *out_round_trip_ns, int64_t *out_offset_ns)
{
    if (!client->clock.known) return false;
    *out_round_trip_ns = client->clock.round_trip_ns;
    *out_offset_ns = client->clock.offset_ns;
    return true;
}
