/* The connection of a command to the daemon: requests and their answers. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "ctl.h"

struct pro_client *ctl_connect(const struct ctl *ctl, Fovea__Encoding tiles, bool gaze, bool stats)
{
    Fovea__Hello hello = FOVEA__HELLO__INIT;
    char name[64], error[PRO_ERROR_SIZE];
    const char *token = getenv("FOVEAD_TOKEN");
    struct pro_address address = ctl->address;
    struct pro_client *client;
    double patience_s = ctl->wait ? CTL_START_S : fmin(CTL_PATIENCE_S, ctl->within);

    if (!ctl->has_address && !pro_address_parse(NULL, &address, error)) return ctl_fail("%s", error), NULL;
    snprintf(name, sizeof(name), "foveactl %s " FOVEAD_VERSION, ctl->command);
    hello.client = name;
    hello.tiles = tiles;
    hello.gaze = gaze;
    hello.stats = stats;
    hello.viewing = true;
    if (token) hello.token = (char *)token;
    client = pro_connect(&address, &hello, (int)(patience_s * 1000), ctl->wait, error);
    if (!client) ctl_fail("%s", error);
    return client;
}

Fovea__Message *ctl_await(struct pro_client *client, Fovea__Message__BodyCase body, uint64_t from_ns,
                          double seconds)
{
    uint64_t end_ns = from_ns + (uint64_t)(seconds * 1e9), now_ns;
    char error[PRO_ERROR_SIZE];

    while ((now_ns = dmn_now_ns()) < end_ns) {
        Fovea__Message *message;
        enum pro_result result = pro_receive(client, (int)((end_ns - now_ns) / 1000000 + 1), &message, error);

        if (result == PRO_BROKEN) {
            ctl_fail("%s", error);
            return NULL;
        }
        if (result != PRO_MESSAGE) continue;
        if (message->body_case == body) return message;
        fovea__message__free_unpacked(message, NULL);
    }
    ctl_fail("no answer within %g s", seconds);
    return NULL;
}

bool ctl_request(struct pro_client *client, const Fovea__Message *message, double seconds)
{
    char error[PRO_ERROR_SIZE];
    Fovea__Message *answer;
    bool good;

    if (!pro_send(client, message, error)) return ctl_fail("%s", error);
    if (!(answer = ctl_await(client, FOVEA__MESSAGE__BODY_DONE, dmn_now_ns(), seconds))) return false;
    good = answer->done->ok;
    if (good)
        dmn_print(stdout, "%s\n", answer->done->text);
    else
        ctl_fail("%s", answer->done->text);
    fflush(stdout);
    fovea__message__free_unpacked(answer, NULL);
    return good;
}

/* The daemon takes messages in order, so a Pong tells that it has taken those before. */
bool ctl_tell(struct pro_client *client, const Fovea__Message *message)
{
    Fovea__Message message_ping = FOVEA__MESSAGE__INIT;
    Fovea__Ping ping = FOVEA__PING__INIT;
    char error[PRO_ERROR_SIZE];
    uint64_t client_ns, sent_ns = dmn_now_ns();

    /* The Pings of the client library never have this time. */
    ping.client_ns = UINT64_MAX;
    message_ping.body_case = FOVEA__MESSAGE__BODY_PING;
    message_ping.ping = &ping;
    if (!pro_send(client, message, error) || !pro_send(client, &message_ping, error))
        return ctl_fail("%s", error);
    do {
        Fovea__Message *pong = ctl_await(client, FOVEA__MESSAGE__BODY_PONG, sent_ns, CTL_PATIENCE_S);

        if (!pong) return false;
        client_ns = pong->pong->client_ns;
        fovea__message__free_unpacked(pong, NULL);
    } while (client_ns != UINT64_MAX);
    return true;
}
