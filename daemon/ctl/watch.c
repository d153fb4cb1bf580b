/* foveactl watch: shows live how the picture grows, where the eye looks and how long things take. */
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <jansson.h>

#include "ctl.h"

/* Time between two drawings: on a terminal, and as plain lines. */
static const uint64_t REDRAW_NS = 200000000, LINE_NS = 1000000000;

/* How far a key moves the camera, m. */
static const float STEP = 0.25f;

/* Stages on the way from a gaze sample to the client's screen. */
enum { TO_BATCH, TO_ENCODED, TO_RECEIVED, IN_ALL, STAGES };

static const char *const STAGE[STAGES] = {"gaze to batch", "batch to encoded", "encoded to received",
                                          "in all"};
static const char *const STAGE_KEY[STAGES] = {"gaze_to_batch", "batch_to_encoded", "encoded_to_received",
                                              "gaze_to_received"};

struct watch {
    const struct ctl *ctl;
    struct pro_client *client;
    bool terminal, keys;
    int lines; /* drawn last time, to be overwritten */
    uint64_t began_ns, drawn_ns;

    Fovea__Stats stats; /* the newest; only its numbers are valid */
    Fovea__Tracker tracker;
    bool has_stats, has_tracker, has_gaze;
    bool ended;                                     /* the daemon has ended in order */
    char gaze_source[TRK_ERROR_SIZE], answer[1024]; /* to the last key that was pressed */
    char recording[1024], recording_error[TRK_ERROR_SIZE];
    char scene[1024], refused[RND_ERROR_SIZE];
    float direction[3], spread, camera[3];
    char state[32], source[32], why[80];
    char viewer[128];                /* whose view steers; "": nobody's */
    uint64_t states[TRK_FROZEN + 1]; /* number of Gaze messages with each state */

    uint64_t tiles, bytes;             /* in all */
    uint64_t drawn_tiles, drawn_bytes; /* at the last drawing */
    double tile_rate, byte_rate;
    uint64_t sequence; /* newest gaze that a tile has answered */
    struct dmn_histogram stage[STAGES];
};

/* The first tile that answers a gaze sample tells how long the answer took. Later ones, and the first one
 * after a freeze, would include how long the eye has rested. */
static void take_latency(struct watch *watch, const Fovea__Tile *tile)
{
    uint64_t round_trip_ns, received_ns = dmn_now_ns();
    int64_t offset_ns;
    double times[STAGES];

    if (!tile->gaze_ns || tile->gaze_sequence <= watch->sequence || watch->stats.frozen) return;
    if (!pro_clock(watch->client, &round_trip_ns, &offset_ns)) return;
    watch->sequence = tile->gaze_sequence;
    received_ns += (uint64_t)offset_ns; /* on the daemon's clock */
    times[TO_BATCH] = (double)(int64_t)(tile->aimed_ns - tile->gaze_ns);
    times[TO_ENCODED] = (double)(int64_t)(tile->encoded_ns - tile->aimed_ns);
    times[TO_RECEIVED] = (double)(int64_t)(received_ns - tile->encoded_ns);
    times[IN_ALL] = (double)(int64_t)(received_ns - tile->gaze_ns);
    for (int i = 0; i < STAGES; i++) dmn_histogram_add(&watch->stage[i], times[i] * 1e-9);
}

static void take_gaze(struct watch *watch, const Fovea__Gaze *gaze)
{
    watch->has_gaze = true;
    memcpy(watch->direction, gaze->n_aim ? gaze->aim : gaze->direction, sizeof(watch->direction));
    watch->spread = gaze->spread;
    snprintf(watch->state, sizeof(watch->state), "%s", gaze->state);
    snprintf(watch->source, sizeof(watch->source), "%s", gaze->source);
    snprintf(watch->why, sizeof(watch->why), "%s", gaze->why);
    for (int i = 0; i <= TRK_FROZEN; i++) watch->states[i] += !strcmp(gaze->state, trk_state_name(i));
}

static void take_stats(struct watch *watch, const Fovea__Stats *stats)
{
    watch->stats = *stats;
    watch->has_stats = true;
    watch->has_tracker = stats->tracker;
    if (stats->tracker) watch->tracker = *stats->tracker;
    snprintf(watch->gaze_source, sizeof(watch->gaze_source), "%s", stats->gaze_source);
    snprintf(watch->recording, sizeof(watch->recording), "%s", stats->recording);
    snprintf(watch->recording_error, sizeof(watch->recording_error), "%s", stats->recording_error);
    snprintf(watch->scene, sizeof(watch->scene), "%s", stats->scene);
    snprintf(watch->refused, sizeof(watch->refused), "%s", stats->refused);
    if (stats->n_camera) memcpy(watch->camera, stats->camera, sizeof(watch->camera));
}

static void take(struct watch *watch, const Fovea__Message *message)
{
    switch (message->body_case) {
    case FOVEA__MESSAGE__BODY_TILE:
        watch->tiles++;
        watch->bytes += message->tile->data.len;
        take_latency(watch, message->tile);
        break;
    case FOVEA__MESSAGE__BODY_GAZE:
        take_gaze(watch, message->gaze);
        break;
    case FOVEA__MESSAGE__BODY_STATS:
        take_stats(watch, message->stats);
        break;
    case FOVEA__MESSAGE__BODY_VIEWING:
        snprintf(watch->viewer, sizeof(watch->viewer), "%s", message->viewing->who);
        break;
    case FOVEA__MESSAGE__BODY_BYE:
        watch->ended = true;
        break;
    case FOVEA__MESSAGE__BODY_DONE:
        snprintf(watch->answer, sizeof(watch->answer), "%s", message->done->text);
        break;
    default:
        break;
    }
}

static void name_gaze(const struct watch *watch, char *out, size_t size)
{
    double yaw, pitch;

    dmn_angles(watch->direction, &yaw, &pitch);
    if (!watch->has_gaze)
        snprintf(out, size, "none yet");
    else
        snprintf(out, size, "%+6.1f right %+5.1f up, %s%s", yaw, pitch, watch->state,
                 watch->stats.finished ? ", finished" : "");
}

static void draw_line(const struct watch *watch)
{
    const Fovea__Stats *s = &watch->stats;
    char gaze[80];

    name_gaze(watch, gaze, sizeof(gaze));
    printf(
        "%5.1f s  %.2f Mpaths/s  tiles %u visited %u converged %u settled  gaze %s  %.0f tiles/s %.2f MB/s  "
        "latency p50 %.1f p99 %.1f ms\n",
        (double)(watch->drawn_ns - watch->began_ns) * 1e-9, s->samples_per_second * 1e-6, s->tiles_visited,
        s->tiles_converged, s->tiles_settled, gaze, watch->tile_rate, watch->byte_rate * 1e-6,
        dmn_histogram_quantile(&watch->stage[IN_ALL], 0.5) * 1e3,
        dmn_histogram_quantile(&watch->stage[IN_ALL], 0.99) * 1e3);
    fflush(stdout);
}

static void row(struct watch *watch, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Print a line of the table. On a terminal it is cut to the width, since lines are overwritten. */
static void row(struct watch *watch, const char *format, ...)
{
    struct winsize window = {.ws_col = 80};
    char line[2048];
    va_list args;

    va_start(args, format);
    vsnprintf(line, sizeof(line), format, args);
    va_end(args);
    rnd_make_printable(line);
    if (!watch->terminal) {
        puts(line);
        return;
    }
    if (ioctl(STDOUT_FILENO, TIOCGWINSZ, &window) || !window.ws_col) window.ws_col = 80;
    printf("%.*s\033[K\n", window.ws_col - 1, line);
    watch->lines++;
}

static void draw_gaze(struct watch *watch)
{
    const Fovea__Stats *s = &watch->stats;
    char text[160];

    name_gaze(watch, text, sizeof(text));
    row(watch, "gaze      %s; %llu samples, %llu valid", text, (unsigned long long)s->gaze_samples,
        (unsigned long long)s->gaze_valid);
    if (watch->has_gaze)
        row(watch, "          by %s: %s; fovea %.1f times as wide", watch->source, watch->why, watch->spread);
    row(watch, "          %s", watch->gaze_source);
    if (*watch->viewer) row(watch, "view      of %s", watch->viewer);
    if (watch->has_tracker) {
        ctl_tracker_line(&watch->tracker, text, sizeof(text));
        row(watch, "          %s", text);
    }
    if (*watch->recording)
        row(watch, "recording %s, %llu samples", watch->recording, (unsigned long long)s->recorded);
    if (*watch->recording_error)
        row(watch, "          %llu lost: %s", (unsigned long long)s->recording_lost, watch->recording_error);
}

static void draw_table(struct watch *watch)
{
    const Fovea__Stats *s = &watch->stats;
    uint64_t round_trip_ns = 0;
    int64_t offset_ns;

    pro_clock(watch->client, &round_trip_ns, &offset_ns);
    if (watch->lines) printf("\033[%dA\033[J", watch->lines);
    watch->lines = 0;
    row(watch, "time      %.1f s", (double)(watch->drawn_ns - watch->began_ns) * 1e-9);
    if (*watch->refused) row(watch, "scene     the last edit was not taken: %s", watch->refused);
    row(watch, "camera    %.4g,%.4g,%.4g m, generation %llu", watch->camera[0], watch->camera[1],
        watch->camera[2], (unsigned long long)s->generation);
    row(watch, "paths     %.4g M, %.2f M/s, %.4g M rays", (double)s->samples * 1e-6,
        s->samples_per_second * 1e-6, (double)s->rays * 1e-6);
    row(watch, "tiles     %u: %u visited, %u converged, %u settled", s->tiles, s->tiles_visited,
        s->tiles_converged, s->tiles_settled);
    draw_gaze(watch);
    row(watch, "stream    %llu tiles, %.0f/s, %.2f MB/s; %.0f %% of the sphere",
        (unsigned long long)watch->tiles, watch->tile_rate, watch->byte_rate * 1e-6,
        pro_picture_coverage(pro_picture(watch->client)) * 100);
    row(watch, "batch     %.2f ms, begun %.2f ms after its gaze arrived; round trip %.2f ms", s->batch_ms,
        s->gaze_to_batch_ms, (double)round_trip_ns * 1e-6);
    row(watch, "latency   %-20s%10s%10s%10s", "ms", "p50", "p95", "p99");
    for (int i = 0; i < STAGES; i++)
        row(watch, "          %-20s%10.2f%10.2f%10.2f", STAGE[i],
            dmn_histogram_quantile(&watch->stage[i], 0.5) * 1e3,
            dmn_histogram_quantile(&watch->stage[i], 0.95) * 1e3,
            dmn_histogram_quantile(&watch->stage[i], 0.99) * 1e3);
    if (watch->keys)
        row(watch, "keys      f %s, c recentre, w a s d or arrows move the camera, q quit",
            s->frozen ? "unfreeze" : "freeze");
    if (*watch->answer) row(watch, "          %s", watch->answer);
    fflush(stdout);
}

static void draw(struct watch *watch)
{
    uint64_t now_ns = dmn_now_ns(), passed_ns = now_ns - watch->drawn_ns;

    if (passed_ns < (watch->terminal ? REDRAW_NS : LINE_NS) || !watch->has_stats) return;
    /* Rates since the last drawing, smoothed. */
    watch->tile_rate = (double)(watch->tiles - watch->drawn_tiles) / ((double)passed_ns * 1e-9);
    watch->byte_rate = (double)(watch->bytes - watch->drawn_bytes) / ((double)passed_ns * 1e-9);
    watch->drawn_ns = now_ns;
    watch->drawn_tiles = watch->tiles;
    watch->drawn_bytes = watch->bytes;
    if (watch->ctl->json) return;
    if (watch->terminal)
        draw_table(watch);
    else
        draw_line(watch);
}

static json_t *latency_json(const struct watch *watch)
{
    json_t *all = json_object();

    for (int i = 0; i < STAGES; i++)
        json_object_set_new(all, STAGE_KEY[i],
                            json_pack("{s:I, s:f, s:f, s:f}", "count", (json_int_t)watch->stage[i].count,
                                      "p50_ms", dmn_histogram_quantile(&watch->stage[i], 0.5) * 1e3, "p95_ms",
                                      dmn_histogram_quantile(&watch->stage[i], 0.95) * 1e3, "p99_ms",
                                      dmn_histogram_quantile(&watch->stage[i], 0.99) * 1e3));
    return all;
}

static json_t *states_json(const struct watch *watch)
{
    json_t *all = json_object();

    for (int i = 0; i <= TRK_FROZEN; i++)
        json_object_set_new(all, trk_state_name(i), json_integer((json_int_t)watch->states[i]));
    return all;
}

static void print_json(const struct watch *watch, double seconds)
{
    const Fovea__Stats *s = &watch->stats;
    const Fovea__Welcome *welcome = pro_welcome(watch->client);
    uint64_t round_trip_ns = 0;
    int64_t offset_ns;
    double yaw, pitch;
    json_t *object;

    dmn_angles(watch->direction, &yaw, &pitch);
    pro_clock(watch->client, &round_trip_ns, &offset_ns);
    object = json_pack(
        "{s:f, s:s, s:s, s:o, s:I, s:s, s:s, s:[I,I], s:I, s:f, s:I, s:I, s:I, s:I, s:I, s:I, s:I, s:I, s:b, "
        "s:b, s:[f,f], s:s, s:s, s:s, s:f, s:o, s:s, s:o, s:s, s:I, s:I, s:s, s:I, s:I, "
        "s:f, s:f, s:f, s:o}",
        "seconds", seconds, "scene", watch->has_stats ? watch->scene : welcome->scene, "refused",
        watch->refused, "camera", ctl_camera_json(watch->camera, watch->stats.n_camera), "generation",
        (json_int_t)s->generation, "gaze", watch->gaze_source, "mode", welcome->distribution, "size",
        (json_int_t)welcome->width, (json_int_t)welcome->height, "paths", (json_int_t)s->samples,
        "paths_per_second", s->samples_per_second, "rays", (json_int_t)s->rays, "not_finite",
        (json_int_t)s->not_finite, "tiles", (json_int_t)s->tiles, "tiles_visited",
        (json_int_t)s->tiles_visited, "tiles_converged", (json_int_t)s->tiles_converged, "tiles_settled",
        (json_int_t)s->tiles_settled, "gaze_samples", (json_int_t)s->gaze_samples, "gaze_valid",
        (json_int_t)s->gaze_valid, "frozen", s->frozen, "finished", s->finished, "gaze_deg", yaw, pitch,
        "state", watch->state, "source", watch->source, "why", watch->why, "spread", (double)watch->spread,
        "states", states_json(watch), "viewer", watch->viewer, "tracker",
        ctl_tracker_json(watch->has_tracker ? &watch->tracker : NULL), "recording", watch->recording,
        "recorded", (json_int_t)s->recorded, "recording_lost", (json_int_t)s->recording_lost,
        "recording_error", watch->recording_error, "tiles_received", (json_int_t)watch->tiles,
        "bytes_received", (json_int_t)watch->bytes, "batch_ms", s->batch_ms, "round_trip_ms",
        (double)round_trip_ns * 1e-6, "coverage", pro_picture_coverage(pro_picture(watch->client)), "latency",
        latency_json(watch));
    if (object) json_dumpf(object, stdout, JSON_INDENT(2) | JSON_REAL_PRECISION(9));
    if (object) putchar('\n');
    json_decref(object);
}

/* The step that a key asks for: along the gaze, or level and at right angles to it. */
static void step(const struct watch *watch, char key, float out_by[3])
{
    const float *d = watch->direction, level = hypotf(d[0], d[2]);
    const float ahead = key == 'w' ? STEP : key == 's' ? -STEP : 0;
    const float right = key == 'd' ? STEP : key == 'a' ? -STEP : 0;

    for (int i = 0; i < 3; i++) out_by[i] = ahead * d[i];
    if (level < 1e-3f) return; /* if gaze is straight up or down, there is no right */
    out_by[0] -= right * d[2] / level;
    out_by[2] += right * d[0] / level;
}

/* Act on a key: f, c, w, a, s, d or q. False after q. */
static bool press(struct watch *watch, char key)
{
    Fovea__Move move = FOVEA__MOVE__INIT;
    float by[3];
    Fovea__Message message = FOVEA__MESSAGE__INIT;
    Fovea__Recentre recentre = FOVEA__RECENTRE__INIT;
    Fovea__Freeze freeze = FOVEA__FREEZE__INIT;
    char error[PRO_ERROR_SIZE];

    if (key == 'q') return false;
    if (!key || !strchr("fcwasd", key)) return true;
    watch->answer[0] = '\0';
    if (key == 'f') {
        freeze.frozen = watch->stats.frozen = !watch->stats.frozen;
        message.body_case = FOVEA__MESSAGE__BODY_FREEZE;
        message.freeze = &freeze;
    } else if (key == 'c') {
        message.body_case = FOVEA__MESSAGE__BODY_RECENTRE;
        message.recentre = &recentre;
    } else {
        step(watch, key, by);
        move.n_camera = 3;
        move.camera = by;
        move.relative = true;
        message.body_case = FOVEA__MESSAGE__BODY_MOVE;
        message.move = &move;
    }
    /* If the connection has broken, the next read tells. */
    (void)pro_send(watch->client, &message, error);
    return true;
}

/* Watch until the time is up, the recording or the daemon has ended, nobody reads the output, or Ctrl-C.
 * False with a line in out_error if the connection breaks. */
static bool follow(struct watch *watch, char out_error[PRO_ERROR_SIZE])
{
    const struct ctl *ctl = watch->ctl;

    trk_be_prompt(); /* so that latencies do not include waits of this program for a processor */
    while (!ctl_interrupted && !watch->ended && !ferror(stdout)) {
        Fovea__Message *message;
        enum pro_result result = pro_receive(watch->client, 50, &message, out_error);

        if (result == PRO_BROKEN) return false;
        if (result == PRO_MESSAGE) {
            take(watch, message);
            fovea__message__free_unpacked(message, NULL);
        }
        if (watch->keys && !press(watch, ctl_key())) break;
        if ((double)(dmn_now_ns() - watch->began_ns) * 1e-9 >= ctl->seconds) break;
        if (ctl->until_finished && watch->stats.finished) break;
        draw(watch);
    }
    return true;
}

static int run(const struct ctl *ctl)
{
    struct watch *watch = calloc(1, sizeof(*watch));
    char error[PRO_ERROR_SIZE];
    bool good;

    if (!watch) return ctl_fail("out of memory"), 1;
    watch->ctl = ctl;
    watch->terminal = isatty(STDOUT_FILENO) && !ctl->json;
    /* Pixels are not used, so the small encoding is enough. */
    watch->client = ctl_connect(ctl, FOVEA__ENCODING__ENCODING_JPEG, true, true);
    if (!watch->client) {
        free(watch);
        return 1;
    }
    ctl_catch_signals();
    watch->keys = watch->terminal && ctl_keys_begin();
    watch->began_ns = watch->drawn_ns = dmn_now_ns();
    if (!ctl->json) printf("%s\n", pro_welcome(watch->client)->scene);
    fflush(stdout);
    good = follow(watch, error);
    ctl_keys_end();
    watch->keys = false;
    watch->drawn_ns = dmn_now_ns();
    if (ctl->json)
        print_json(watch, (double)(watch->drawn_ns - watch->began_ns) * 1e-9);
    else
        draw_table(watch);
    if (!good) ctl_fail("%s", error);
    pro_disconnect(watch->client);
    free(watch);
    return good ? 0 : 1;
}

const struct ctl_command ctl_watch = {
    .name = "watch",
    .operands = "",
    .summary = "show how the picture grows, where the eye looks and how long things take",
    .options = CTL_CONNECTION "json for until-finished",
    .run = run,
};
