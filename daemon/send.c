/* What a client is sent, chosen at the moment it can take it. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "session_internal.h"

static uint8_t *pack(struct dmn_session *session, Fovea__Message__BodyCase body, void *content,
                     size_t *out_count)
{
    Fovea__Message message = FOVEA__MESSAGE__INIT;

    message.body_case = body;
    message.hello = content; /* the bodies are a union of pointers */
    return pro_pack(&message, session->options.headroom, out_count);
}

static uint64_t clock_now(const struct dmn_common *common)
{
    struct dmn_work work;

    if (!common->options->virtual_clock) return dmn_now_ns();
    dmn_painter_work(common->painter, &work);
    return work.now_ns;
}

static uint8_t *welcome(struct dmn_session *session, size_t *out_count)
{
    const struct dmn_common *common = session->common;
    Fovea__Welcome welcome = FOVEA__WELCOME__INIT;
    struct dmn_gaze_state state;
    struct dmn_work work;

    session->welcome_due = false;
    dmn_gaze_state(common->gaze, &state);
    dmn_painter_work(common->painter, &work);
    welcome.version = PRO_VERSION;
    welcome.server = "fovead " FOVEAD_VERSION;
    welcome.width = (uint32_t)common->options->render.width;
    welcome.height = (uint32_t)common->options->render.height;
    welcome.tile_size = RND_TILE;
    welcome.levels = (uint32_t)common->pyramid.levels;
    welcome.generation = work.asked;
    welcome.scene = (char *)common->words.line;
    welcome.gaze_source = state.source.description;
    welcome.distribution = (char *)common->options->render.distribution->name;
    welcome.frozen = state.frozen;
    return pack(session, FOVEA__MESSAGE__BODY_WELCOME, &welcome, out_count);
}

static uint8_t *answer(struct dmn_session *session, size_t *out_count)
{
    struct dmn_reply *reply = &session->reply[session->first_reply];

    session->first_reply = (session->first_reply + 1) % DMN_REPLIES;
    session->replies--;
    if (reply->is_done) {
        Fovea__Done done = FOVEA__DONE__INIT;

        done.request = reply->request;
        done.ok = reply->good;
        done.text = reply->text;
        done.generation = reply->generation;
        done.n_eye = reply->generation ? 3 : 0;
        done.eye = reply->eye;
        return pack(session, FOVEA__MESSAGE__BODY_DONE, &done, out_count);
    } else {
        Fovea__Pong pong = FOVEA__PONG__INIT;

        pong.client_ns = reply->client_ns;
        pong.daemon_ns = clock_now(session->common);
        return pack(session, FOVEA__MESSAGE__BODY_PONG, &pong, out_count);
    }
}

static uint8_t *bye(struct dmn_session *session, size_t *out_count)
{
    Fovea__Bye content = FOVEA__BYE__INIT;

    session->bye_due = false;
    return pack(session, FOVEA__MESSAGE__BODY_BYE, &content, out_count);
}

static uint8_t *gaze(struct dmn_session *session, size_t *out_count)
{
    Fovea__Gaze gaze = FOVEA__GAZE__INIT;
    struct dmn_gaze_sample sample;

    if (!dmn_gaze_next(session->common->gaze, &session->gaze_cursor, &sample)) return NULL;
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
    return pack(session, FOVEA__MESSAGE__BODY_GAZE, &gaze, out_count);
}

static uint8_t *stats(struct dmn_session *session, size_t *out_count)
{
    const struct dmn_common *common = session->common;
    Fovea__Stats stats = FOVEA__STATS__INIT;
    Fovea__Tracker tracker = FOVEA__TRACKER__INIT;
    struct dmn_gaze_state state;
    struct dmn_work work;
    float eye[3];

    session->stats_due = false;
    dmn_painter_work(common->painter, &work);
    dmn_gaze_state(common->gaze, &state);
    stats.time_ns = work.now_ns;
    stats.samples = work.paths;
    stats.samples_per_second = work.paths_per_second;
    stats.rays = work.rays;
    stats.tiles = (uint32_t)(common->pyramid.level[0].columns * common->pyramid.level[0].rows);
    if (common->generation == work.generation) { /* else none that has been looked at */
        stats.tiles_visited = common->visited;
        stats.tiles_converged = common->converged;
        stats.tiles_settled = common->settled;
    }
    stats.gaze_samples = state.samples;
    stats.gaze_valid = state.valid;
    stats.batch_ms = work.batch_seconds * 1e3;
    stats.gaze_to_batch_ms = work.gaze_to_batch_seconds * 1e3;
    stats.clients = common->clients;
    stats.tiles_sent = session->serial;
    stats.frozen = state.frozen;
    stats.finished = state.ended;
    stats.not_finite = work.not_finite;
    stats.gaze_source = state.source.description;
    stats.recording = state.recording;
    stats.recorded = state.recorded;
    stats.recording_lost = state.lost;
    stats.recording_error = state.recording_error;
    stats.generation = work.generation;
    for (int i = 0; i < 3; i++) eye[i] = (float)work.eye[i];
    stats.n_eye = 3;
    stats.eye = eye;
    stats.scene = (char *)common->words.line;
    stats.refused = (char *)common->words.refused;
    tracker.present = state.source.present;
    tracker.connections = state.source.connections;
    tracker.losses = state.source.losses;
    tracker.rate_hz = state.source.rate_hz;
    tracker.has_clock = state.source.has_clock;
    tracker.jitter_ms = state.source.jitter_ms;
    tracker.drift_ppm = state.source.drift_ppm;
    if (state.source.is_device) stats.tracker = &tracker;
    return pack(session, FOVEA__MESSAGE__BODY_STATS, &stats, out_count);
}

/* --- tiles --- */

/* The next tile of the plan; a new plan when the picture has changed since the last one. */
static const struct dmn_place *next_place(struct dmn_session *session)
{
    const struct dmn_common *common = session->common;

    if (!session->sent || session->serial - session->acknowledged >= session->window) return NULL;
    if (session->plan_version != common->version) {
        if (session->generation != common->generation)
            memset(session->sent, 0, common->pyramid.count * sizeof(*session->sent));
        session->generation = common->generation;
        session->planned =
            dmn_next(&common->pyramid, session->sent, common->direction, DMN_PLAN, session->plan);
        session->next = 0;
        session->plan_version = common->version;
    }
    if (session->next == session->planned && common->gaze_sequence > session->gaze_sequence) {
        /* No tile has changed much. Then the one that the eye sees, so that every gaze is answered. */
        session->gaze_sequence = common->gaze_sequence;
        session->next = 0;
        session->planned =
            dmn_seen_at(&common->pyramid, session->sent, common->direction, &session->plan[0]) ? 1 : 0;
    }
    return session->next < session->planned ? &session->plan[session->next] : NULL;
}

static uint8_t *tile(struct dmn_session *session, const struct dmn_place *place, size_t *out_count)
{
    const struct dmn_tile *known = &session->common->pyramid.tile[place->index];
    float rgb[RND_TILE * RND_TILE * 3];
    Fovea__Tile tile = FOVEA__TILE__INIT;
    struct rnd_tile state;
    uint8_t *frame;

    session->next++;
    if (!rnd_render_read(session->common->render, place->level, place->x, place->y, rgb, &state)) return NULL;
    /* The plan, and what is known of the tile, are of the picture before this one. */
    if (state.generation != session->generation) return NULL;
    tile.data.data = pro_encode(session->encoding, rgb, RND_TILE, &tile.data.len);
    if (!tile.data.data) return NULL;
    session->sent[place->index] = (struct dmn_tile){state.samples, known->converged, known->settled};
    tile.serial = ++session->serial;
    tile.generation = session->generation;
    tile.level = (uint32_t)place->level;
    tile.x = (uint32_t)place->x;
    tile.y = (uint32_t)place->y;
    tile.encoding = session->encoding;
    tile.samples = state.samples;
    tile.error = state.error;
    tile.converged = known->converged;
    tile.settled = known->settled;
    if (state.gaze_sequence > session->gaze_sequence) session->gaze_sequence = state.gaze_sequence;
    tile.gaze_sequence = state.gaze_sequence;
    tile.gaze_ns = state.gaze_ns;
    tile.aimed_ns = state.aimed_ns;
    tile.encoded_ns = clock_now(session->common);
    frame = pack(session, FOVEA__MESSAGE__BODY_TILE, &tile, out_count);
    free(tile.data.data);
    return frame;
}

/* --- in this order --- */

bool dmn_session_wants(struct dmn_session *session)
{
    if (session->ending) return session->bye_due;
    if (!session->greeted) return false;
    return session->welcome_due || session->replies || session->stats_due ||
           (session->wants_gaze && dmn_gaze_has_next(session->common->gaze, session->gaze_cursor)) ||
           next_place(session);
}

uint8_t *dmn_session_frame(struct dmn_session *session, size_t *out_count)
{
    const struct dmn_place *place;
    uint8_t *frame;

    if (session->ending) return session->bye_due ? bye(session, out_count) : NULL;
    if (!session->greeted) return NULL;
    if (session->welcome_due) return welcome(session, out_count);
    if (session->replies) return answer(session, out_count);
    if (session->wants_gaze && (frame = gaze(session, out_count))) return frame;
    if (session->stats_due) return stats(session, out_count);
    /* A tile that cannot be read has nothing in it: the next one. */
    while ((place = next_place(session)))
        if ((frame = tile(session, place, out_count))) return frame;
    return NULL;
}

void dmn_session_end(struct dmn_session *session)
{
    session->ending = true;
    /* A client that was not welcomed yet is not told: its connection just ends. */
    session->bye_due = session->greeted && !session->welcome_due;
}

uint8_t *dmn_farewell(const char *why, size_t headroom, size_t *out_count)
{
    Fovea__Message message = FOVEA__MESSAGE__INIT;
    Fovea__Done done = FOVEA__DONE__INIT;

    done.text = (char *)why;
    message.body_case = FOVEA__MESSAGE__BODY_DONE;
    message.done = &done;
    return pro_pack(&message, headroom, out_count);
}

void dmn_session_stats(struct dmn_session *session)
{
    session->stats_due = session->wants_stats;
}
