/* foveactl gaze info, gaze convert: what a gaze log holds; and writing it in another format. */
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "ctl.h"
#include "file.h"
#include "tracker.h"

struct range {
    double low, high; /* deg; high is above 180 if the arc passes behind the viewer; low > high: empty */
};

/* Yaws from -180 to 180 in bins of a twentieth of a degree: the lowest and the highest of each bin. */
enum { BINS = 7200 };
struct circle {
    struct range bins[BINS];
};

struct summary {
    double span_s, mean_hz; /* mean_hz counts the gaps */
    struct trk_rate rate;
    size_t unseen; /* samples that are missing by their sequence numbers */
    size_t gaze, eye[2], pupil[2], head;
    float first_head[7];
    bool head_moves, head_is_zero; /* zero: in all samples */
    struct range head_yaw, head_pitch, world_yaw, world_pitch;
    struct circle head_circle, world_circle; /* from which the ranges of yaw are found */
    struct trk_events events;
};

bool ctl_read_log(const struct ctl *ctl, struct trk_log *out_log)
{
    char error[TRK_ERROR_SIZE];

    return trk_log_read_with(ctl->operand[0], &ctl->log, out_log, error) || ctl_fail("%s", error);
}

static void widen(struct range *range, double value)
{
    range->low = fmin(range->low, value);
    range->high = fmax(range->high, value);
}

static void widen_circle(struct circle *circle, double yaw)
{
    int bin = (int)((yaw + 180) * BINS / 360);

    widen(&circle->bins[bin < BINS ? bin : BINS - 1], yaw);
}

/* The shortest arc that has all these yaws: the circle without the widest gap between neighbours. The widest
 * gap is found if it is as wide as a bin; else some gap between two bins is taken. */
static struct range arc_of(const struct circle *circle)
{
    struct range arc = {INFINITY, -INFINITY};
    double last = NAN, widest;

    for (int i = 0; i < BINS; i++) {
        const struct range *bin = &circle->bins[i];

        if (bin->low > bin->high) continue;
        arc = (struct range){fmin(arc.low, bin->low), bin->high};
    }
    widest = arc.low + 360 - arc.high;
    for (int i = 0; i < BINS; i++) {
        const struct range *bin = &circle->bins[i];

        if (bin->low > bin->high) continue;
        if (bin->low - last > widest) {
            widest = bin->low - last;
            arc = (struct range){bin->low, last + 360};
        }
        last = bin->high;
    }
    return arc;
}

static void summarise_head(const float head[7], struct summary *s)
{
    static const float zero[7] = {0, 0, 0, 0, 0, 0, 1};

    if (s->head++ == 0) {
        memcpy(s->first_head, head, sizeof(s->first_head));
        s->head_is_zero = true;
    }
    for (int k = 0; k < 7; k++) {
        s->head_moves |= head[k] != s->first_head[k];
        s->head_is_zero &= head[k] == zero[k];
    }
}

static void summarise_sample(const struct trk_sample *sample, struct summary *s)
{
    float head[3], world[3];

    for (int eye = 0; eye < 2; eye++) {
        s->eye[eye] += (sample->valid & TRK_LEFT_DIRECTION << 4 * eye) != 0;
        s->pupil[eye] += (sample->valid & TRK_LEFT_PUPIL << 4 * eye) != 0;
    }
    if (sample->valid & TRK_HEAD) summarise_head(sample->head, s);
    if (!trk_gaze_direction(sample, head, NULL) || !trk_world_direction(sample, world)) return;
    s->gaze++;
    widen(&s->head_pitch, ctl_pitch_deg(head));
    widen(&s->world_pitch, ctl_pitch_deg(world));
    widen_circle(&s->head_circle, ctl_yaw_deg(head));
    widen_circle(&s->world_circle, ctl_yaw_deg(world));
}

static bool summarise(const struct trk_log *log, struct summary *out_summary)
{
    const struct range none = {INFINITY, -INFINITY};
    struct trk_sample first, last;

    *out_summary = (struct summary){.head_pitch = none, .world_pitch = none};
    for (int i = 0; i < BINS; i++)
        out_summary->head_circle.bins[i] = out_summary->world_circle.bins[i] = none;
    for (size_t i = 0; i < log->count; i++) {
        struct trk_sample sample;

        trk_log_sample(log, i, &sample);
        summarise_sample(&sample, out_summary);
    }
    trk_log_sample(log, 0, &first);
    trk_log_sample(log, log->count - 1, &last);
    out_summary->head_yaw = arc_of(&out_summary->head_circle);
    out_summary->world_yaw = arc_of(&out_summary->world_circle);
    out_summary->unseen = last.sequence - first.sequence - (log->count - 1);
    out_summary->span_s = (double)(last.device_ns - first.device_ns) / 1e9;
    if (out_summary->span_s > 0) out_summary->mean_hz = (double)(log->count - 1) / out_summary->span_s;
    trk_log_rate(log, &out_summary->rate);
    return trk_events_find(log, &out_summary->events) || ctl_fail("out of memory");
}

/* --- text --- */

static double percent(size_t part, const struct trk_log *log)
{
    return 100.0 * (double)part / (double)log->count;
}

static void print_ranges(const char *name, const struct range *yaw, const struct range *pitch)
{
    if (yaw->low > yaw->high) return;
    printf("  %-12s yaw %.1f to %.1f", name, yaw->low, yaw->high);
    if (yaw->high > 180) printf(" (past 180, %.1f; %.1f in all)", yaw->high - 360, yaw->high - yaw->low);
    printf(", pitch %.1f to %.1f degrees\n", pitch->low, pitch->high);
}

static void print_text(const char *path, const struct trk_log *log, const struct summary *s)
{
    const size_t *counts = s->events.counts;

    dmn_print(stdout, "%s: %s\n", path, log->format);
    printf("  %-12s %zu in %.3f s\n", "samples", log->count, s->span_s);
    if (s->rate.hz > 0) {
        printf("  %-12s %.1f Hz; middle step of %.3f ms", "rate", s->rate.hz,
               (double)s->rate.median_ns / 1e6);
        if (s->rate.gaps) printf("; %.1f Hz if the gaps are counted", s->mean_hz);
        putchar('\n');
    }
    printf("  %-12s %zu longer than %g steps", "gaps", s->rate.gaps, TRK_GAP_STEPS);
    if (s->rate.gaps) printf(", the longest %.1f ms", (double)s->rate.longest_ns / 1e6);
    if (s->unseen) printf("; by their numbers %zu samples are missing", s->unseen);
    printf("\n  %-12s %.1f %% (%zu lost)", "gaze", percent(s->gaze, log), log->count - s->gaze);
    if (s->eye[0] + s->eye[1])
        printf("; left eye %.1f %%, right eye %.1f %%", percent(s->eye[0], log), percent(s->eye[1], log));
    if (s->pupil[0] + s->pupil[1])
        printf("; pupils %.1f and %.1f %%", percent(s->pupil[0], log), percent(s->pupil[1], log));
    printf("\n  %-12s ", "head pose");
    if (s->head)
        printf("%.1f %%%s\n", percent(s->head, log),
               s->head_moves || s->head < 2 ? ""
               : s->head_is_zero            ? ", but it never moves: all zero"
                                            : ", but it never moves");
    else
        printf("none\n");
    print_ranges("in the head", &s->head_yaw, &s->head_pitch);
    if (s->head) print_ranges("in the world", &s->world_yaw, &s->world_pitch);
    printf("  %-12s %zu fixations, %zu saccades, %zu pursuits, %zu blinks, %zu losses; noise %.2f degrees\n",
           "events", counts[TRK_FIXATION], counts[TRK_SACCADE], counts[TRK_PURSUIT], counts[TRK_BLINK],
           counts[TRK_LOST], s->events.noise_deg);
    if (*log->assumed) dmn_print(stdout, "  %-12s %s\n", "assumed", log->assumed);
}

/* --- JSON --- */

static json_t *range_json(const struct range *range)
{
    return range->low <= range->high ? json_pack("[f, f]", range->low, range->high) : json_null();
}

static bool print_json(const char *path, const struct trk_log *log, const struct summary *s)
{
    const size_t *counts = s->events.counts;
    json_t *root = json_pack(
        "{s:s, s:s, s:I, s:I, s:f, s:f, s:f, s:f, s:I, s:f, s:I, s:I, s:I, s:I, s:I, s:I, s:b}", "file", path,
        "format", log->format, "samples", (json_int_t)log->count, "lost", (json_int_t)(log->count - s->gaze),
        "span_s", s->span_s, "rate_hz", s->rate.hz, "median_step_ms", (double)s->rate.median_ns / 1e6,
        "mean_hz", s->mean_hz, "gaps", (json_int_t)s->rate.gaps, "longest_gap_ms",
        (double)s->rate.longest_ns / 1e6, "missing", (json_int_t)s->unseen, "left", (json_int_t)s->eye[0],
        "right", (json_int_t)s->eye[1], "left_pupil", (json_int_t)s->pupil[0], "right_pupil",
        (json_int_t)s->pupil[1], "head", (json_int_t)s->head, "head_moves", s->head_moves);
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

/* --- the commands --- */

static int info(const struct ctl *ctl)
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

/* Begin a file for a log that only its owner may read. It must not be one of the files that the log was read
 * from. */
static bool begin(struct dmn_file *file, const char *path, const struct trk_log *log, bool replace)
{
    char error[DMN_FILE_ERROR_SIZE];

    if (trk_log_is_from(log, path))
        return ctl_fail("%s: is the log itself, or a file that it was read with; expected another name",
                        path);
    return dmn_file_begin(file, path, 0600, replace, error) || ctl_fail("%s", error);
}

static bool end(struct dmn_file *file)
{
    char error[DMN_FILE_ERROR_SIZE];

    return dmn_file_end(file, error) || ctl_fail("%s", error);
}

/* BIDS: the table and, under the same name, its sidecar. */
static bool write_bids(const char *path, const struct trk_log *log, bool replace)
{
    char sidecar_path[CTL_PATH_SIZE], error[TRK_ERROR_SIZE];
    struct dmn_file table, sidecar;
    size_t stem = strlen(path) - strlen(".tsv.gz");
    bool good;

    if (snprintf(sidecar_path, sizeof(sidecar_path), "%.*s.json", (int)stem, path) >=
        (int)sizeof(sidecar_path))
        return ctl_fail("%.40s...: the name is too long", path);
    if (!begin(&table, path, log, replace)) return false;
    if (!begin(&sidecar, sidecar_path, log, replace)) {
        dmn_file_drop(&table);
        return false;
    }
    good = trk_log_print_bids(log, table.file, sidecar.file, error) || ctl_fail("%s: %s", path, error);
    good = good && end(&sidecar);
    if (good) return end(&table);
    dmn_file_drop(&sidecar);
    dmn_file_drop(&table);
    return false;
}

static bool write_own(const char *path, const struct trk_log *log, bool replace)
{
    struct dmn_file file;

    if (!begin(&file, path, log, replace)) return false;
    trk_log_print(log, file.file);
    return end(&file);
}

static int convert(const struct ctl *ctl)
{
    const char *out = ctl->operand[1];
    bool replace = ctl->replace;
    struct trk_log log;
    bool good;

    if (!ctl_ends_with(out, ".gaze") && !ctl_ends_with(out, "_physio.tsv.gz"))
        return ctl_fail("%s: expected a name that ends with .gaze (fovead's own) or _physio.tsv.gz (BIDS)",
                        out),
               2;
    if (!ctl_read_log(ctl, &log)) return 1;
    good = (ctl_ends_with(out, ".gaze") ? write_own : write_bids)(out, &log, replace);
    if (good) dmn_print(stdout, "%s: %zu samples of %s\n", out, log.count, log.format);
    if (good && *log.assumed) dmn_print(stdout, "assumed: %s\n", log.assumed);
    trk_log_finish(&log);
    return good ? 0 : 1;
}

const struct ctl_command ctl_gaze_info = {
    .name = "gaze info",
    .operands = "LOG",
    .summary = "what a gaze log holds, and what was assumed of it",
    .options = CTL_LOG "json",
    .run = info,
};

const struct ctl_command ctl_gaze_convert = {
    .name = "gaze convert",
    .operands = "LOG OUT",
    .summary = "write a gaze log as OUT: .gaze (fovead's own) or _physio.tsv.gz (BIDS)",
    .options = CTL_LOG "replace",
    .run = convert,
};
