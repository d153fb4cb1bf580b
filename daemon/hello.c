/* A client's Hello, and the check of its token. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "hello.h"

/* Tiles that may be under way unacknowledged, if the client does not ask for a number; and the largest such
 * number. */
enum { WINDOW = 64, MOST_WINDOW = 1024 };

/* Append what the client calls itself to its name in the log, without control characters. */
static void note_name(struct dmn_client *client, const char *name)
{
    size_t length = strlen(client->peer), room = sizeof(client->peer) - 1;

    if (*name && length + 2 < room) length += (size_t)sprintf(client->peer + length, ", ");
    for (; *name && length < room; name++)
        if (*name >= ' ' && *name <= '~') client->peer[length++] = *name;
    client->peer[length] = '\0';
}

/* Note what the client wants, now that it may come in. */
static bool greet(struct dmn_client *client, const Fovea__Hello *hello, char out_error[PRO_ERROR_SIZE])
{
    const bool wants_tiles = hello->tiles != FOVEA__ENCODING__ENCODING_NONE;

    if (wants_tiles && !pro_encodes(hello->tiles))
        return dmn_client_fail(out_error, "it wants tiles in an unknown encoding, %d", (int)hello->tiles);
    if (wants_tiles && !(client->sent = calloc(client->picture->pyramid.count, sizeof(*client->sent))))
        return dmn_client_fail(out_error, "out of memory");
    client->encoding = hello->tiles;
    client->window = hello->window ? hello->window : WINDOW;
    if (client->window > MOST_WINDOW) client->window = MOST_WINDOW;
    client->finest = dmn_pyramid_finest(&client->picture->pyramid, hello->widest);
    client->wants_gaze = hello->gaze;
    client->wants_stats = client->stats_due = hello->stats;
    client->wants_viewing = hello->viewing;
    return client->greeted = client->welcome_due = true;
}

bool dmn_hello_take(struct dmn_client *client, Fovea__Message *message, char out_error[PRO_ERROR_SIZE])
{
    const Fovea__Hello *hello = message->hello;
    struct dmn_gate *gate = &client->clients->gate;
    const char *token = client->options.token;
    uint64_t now_ns = dmn_now_ns();

    note_name(client, hello->client);
    if (hello->version != PRO_VERSION)
        return dmn_client_fail(out_error, "it speaks version %u of the protocol, not %d", hello->version,
                               PRO_VERSION);
    if (!token) return greet(client, hello, out_error);
    if (!*hello->token)
        return dmn_client_fail(out_error, "it sent no token: set FOVEAD_TOKEN in its environment");
    client->turn_ns = dmn_gate_turn(gate, client->options.key, now_ns);
    if (!client->turn_ns)
        return dmn_client_fail(out_error,
                               "too many wrong tokens came from its address: try again in some seconds");
    if (client->turn_ns > now_ns) {
        client->held = message;
        return true;
    }
    if (dmn_gate_knows(token, hello->token)) return greet(client, hello, out_error);
    dmn_gate_wrong(gate, client->options.key, now_ns);
    return dmn_client_fail(out_error, "its token is wrong");
}

bool dmn_hello_turn(struct dmn_client *client, char out_error[PRO_ERROR_SIZE])
{
    Fovea__Message *message = client->held;
    bool right = dmn_gate_knows(client->options.token, message->hello->token);
    bool good =
        right ? greet(client, message->hello, out_error) : dmn_client_fail(out_error, "its token is wrong");

    if (right) dmn_gate_right(&client->clients->gate, client->options.key);
    client->held = NULL;
    fovea__message__free_unpacked(message, NULL);
    return good;
}
