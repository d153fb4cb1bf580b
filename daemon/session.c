/* One client, from Hello to the end. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "hello.h"
#include "requests.h"
#include "session.h"

/* A client has 5 s to say Hello, and to finish a message that it began. They are counted in calls of
 * dmn_session_check(): if the daemon runs late, it takes what the client sent in time before the next call.
 */
enum { PATIENCE = 5 * DMN_CHECKS_A_SECOND };

struct dmn_client *dmn_session_create(const struct dmn_client_options *options)
{
    struct dmn_client *client = calloc(1, sizeof(*client));

    if (!client) return NULL;
    client->options = *options;
    client->clients = options->clients;
    client->handles = options->clients->handles;
    client->picture = options->clients->picture;
    snprintf(client->peer, sizeof(client->peer), "%s", options->peer);
    client->options.peer = client->peer;
    client->shown.who = client->peer;
    client->clients->count++;
    return client;
}

void dmn_session_destroy(struct dmn_client *client)
{
    if (!client) return;
    dmn_client_show(client, NULL, false, false);
    client->clients->count--;
    if (client->held) fovea__message__free_unpacked(client->held, NULL);
    free(client->sent);
    free(client);
}

bool dmn_session_is_ready(const struct dmn_client *client)
{
    return !client->held;
}

bool dmn_session_take(struct dmn_client *client, Fovea__Message *message, char out_error[PRO_ERROR_SIZE])
{
    bool good = dmn_request_take(client, message, out_error);

    if (message != client->held) fovea__message__free_unpacked(message, NULL);
    client->checks = 0;
    return good;
}

bool dmn_session_check(struct dmn_client *client, bool partial, char out_error[PRO_ERROR_SIZE])
{
    if (client->held && dmn_now_ns() < client->turn_ns) return true;
    if (client->held) {
        client->checks = 0;
        return dmn_hello_turn(client, out_error);
    }
    if (partial && !client->partial) client->checks = 0;
    client->partial = partial;
    if (++client->checks < PATIENCE) return true;
    if (!client->greeted) return dmn_client_fail(out_error, "it did not say hello");
    if (partial) return dmn_client_fail(out_error, "it began a message and did not end it");
    return true;
}

void dmn_session_end(struct dmn_client *client)
{
    client->ending = true;
    /* A client that was not welcomed gets no Bye: its connection just ends. */
    client->bye_due = client->greeted && !client->welcome_due;
}

void dmn_session_stats(struct dmn_client *client)
{
    client->stats_due = client->wants_stats;
}

void dmn_session_done(struct dmn_client *client, const struct dmn_job *job)
{
    char error[PRO_ERROR_SIZE];

    client->jobs--; /* this makes room for its answer */
    (void)dmn_client_done(client, job->request, job->good, job->text, error);
}
