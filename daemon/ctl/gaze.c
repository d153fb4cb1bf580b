/* foveactl gaze info, gaze convert: what a gaze log holds, and the same log in another format. */
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ctl.h"
#include "tracker.h"

/* A step so many times the usual one is a gap. */
static const double GAP_STEPS = 2.5;

struct range {
    double low, high; /* deg; low > high: nothing */
};

struct summary {
    double span_s, median_ms, mean_hz;
    size_t gaps, unseen; /* steps that are too long; samples that sequence numbers say were lost */
    double longest_ms;   /* gap */
    size_t gaze, eye[2], pupil[2], head, closed;
    struct range head_yaw, head_pitch, world_yaw, world_pitch;
    struct trk_events events;
};

bool ctl_read_log(const struct ctl *ctl, struct trk_log *out_log)
{
    char error[TRK_ERROR_SIZE];

    return trk_log_read_with(ctl->operand[0], &ctl->log, out_log, error) || ctl_fail("%s", error);
}

static int by_size(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;

    return (x > y) - (x < y);
}

static bool summarise_time(const struct trk_log *log, struct summary *s)
{
    double *steps = malloc(log->count * sizeof(*steps));
    size_t n = log->count - 1;

    if (!steps) return ctl_fail("out of memory");
    for (size_t i = 0; i < n; i++) {
        steps[i] = (double)(log->samples[i + 1].device_ns - log->samples[i].device_ns) / 1e6;
        s->unseen += log->samples[i + 1].sequence - log->samples[i].sequence - 1;
    }
    qsort(steps, n, sizeof(*steps), by_size);
    s->span_s = (double)(log->samples[n].device_ns - log->samples[0].device_ns) / 1e9;
    s->median_ms = n ? steps[n / 2] : 0;
    s->mean_hz = s->span_s > 0 ? (double)n / s->span_s : 0;
    for (size_t i = n; i-- > 0 && steps[i] > GAP_STEPS * s->median_ms;) s->gaps++;
    s->longest_ms = s->gaps ? steps[n - 1] : 0;
    free(steps);
    return true;
}

static void widen(struct range *range, double value)
{
    range->low = fmin(range->low, value);
    range->high = fmax(range->high, value);
}

static void summarise_sample(const struct trk_sample *sample, struct summary *s)
{
    float world[3];

    s->head += (sample->valid & TRK_HEAD) != 0;
    for (int eye = 0; eye < 2; eye++) {
        s->eye[eye] += (sample->valid & TRK_LEFT_DIRECTION << 4 * eye) != 0;
        s->pupil[eye] += (sample->valid & TRK_LEFT_PUPIL << 4 * eye) != 0;
    }
    if (!trk_world_direction(sample, world)) return;
    s->gaze++;
    widen(&s->head_yaw, ctl_yaw_deg(sample->direction));
    widen(&s->head_pitch, ctl_pitch_deg(sample->direction));
    widen(&s->world_yaw, ctl_yaw_deg(world));
    widen(&s->world_pitch, ctl_pitch_deg(world));
}

static bool summarise(const struct trk_log *log, struct summary *out_summary)
{
    const struct range none = {INFINITY, -INFINITY};

    *out_summary =
        (struct summary){.head_yaw = none, .head_pitch = none, .world_yaw = none, .world_pitch = none};
    for (size_t i = 0; i < log->count; i++) summarise_sample(&log->samples[i], out_summary);
    if (!summarise_time(log, out_summary)) return false;
    return trk_events_find(log, &out_summary->events) || ctl_fail("out of memory");
}

/* --- text ----------------------------------------------------------------------------------------------- */

static double percent(size_t part, const struct trk_log *log)
{
    return 100.0 * (double)part / (double)log->count;
}

static void print_ranges(const char *name, const struct range *yaw, const struct range *pitch)
{
    if (yaw->low <= yaw->high)
        printf("  %-12s yaw %.1f to %.1f, pitch %.1f to %.1f degrees\n", name, yaw->low, yaw->high,
               pitch->low, pitch->high);
}

static void print_text(const char *path, const struct trk_log *log, const struct summary *s)
{
    const size_t *counts = s->events.counts;

    printf("%s: %s\n", path, log->format);
    printf("  %-12s %zu in %.3f s\n", "samples", log->count, s->span_s);
    if (s->median_ms > 0)
        printf("  %-12s %.1f Hz by the middle step of %.3f ms, %.1f Hz on average\n", "rate",
               1000 / s->median_ms, s->median_ms, s->mean_hz);
    printf("  %-12s %zu longer than %g steps", "gaps", s->gaps, GAP_STEPS);
    if (s->gaps) printf(", the longest %.1f ms", s->longest_ms);
    if (s->unseen) printf("; by their numbers %zu samples are missing", s->unseen);
    printf("\n  %-12s %.1f %% (%zu lost)", "gaze", percent(s->gaze, log), log->count - s->gaze);
    if (s->eye[0] + s->eye[1])
        printf("; left eye %.1f %%, right eye %.1f %%", percent(s->eye[0], log), percent(s->eye[1], log));
    if (s->pupil[0] + s->pupil[1])
        printf("; pupils %.1f and %.1f %%", percent(s->pupil[0], log), percent(s->pupil[1], log));
    printf("\n  %-12s ", "head pose");
    if (s->head)
        printf("%.1f %%\n", percent(s->head, log));
    else
        printf("none\n");
    print_ranges("in the head", &s->head_yaw, &s->head_pitch);
    if (s->head) print_ranges("in the world", &s->world_yaw, &s->world_pitch);
    printf("  %-12s %zu fixations, %zu saccades, %zu pursuits, %zu blinks, %zu losses; noise %.2f degrees\n",
           "events", counts[TRK_FIXATION], counts[TRK_SACCADE], counts[TRK_PURSUIT], counts[TRK_BLINK],
           counts[TRK_LOST], s->events.noise_deg);
    if (*log->assumed) printf("  %-12s %s\n", "assumed", log->assumed);
}

/* --- JSON ----------------------------------------------------------------------------------------------- */

static json_t *range_json(const struct range *range)
{
    return range->low <= range->high ? json_pack("[f, f]", range->low, range->high) : json_null();
}

static bool print_json(const char *path, const struct trk_log *log, const struct summary *s)
{
    const size_t *counts = s->events.counts;
    json_t *root = json_pack(
        "{s:s, s:s, s:I, s:I, s:f, s:f, s:f, s:I, s:f, s:I, s:I, s:I, s:I, s:I, s:I}", "file", path, "format",
        log->format, "samples", (json_int_t)log->count, "lost", (json_int_t)(log->count - s->gaze), "span_s",
        s->span_s, "median_step_ms", s->median_ms, "mean_hz", s->mean_hz, "gaps", (json_int_t)s->gaps,
        "longest_gap_ms", s->longest_ms, "missing", (json_int_t)s->unseen, "left", (json_int_t)s->eye[0],
        "right", (json_int_t)s->eye[1], "left_pupil", (json_int_t)s->pupil[0], "right_pupil",
        (json_int_t)s->pupil[1], "head", (json_int_t)s->head);
    json_t *events =
        json_pack("{s:I, s:I, s:I, s:I, s:I, s:f}", "fixations", (json_int_t)counts[TRK_FIXATION], "saccades",
                  (json_int_t)counts[TRK_SACCADE], "pursuits", (json_int_t)counts[TRK_PURSUIT], "blinks",
                  (json_int_t)counts[TRK_BLINK], "losses", (json_int_t)counts[TRK_LOST], "noise_deg",
                  s->events.noise_deg);
    bool ok = root && events;

    if (ok) {
        json_object_set_new(root, "yaw_in_head_deg", range_json(&s->head_yaw));
        json_object_set_new(root, "pitch_in_head_deg", range_json(&s->head_pitch));
        json_object_set_new(root, "yaw_in_world_deg", range_json(&s->world_yaw));
        json_object_set_new(root, "pitch_in_world_deg", range_json(&s->world_pitch));
        json_object_set(root, "events", events);
        json_object_set_new(root, "assumed", json_string(log->assumed));
        ok = json_dumpf(root, stdout, JSON_INDENT(2) | JSON_REAL_PRECISION(9)) == 0 && putchar('\n') != EOF;
    }
    json_decref(events);
    json_decref(root);
    return ok || ctl_fail("%s: cannot print it as JSON", path);
}

/* --- the commands --------------------------------------------------------------------------------------- */

int ctl_gaze_info(const struct ctl *ctl)
{
    struct trk_log log;
    struct summary summary;
    bool good = false;

    if (!ctl_read_log(ctl, &log)) return 1;
    if (summarise(&log, &summary)) {
        if (ctl->json) {
            good = print_json(ctl->operand[0], &log, &summary);
        } else {
            print_text(ctl->operand[0], &log, &summary);
            good = true;
        }
        trk_events_finish(&summary.events);
    }
    trk_log_finish(&log);
    return good ? 0 : 1;
}

bool ctl_ends_with(const char *text, const char *end)
{
    size_t length = strlen(text), tail = strlen(end);

    return length > tail && strcmp(text + length - tail, end) == 0;
}

int ctl_gaze_convert(const struct ctl *ctl)
{
    const char *out = ctl->operand[1];
    char error[TRK_ERROR_SIZE];
    struct trk_log log;
    bool good;

    if (!ctl_ends_with(out, ".gaze") && !ctl_ends_with(out, "_physio.tsv.gz"))
        return ctl_fail("%s: expected a name that ends with .gaze (fovead's own) or _physio.tsv.gz (BIDS)",
                        out),
               2;
    if (!ctl_read_log(ctl, &log)) return 1;
    good = trk_log_write(out, &log, error) || ctl_fail("%s", error);
    if (good) printf("%s: %zu samples of %s\n", out, log.count, log.format);
    if (good && *log.assumed) printf("assumed: %s\n", log.assumed);
    trk_log_finish(&log);
    return good ? 0 : 1;
}
