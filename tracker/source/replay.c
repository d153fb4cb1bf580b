/* A recorded log as a source, at the pace of its own timestamps or at another pace, once or in a loop. */
#include "source/kinds.h"

#include "error.h"
#include "system.h"

#include <math.h>
#include <stdio.h>

/* With these speeds, a step of the longest log fits into 64 bits of nanoseconds, and a sample into a second.
 */
static const double slowest = 0.01, fastest = 1000;

/* If the log has no steps, this is the step from its last sample to the first of the next lap, as at 120 Hz.
 */
static const uint64_t lone_step_ns = 8333333;

struct replay {
    struct trk_source source;
    struct trk_log log;
    struct trk_rate rate;
    bool loop;
    uint64_t first_ns, first_sequence; /* of the log's first sample */
    uint64_t lap_ns, lap_sequence;     /* how far time and sequence advance per lap */
    uint64_t lap;
    size_t next;
};

/* Measure a lap on the log's own clock. It ends one usual step after the last sample. */
static void measure_lap(struct replay *replay)
{
    const struct trk_log *log = &replay->log;
    struct trk_sample first, last;
    trk_log_sample(log, 0, &first);
    trk_log_sample(log, log->count - 1, &last);
    replay->first_ns = first.device_ns;
    replay->first_sequence = first.sequence;
    const uint64_t step_ns = replay->rate.step_ns;
    replay->lap_ns = last.device_ns - first.device_ns + (step_ns ? step_ns : lone_step_ns);
    replay->lap_sequence = last.sequence - first.sequence + 1;
}

static void describe(struct replay *replay, const char *path)
{
    const struct trk_log *log = &replay->log;
    double seconds = (double)(trk_log_time(log, log->count - 1) - replay->first_ns) / 1e9;
    char rate[32] = "";
    if (replay->rate.hz > 0) snprintf(rate, sizeof rate, ", %.0f Hz", replay->rate.hz);
    char *text = replay->source.description;
    const size_t size = sizeof replay->source.description;
    const uint32_t seen = trk_log_seen(log);
    const int length =
        snprintf(text, size, "replay of %.200s: %zu samples, %.1f s%s, %s", path, log->count, seconds, rate,
                 seen & TRK_SCREEN ? "gaze at a screen"
                 : seen & TRK_HEAD ? "head pose"
                                   : "no head pose");
    if (*log->assumed && length > 0 && (size_t)length < size)
        snprintf(text + length, size - (size_t)length, "; assumed: %.250s", log->assumed);
}

static void replay_close(struct trk_source *source)
{
    struct replay *replay = (struct replay *)source;
    trk_log_finish(&replay->log);
    trk_source_destroy(source);
}

/* Wait until the next sample is due, counted from the first read. Without pace it is due at once: now, or at
 * the time of the virtual clock. */
static enum trk_result wait_for_next(struct replay *replay, uint64_t log_ns, uint64_t until_ns,
                                     uint64_t *out_arrival_ns)
{
    if (replay->source.speed == 0) {
        *out_arrival_ns = replay->source.virtual_clock ? until_ns : trk_now_ns();
        return TRK_SAMPLE;
    }
    double offset_ns = rint((double)log_ns / replay->source.speed);
    return trk_source_pace(&replay->source, offset_ns < 0x1p63 ? (uint64_t)offset_ns : UINT64_MAX, until_ns,
                           out_arrival_ns);
}

static enum trk_result replay_read(struct trk_source *source, uint64_t until_ns,
                                   struct trk_sample *out_sample, char out_error[TRK_ERROR_SIZE])
{
    (void)out_error;
    struct replay *replay = (struct replay *)source;
    if (replay->next == replay->log.count) {
        if (!replay->loop) return TRK_END;
        replay->next = 0;
        replay->lap++;
    }
    struct trk_sample sample;
    trk_log_sample(&replay->log, replay->next, &sample);
    uint64_t lap_ns = replay->lap * replay->lap_ns, arrival_ns;
    enum trk_result result =
        wait_for_next(replay, lap_ns + sample.device_ns - replay->first_ns, until_ns, &arrival_ns);
    if (result != TRK_SAMPLE) return result;
    *out_sample = sample;
    out_sample->device_ns += lap_ns;
    out_sample->sequence += 1 - replay->first_sequence + replay->lap * replay->lap_sequence;
    out_sample->arrival_ns = arrival_ns;
    replay->next++;
    return TRK_SAMPLE;
}

static const struct trk_source_methods methods = {
    .read = replay_read,
    .close = replay_close,
};

static struct trk_source *replay_open(const char *path, const struct trk_source_options *options,
                                      char out_error[TRK_ERROR_SIZE])
{
    if (!path || !*path) {
        trk_fail(out_error, "gaze source 'replay': expected replay:FILE");
        return NULL;
    }
    if (options->speed != 0 && !(options->speed >= slowest && options->speed <= fastest)) {
        trk_fail(out_error, "replay speed %g: expected %g to %g, or 0 for as fast as it is read",
                 options->speed, slowest, fastest);
        return NULL;
    }
    struct replay *replay = trk_source_create(sizeof *replay, &methods, options->virtual_clock);
    if (!replay) {
        trk_fail(out_error, "%s: no memory", path);
        return NULL;
    }
    if (!trk_log_read(path, &replay->log, out_error)) {
        replay_close(&replay->source);
        return NULL;
    }
    trk_log_rate(&replay->log, &replay->rate);
    replay->source.speed = options->speed;
    replay->source.on_screen = trk_log_seen(&replay->log) & TRK_SCREEN;
    replay->loop = options->loop;
    measure_lap(replay);
    describe(replay, path);
    return &replay->source;
}

const struct trk_source_row trk_replay = {
    .kind = {.name = "replay",
             .usage = "replay:FILE",
             .summary = "a recorded log",
             .follows_eye = true,
             .ends = true},
    .open = replay_open,
};
