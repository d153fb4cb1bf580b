/* foveactl stats: prints the daemon's figures once. */
#include <stdio.h>

#include <jansson.h>

#include "ctl.h"

static void print_table(const Fovea__Welcome *welcome, const Fovea__Stats *s)
{
    dmn_print(stdout, "daemon    %s\nscene     %s\n", welcome->server, s->scene);
    if (*s->refused) dmn_print(stdout, "          the last edit was not taken: %s\n", s->refused);
    if (s->n_camera)
        dmn_print(stdout, "camera    %.6g,%.6g,%.6g m, generation %llu\n", s->camera[0], s->camera[1],
                  s->camera[2], (unsigned long long)s->generation);
    dmn_print(stdout, "gaze      %s\n", s->gaze_source);
    dmn_print(stdout, "          %llu samples, %llu valid%s%s\n", (unsigned long long)s->gaze_samples,
              (unsigned long long)s->gaze_valid, s->frozen ? ", frozen" : "",
              s->finished ? ", finished" : "");
    if (s->tracker) {
        char line[160];

        ctl_tracker_line(s->tracker, line, sizeof(line));
        dmn_print(stdout, "          %s\n", line);
    }
    if (*s->recording)
        dmn_print(stdout, "recording %s, %llu samples\n", s->recording, (unsigned long long)s->recorded);
    if (*s->recording_error)
        dmn_print(stdout, "          %llu lost: %s\n", (unsigned long long)s->recording_lost,
                  s->recording_error);
    dmn_print(stdout, "film      %ux%u, mode %s\n", welcome->width, welcome->height, welcome->distribution);
    dmn_print(stdout, "paths     %llu, %.3f M/s, %llu rays, %llu not finite\n",
              (unsigned long long)s->samples, s->samples_per_second * 1e-6, (unsigned long long)s->rays,
              (unsigned long long)s->not_finite);
    dmn_print(stdout, "tiles     %u: %u visited, %u converged, %u settled\n", s->tiles, s->tiles_visited,
              s->tiles_converged, s->tiles_settled);
    dmn_print(stdout, "batch     %.2f ms, %.2f ms after its gaze arrived (medians)\n", s->batch_ms,
              s->gaze_to_batch_ms);
    dmn_print(stdout, "clients   %u\n", s->clients);
}

void ctl_tracker_line(const Fovea__Tracker *t, char *out_line, size_t size)
{
    int length = snprintf(out_line, size, "%s, opened %u times, %llu losses",
                          t->present ? "present" : "absent", t->connections, (unsigned long long)t->losses);

    if (t->rate_hz > 0) length += snprintf(out_line + length, size - (size_t)length, ", %.0f Hz", t->rate_hz);
    if (t->has_clock)
        snprintf(out_line + length, size - (size_t)length, ", jitter %.2f ms, drift %+.0f ppm", t->jitter_ms,
                 t->drift_ppm);
}

json_t *ctl_tracker_json(const Fovea__Tracker *t)
{
    if (!t) return json_null();
    return json_pack("{s:b, s:I, s:I, s:f, s:b, s:f, s:f}", "present", t->present, "connections",
                     (json_int_t)t->connections, "losses", (json_int_t)t->losses, "rate_hz", t->rate_hz,
                     "has_clock", t->has_clock, "jitter_ms", t->jitter_ms, "drift_ppm", t->drift_ppm);
}

json_t *ctl_camera_json(const float *camera, size_t count)
{
    return count == 3 ? json_pack("[f,f,f]", camera[0], camera[1], camera[2]) : json_null();
}

static void print_json(const Fovea__Welcome *welcome, const Fovea__Stats *s)
{
    json_t *object = json_pack(
        "{s:s, s:s, s:s, s:o, s:I, s:s, s:o, s:s, s:I, s:I, s:s, s:s, s:[I,I], s:I, s:f, s:I, s:I, s:I, s:I, "
        "s:I, s:I, "
        "s:I, s:I, s:b, s:b, s:f, s:f, s:I}",
        "daemon", welcome->server, "scene", s->scene, "refused", s->refused, "camera",
        ctl_camera_json(s->camera, s->n_camera), "generation", (json_int_t)s->generation, "gaze",
        s->gaze_source, "tracker", ctl_tracker_json(s->tracker), "recording", s->recording, "recorded",
        (json_int_t)s->recorded, "recording_lost", (json_int_t)s->recording_lost, "recording_error",
        s->recording_error, "mode", welcome->distribution, "size", (json_int_t)welcome->width,
        (json_int_t)welcome->height, "paths", (json_int_t)s->samples, "paths_per_second",
        s->samples_per_second, "rays", (json_int_t)s->rays, "not_finite", (json_int_t)s->not_finite, "tiles",
        (json_int_t)s->tiles, "tiles_visited", (json_int_t)s->tiles_visited, "tiles_converged",
        (json_int_t)s->tiles_converged, "tiles_settled", (json_int_t)s->tiles_settled, "gaze_samples",
        (json_int_t)s->gaze_samples, "gaze_valid", (json_int_t)s->gaze_valid, "frozen", s->frozen, "finished",
        s->finished, "batch_ms", s->batch_ms, "gaze_to_batch_ms", s->gaze_to_batch_ms, "clients",
        (json_int_t)s->clients);

    if (object) json_dumpf(object, stdout, JSON_INDENT(2) | JSON_REAL_PRECISION(9));
    if (object) putchar('\n');
    json_decref(object);
}

static int run(const struct ctl *ctl)
{
    struct pro_client *client = ctl_connect(ctl, FOVEA__ENCODING__ENCODING_NONE, false, true);
    Fovea__Message *message =
        client ? ctl_await(client, FOVEA__MESSAGE__BODY_STATS, dmn_now_ns(), CTL_PATIENCE_S) : NULL;

    if (message) {
        (ctl->json ? print_json : print_table)(pro_welcome(client), message->stats);
        fovea__message__free_unpacked(message, NULL);
    }
    pro_disconnect(client);
    return message ? 0 : 1;
}

const struct ctl_command ctl_stats = {
    .name = "stats",
    .operands = "",
    .summary = "print the daemon's figures once",
    .options = CTL_CONNECTION "json",
    .run = run,
};
