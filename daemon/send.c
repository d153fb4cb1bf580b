/* The messages that a client is sent, chosen and built when it can take them. */
#include <stdlib.h>

#include "paint.h"
#include "send.h"
#include "tiles.h"

static bool is_welcome_due(struct dmn_client *client)
{
    return client->welcome_due;
}

static uint8_t *welcome(struct dmn_client *client, size_t *out_count)
{
    const struct dmn_handles *handles = client->handles;
    Fovea__Welcome welcome = FOVEA__WELCOME__INIT;
    struct dmn_gaze_status gaze;
    struct dmn_work work;

    client->welcome_due = false;
    dmn_gaze_status(handles->gaze, &gaze);
    dmn_painter_work(handles->painter, &work);
    welcome.version = PRO_VERSION;
    welcome.server = "fovead " FOVEAD_VERSION;
    welcome.width = (uint32_t)handles->options->render.width;
    welcome.height = (uint32_t)handles->options->render.height;
    welcome.tile_size = RND_TILE;
    welcome.levels = (uint32_t)client->picture->pyramid.levels;
    welcome.generation = work.asked;
    welcome.scene = (char *)client->picture->scene.line;
    welcome.gaze_source = gaze.source.description;
    welcome.distribution = (char *)handles->options->render.distribution->name;
    welcome.frozen = gaze.frozen;
    return dmn_client_pack(client, FOVEA__MESSAGE__BODY_WELCOME, &welcome, out_count);
}

static bool has_answer(struct dmn_client *client)
{
    return client->answers;
}

static uint8_t *answer(struct dmn_client *client, size_t *out_count)
{
    struct dmn_answer *answer = &client->answer[client->first_answer];
    Fovea__Done done = FOVEA__DONE__INIT;
    Fovea__Pong pong = FOVEA__PONG__INIT;

    client->first_answer = (client->first_answer + 1) % DMN_ANSWERS;
    client->answers--;
    if (!answer->is_done) {
        pong.client_ns = answer->client_ns;
        pong.daemon_ns = dmn_clock_ns(client->handles);
        return dmn_client_pack(client, FOVEA__MESSAGE__BODY_PONG, &pong, out_count);
    }
    done.request = answer->request;
    done.ok = answer->good;
    done.text = answer->text;
    done.generation = answer->generation;
    done.n_camera = answer->generation ? 3 : 0;
    done.camera = answer->camera;
    return dmn_client_pack(client, FOVEA__MESSAGE__BODY_DONE, &done, out_count);
}

static bool is_gaze_due(struct dmn_client *client)
{
    return client->wants_gaze && dmn_gaze_has_next(client->handles->gaze, client->gaze_cursor);
}

static uint8_t *gaze(struct dmn_client *client, size_t *out_count)
{
    Fovea__Gaze gaze = FOVEA__GAZE__INIT;
    struct dmn_gaze_sample sample;

    if (!dmn_gaze_next(client->handles->gaze, &client->gaze_cursor, &sample)) return NULL;
    gaze.sequence = sample.sequence;
    gaze.n_direction = 3;
    gaze.direction = sample.direction;
    gaze.valid = sample.valid;
    gaze.frozen = sample.frozen;
    gaze.device_ns = sample.device_ns;
    gaze.arrival_ns = sample.arrival_ns;
    gaze.n_head = sample.has_head ? 4 : 0;
    gaze.head = sample.head;
    gaze.n_aim = 3;
    gaze.aim = sample.decision.direction;
    gaze.spread = sample.decision.spread;
    gaze.state = (char *)trk_state_name(sample.decision.state);
    gaze.source = (char *)sample.decision.source;
    gaze.why = (char *)sample.decision.why;
    gaze.sensor_ns = sample.sensor_ns;
    return dmn_client_pack(client, FOVEA__MESSAGE__BODY_GAZE, &gaze, out_count);
}

static bool is_stats_due(struct dmn_client *client)
{
    return client->stats_due;
}

static Fovea__Tracker tracker_of(const struct trk_status *source)
{
    Fovea__Tracker tracker = FOVEA__TRACKER__INIT;

    tracker.present = source->present;
    tracker.connections = source->connections;
    tracker.losses = source->losses;
    tracker.rate_hz = source->rate_hz;
    tracker.has_clock = source->has_clock;
    tracker.jitter_ms = source->jitter_ms;
    tracker.drift_ppm = source->drift_ppm;
    return tracker;
}

static uint8_t *stats(struct dmn_client *client, size_t *out_count)
{
    const struct dmn_handles *handles = client->handles;
    const struct dmn_picture *picture = client->picture;
    Fovea__Stats stats = FOVEA__STATS__INIT;
    Fovea__Tracker tracker;
    struct dmn_gaze_status gaze;
    struct dmn_work work;
    float camera[3];

    client->stats_due = false;
    dmn_painter_work(handles->painter, &work);
    dmn_gaze_status(handles->gaze, &gaze);
    tracker = tracker_of(&gaze.source);
    stats.time_ns = work.now_ns;
    stats.samples = work.paths;
    stats.samples_per_second = work.paths_per_second;
    stats.rays = work.rays;
    stats.tiles = picture->tiles;
    if (picture->generation == work.generation) { /* else nothing is known of the tiles yet */
        stats.tiles_visited = picture->visited;
        stats.tiles_converged = picture->converged;
        stats.tiles_settled = picture->settled;
    }
    stats.gaze_samples = gaze.samples;
    stats.gaze_valid = gaze.valid;
    stats.batch_ms = work.batch_seconds * 1e3;
    stats.gaze_to_batch_ms = work.gaze_to_batch_seconds * 1e3;
    stats.clients = client->clients->count;
    stats.tiles_sent = client->serial;
    stats.frozen = gaze.frozen;
    stats.finished = gaze.ended;
    stats.not_finite = work.not_finite;
    stats.gaze_source = gaze.source.description;
    stats.recording = gaze.recording;
    stats.recorded = gaze.recorded;
    stats.recording_lost = gaze.lost;
    stats.recording_error = gaze.recording_error;
    stats.generation = work.generation;
    for (int i = 0; i < 3; i++) camera[i] = (float)work.camera[i];
    stats.n_camera = 3;
    stats.camera = camera;
    stats.scene = (char *)picture->scene.line;
    stats.refused = (char *)picture->scene.refused;
    if (gaze.source.is_device) stats.tracker = &tracker;
    return dmn_client_pack(client, FOVEA__MESSAGE__BODY_STATS, &stats, out_count);
}

static bool is_viewing_due(struct dmn_client *client)
{
    return client->wants_viewing && client->told != client->clients->steering.changes + 1;
}

static uint8_t *viewing(struct dmn_client *client, size_t *out_count)
{
    const struct dmn_steering *steering = &client->clients->steering;
    Fovea__Viewing viewing = FOVEA__VIEWING__INIT;

    client->told = steering->changes + 1;
    if (steering->first) {
        viewing.yours = steering->first == &client->shown;
        viewing.who = (char *)steering->first->who;
        viewing.headset = steering->first->headset;
    } else if (client->handles->options->virtual_clock) {
        viewing.who = "the virtual clock";
    }
    return dmn_client_pack(client, FOVEA__MESSAGE__BODY_VIEWING, &viewing, out_count);
}

static bool is_bye_due(struct dmn_client *client)
{
    return client->bye_due;
}

static uint8_t *bye(struct dmn_client *client, size_t *out_count)
{
    Fovea__Bye content = FOVEA__BYE__INIT;

    client->bye_due = false;
    return dmn_client_pack(client, FOVEA__MESSAGE__BODY_BYE, &content, out_count);
}

/* --- in this order --- */

struct event {
    bool (*is_due)(struct dmn_client *client);
    /* Build and pack the message, which is then no longer due. NULL if there is none after all, or memory is
     * short. */
    uint8_t *(*build)(struct dmn_client *client, size_t *out_count);
    bool at_end; /* sent only when the session ends */
};

static const struct event EVENTS[] = {
    {is_welcome_due, welcome, false}, {has_answer, answer, false},  {is_viewing_due, viewing, false},
    {is_gaze_due, gaze, false},       {is_stats_due, stats, false}, {dmn_tile_is_due, dmn_tile_pack, false},
    {is_bye_due, bye, true},
};
enum { KINDS = sizeof(EVENTS) / sizeof(*EVENTS) };

static bool is_due(const struct event *event, struct dmn_client *client)
{
    return client->greeted && event->at_end == client->ending && event->is_due(client);
}

bool dmn_send_is_due(struct dmn_client *client)
{
    bool due = false;

    for (int i = 0; i < KINDS && !due; i++) due = is_due(&EVENTS[i], client);
    return due;
}

uint8_t *dmn_send_next(struct dmn_client *client, size_t *out_count)
{
    uint8_t *message = NULL;

    for (int i = 0; i < KINDS && !message; i++)
        while (!message && is_due(&EVENTS[i], client)) message = EVENTS[i].build(client, out_count);
    return message;
}

uint8_t *dmn_send_farewell(const char *why, size_t headroom, size_t *out_count)
{
    Fovea__Message message = FOVEA__MESSAGE__INIT;
    Fovea__Done done = FOVEA__DONE__INIT;

    done.text = (char *)why;
    message.body_case = FOVEA__MESSAGE__BODY_DONE;
    message.done = &done;
    return pro_pack_message(&message, headroom, out_count);
}
