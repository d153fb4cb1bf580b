/* What every file that serves a client does with it. */
#include <stdarg.h>
#include <stdio.h>

#include "client.h"

bool dmn_client_fail(char out_error[PRO_ERROR_SIZE], const char *format, ...)
{
    va_list args;

    va_start(args, format);
    vsnprintf(out_error, PRO_ERROR_SIZE, format, args);
    va_end(args);
    return false;
}

static bool has_room(const struct dmn_client *client, char out_error[PRO_ERROR_SIZE])
{
    return client->answers + client->jobs < DMN_ANSWERS ||
           dmn_client_fail(out_error, "it asks for more and does not read the answers");
}

bool dmn_client_answer(struct dmn_client *client, const struct dmn_answer *answer,
                       char out_error[PRO_ERROR_SIZE])
{
    if (!has_room(client, out_error)) return false;
    client->answer[(client->first_answer + client->answers++) % DMN_ANSWERS] = *answer;
    return true;
}

bool dmn_client_done(struct dmn_client *client, uint32_t request, bool good, const char *text,
                     char out_error[PRO_ERROR_SIZE])
{
    struct dmn_answer answer = {.is_done = true, .request = request, .good = good};

    snprintf(answer.text, sizeof(answer.text), "%s", text);
    return dmn_client_answer(client, &answer, out_error);
}

bool dmn_client_ask(struct dmn_client *client, struct dmn_job *job, char out_error[PRO_ERROR_SIZE])
{
    job->client = client->options.number;
    if (!has_room(client, out_error)) return false;
    if (!dmn_jobs_ask(client->handles->jobs, job))
        return dmn_client_done(client, job->request, false, "too many files are waiting to be written",
                               out_error);
    client->jobs++;
    return true;
}

void dmn_client_show(struct dmn_client *client, const struct trk_view *view_or_null, bool headset, bool asks)
{
    struct dmn_steering *steering = &client->clients->steering;
    const unsigned changes = steering->changes;

    /* Under the virtual clock a picture does not depend on clients. */
    if (client->handles->options->virtual_clock) return;
    dmn_steering_show(steering, &client->shown, view_or_null, headset, asks);
    if (steering->first != &client->shown && steering->changes == changes) return;
    dmn_gaze_view(client->handles->gaze, steering->first ? &steering->first->view : NULL,
                  steering->first && steering->first->headset);
}

uint8_t *dmn_client_pack(const struct dmn_client *client, Fovea__Message__BodyCase body, void *content,
                         size_t *out_count)
{
    Fovea__Message message = FOVEA__MESSAGE__INIT;

    message.body_case = body;
    message.hello = content; /* the bodies are a union of pointers */
    return pro_pack_message(&message, client->options.headroom, out_count);
}
