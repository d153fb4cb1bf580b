/* The messages that clients send. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "hello.h"
#include "image_options.h"
#include "job_kinds.h"
#include "paint.h"
#include "requests.h"

/* Take where on the screen a view is. A window may reach beyond the screen, but not far. */
static bool take_screen(const Fovea__View *view, float out_screen[4])
{
    if (view->n_screen != 4) return false;
    for (int i = 0; i < 4; i++)
        if (!(fabsf(view->screen[i]) <= 100 && (i < 2 || view->screen[i] > 0))) return false;
    memcpy(out_screen, view->screen, 4 * sizeof(*out_screen));
    return true;
}

static bool take_view(struct dmn_client *client, Fovea__Message *message, char out_error[PRO_ERROR_SIZE])
{
    const Fovea__View *view = message->view;
    struct trk_view shown = {.fov = {view->fov_x, view->fov_y}, .screen = {0, 0, 1, 1}};
    float square = 0;

    if (view->n_orientation == 0) {
        dmn_client_show(client, NULL, false, false);
        return true;
    }
    if (view->n_orientation != 4) return dmn_client_fail(out_error, "a view without orientation");
    for (int i = 0; i < 4; i++) square += view->orientation[i] * view->orientation[i];
    if (!isfinite(square) || square < 1e-6f || !(view->fov_x > 0 && view->fov_x < (float)M_PI) ||
        !(view->fov_y > 0 && view->fov_y < (float)M_PI))
        return dmn_client_fail(out_error, "a view with an orientation or a field of view that cannot be");
    for (int i = 0; i < 4; i++) shown.orientation[i] = view->orientation[i] / sqrtf(square);
    if (view->n_screen != 0 && !take_screen(view, shown.screen))
        return dmn_client_fail(out_error, "a view whose place on the screen cannot be");
    dmn_client_show(client, &shown, view->headset, !view->unasked);
    return true;
}

static bool take_pointer(struct dmn_client *client, Fovea__Message *message, char out_error[PRO_ERROR_SIZE])
{
    if (message->pointer->n_direction != 3) return dmn_client_fail(out_error, "a pointer without direction");
    dmn_gaze_push(client->handles->gaze, message->pointer->direction);
    return true;
}

static bool take_freeze(struct dmn_client *client, Fovea__Message *message, char out_error[PRO_ERROR_SIZE])
{
    (void)out_error;
    dmn_gaze_freeze(client->handles->gaze, message->freeze->frozen);
    return true;
}

static bool take_acknowledge(struct dmn_client *client, Fovea__Message *message,
                             char out_error[PRO_ERROR_SIZE])
{
    uint64_t serial = message->acknowledge->serial;

    if (serial > client->serial)
        return dmn_client_fail(out_error, "it acknowledges a tile that was not sent");
    if (serial > client->acknowledged) client->acknowledged = serial;
    return true;
}

static bool take_ping(struct dmn_client *client, Fovea__Message *message, char out_error[PRO_ERROR_SIZE])
{
    struct dmn_answer pong = {.client_ns = message->ping->client_ns};

    return dmn_client_answer(client, &pong, out_error);
}

/* Take the path of a request. False, and why in job->text, if it cannot be written. */
static bool take_path(struct dmn_job *job, const char *path, bool of_picture)
{
    const size_t length = strlen(path);

    if (path[0] != '/' || length >= sizeof(job->path) || (of_picture && !dmn_image_is_named(path))) {
        snprintf(job->text, sizeof(job->text), "an absolute path%s is needed",
                 of_picture ? " that ends in " DMN_IMAGE_ENDS : "");
        return false;
    }
    memcpy(job->path, path, length + 1);
    return true;
}

static bool take_save(struct dmn_client *client, Fovea__Message *message, char out_error[PRO_ERROR_SIZE])
{
    const Fovea__Save *save = message->save;
    struct dmn_job job = {.kind = &dmn_job_save,
                          .request = save->request,
                          .exposure = {save->exposure_auto, (double)save->exposure}};

    if (!(fabsf(save->exposure) <= 64))
        return dmn_client_fail(out_error, "a save with an exposure that cannot be");
    if (!take_path(&job, save->path, true))
        return dmn_client_done(client, job.request, false, job.text, out_error);
    return dmn_client_ask(client, &job, out_error);
}

static bool take_record(struct dmn_client *client, Fovea__Message *message, char out_error[PRO_ERROR_SIZE])
{
    const Fovea__Record *record = message->record;
    struct dmn_job job = {.kind = record->on ? &dmn_job_record : &dmn_job_record_end,
                          .request = record->request,
                          .replace = record->replace};

    if (record->on && !take_path(&job, record->path, false))
        return dmn_client_done(client, job.request, false, job.text, out_error);
    return dmn_client_ask(client, &job, out_error);
}

static bool take_recentre(struct dmn_client *client, Fovea__Message *message, char out_error[PRO_ERROR_SIZE])
{
    const Fovea__Recentre *recentre = message->recentre;
    struct dmn_job job = {
        .kind = &dmn_job_recentre, .request = recentre->request, .has_target = recentre->n_direction};
    double square = 0;

    if (recentre->n_direction != 0 && recentre->n_direction != 3)
        return dmn_client_fail(out_error, "a recentring without direction");
    for (size_t i = 0; i < recentre->n_direction; i++)
        square += (double)recentre->direction[i] * recentre->direction[i];
    if (recentre->n_direction && (!isfinite(square) || square < 1e-6))
        return dmn_client_fail(out_error, "a recentring to no direction");
    for (size_t i = 0; i < recentre->n_direction; i++)
        job.target[i] = (float)(recentre->direction[i] / sqrt(square));
    return dmn_client_ask(client, &job, out_error);
}

static bool take_move(struct dmn_client *client, Fovea__Message *message, char out_error[PRO_ERROR_SIZE])
{
    const Fovea__Move *move = message->move;
    struct dmn_answer answer = {.is_done = true, .request = move->request};
    double camera[3] = {0};

    for (size_t i = 0; i < 3 && move->n_camera == 3; i++) camera[i] = (double)move->camera[i];
    if (move->n_camera != 3 || !dmn_camera_is_in_range(camera))
        return dmn_client_fail(out_error, "a move to nowhere");
    if (client->handles->options->virtual_clock)
        return dmn_client_done(
            client, move->request, false,
            "the camera stays: under the virtual clock a picture does not depend on clients", out_error);
    answer.generation = dmn_painter_move(client->handles->painter, camera, move->relative, camera);
    answer.good = answer.generation > 0;
    if (answer.good)
        snprintf(answer.text, sizeof(answer.text), "generation %llu, camera %.6g,%.6g,%.6g m",
                 (unsigned long long)answer.generation, camera[0], camera[1], camera[2]);
    else
        snprintf(answer.text, sizeof(answer.text), "the camera stays within %d m of the origin",
                 DMN_FARTHEST);
    for (int i = 0; i < 3; i++) answer.camera[i] = (float)camera[i];
    return dmn_client_answer(client, &answer, out_error);
}

/* --- who may send what --- */

struct request {
    Fovea__Message__BodyCase body;
    enum {
        STRANGER, /* only a client that has not said Hello */
        GUEST,    /* a client that has said Hello */
        OWNER,    /* a client for which files are written; others get a Done that says so */
    } from;
    bool (*take)(struct dmn_client *client, Fovea__Message *message, char out_error[PRO_ERROR_SIZE]);
    size_t number; /* of OWNER: offset of the request's number in the body */
};

static const struct request REQUESTS[] = {
    {FOVEA__MESSAGE__BODY_HELLO, STRANGER, dmn_hello_take, 0},
    {FOVEA__MESSAGE__BODY_VIEW, GUEST, take_view, 0},
    {FOVEA__MESSAGE__BODY_POINTER, GUEST, take_pointer, 0},
    {FOVEA__MESSAGE__BODY_FREEZE, GUEST, take_freeze, 0},
    {FOVEA__MESSAGE__BODY_ACKNOWLEDGE, GUEST, take_acknowledge, 0},
    {FOVEA__MESSAGE__BODY_SAVE, OWNER, take_save, offsetof(Fovea__Save, request)},
    {FOVEA__MESSAGE__BODY_PING, GUEST, take_ping, 0},
    {FOVEA__MESSAGE__BODY_RECENTRE, GUEST, take_recentre, 0},
    {FOVEA__MESSAGE__BODY_RECORD, OWNER, take_record, offsetof(Fovea__Record, request)},
    {FOVEA__MESSAGE__BODY_MOVE, GUEST, take_move, 0},
};

static const struct request *find(Fovea__Message__BodyCase body)
{
    for (size_t i = 0; i < sizeof(REQUESTS) / sizeof(*REQUESTS); i++)
        if (REQUESTS[i].body == body) return &REQUESTS[i];
    return NULL;
}

bool dmn_request_take(struct dmn_client *client, Fovea__Message *message, char out_error[PRO_ERROR_SIZE])
{
    const struct request *request = find(message->body_case);
    uint32_t number;

    if (!client->greeted && (!request || request->from != STRANGER))
        return dmn_client_fail(out_error, "it did not say hello first");
    if (!request) return dmn_client_fail(out_error, "it sent a message that clients do not send");
    if (client->greeted && request->from == STRANGER)
        return dmn_client_fail(out_error, "it said hello twice");
    if (request->from == OWNER && !client->options.may_save) {
        memcpy(&number, (const char *)message->hello + request->number,
               sizeof(number)); /* the bodies are a union of
                                                                                            pointers */
        return dmn_client_done(client, number, false, "files are written only for clients on a Unix socket",
                               out_error);
    }
    return request->take(client, message, out_error);
}
