/* The synthetic observer as a source and as a recording. */
#include "source/kinds.h"

#include "error.h"
#include "log/lines.h"
#include "log/rows.h"
#include "log/samples.h"
#include "source/observer.h"

#include <math.h>
#include <stdio.h>

struct synthetic {
    struct trk_source source;
    struct trk_observer observer;
    uint64_t seed;
    uint64_t lap_samples; /* after which it ends or starts again; 0: never */
    bool loop;
    uint64_t lap;
    struct trk_sample next; /* drawn already, and not yet due */
    bool has_next;
};

static const uint64_t default_seed = 1;

/* Whole samples in so many seconds, or 0 if that is not a length that a log can have. */
static uint64_t samples_in(double seconds)
{
    double count = rint(seconds * TRK_OBSERVER_HZ);
    return count >= 1 && count <= TRK_MAX_ROWS ? (uint64_t)count : 0;
}

/* A lap is a whole number of samples, and its length in ns is rounded down once, so that laps are all alike.
 */
static bool draw_next(struct synthetic *synthetic)
{
    if (synthetic->lap_samples && synthetic->observer.tick == synthetic->lap_samples) {
        if (!synthetic->loop) return false;
        synthetic->lap++;
        trk_observer_init(&synthetic->observer, synthetic->seed);
    }
    trk_observer_next(&synthetic->observer, &synthetic->next);
    synthetic->next.sequence += synthetic->lap * synthetic->lap_samples;
    synthetic->next.device_ns += synthetic->lap * (synthetic->lap_samples * 1000000000 / TRK_OBSERVER_HZ);
    return true;
}

static enum trk_result synthetic_read(struct trk_source *source, uint64_t until_ns,
                                      struct trk_sample *out_sample, char out_error[TRK_ERROR_SIZE])
{
    (void)out_error;
    struct synthetic *synthetic = (struct synthetic *)source;
    uint64_t due_ns;
    if (!synthetic->has_next && !draw_next(synthetic)) return TRK_END;
    synthetic->has_next = true;
    enum trk_result result = trk_source_pace(source, synthetic->next.device_ns, until_ns, &due_ns);
    if (result != TRK_SAMPLE) return result;
    synthetic->has_next = false;
    *out_sample = synthetic->next;
    out_sample->arrival_ns = due_ns;
    return TRK_SAMPLE;
}

static const struct trk_source_methods methods = {
    .read = synthetic_read,
    .close = trk_source_destroy,
};

static struct trk_source *synthetic_open(const char *argument, const struct trk_source_options *options,
                                         char out_error[TRK_ERROR_SIZE])
{
    int64_t seed = (int64_t)default_seed;
    if (argument && (!trk_parse_int64(argument, &seed) || seed < 0)) {
        trk_fail(out_error, "gaze source 'synthetic:%.100s': expected a whole number from 0 as seed",
                 argument);
        return NULL;
    }
    if (options->seconds != 0 && samples_in(options->seconds) == 0) {
        trk_fail(out_error, "synthetic gaze of %g s: expected 0 for no end, or up to %.0f s",
                 options->seconds, (double)TRK_MAX_ROWS / TRK_OBSERVER_HZ);
        return NULL;
    }
    struct synthetic *synthetic = trk_source_create(sizeof *synthetic, &methods, options->virtual_clock);
    if (!synthetic) {
        trk_fail(out_error, "gaze source 'synthetic': no memory");
        return NULL;
    }
    synthetic->seed = (uint64_t)seed;
    synthetic->loop = options->loop;
    char length[32] = "without end";
    if (options->seconds != 0) {
        synthetic->lap_samples = samples_in(options->seconds);
        snprintf(length, sizeof length, "%.1f s", options->seconds);
    }
    snprintf(synthetic->source.description, sizeof synthetic->source.description,
             "synthetic observer with seed %llu: %s, %d Hz, head pose", (unsigned long long)synthetic->seed,
             length, TRK_OBSERVER_HZ);
    trk_observer_init(&synthetic->observer, synthetic->seed);
    return &synthetic->source;
}

const struct trk_source_row trk_synthetic = {
    .kind = {.name = "synthetic",
             .usage = "synthetic[:SEED]",
             .summary = "a made-up observer",
             .follows_eye = true},
    .open = synthetic_open,
};

bool trk_synthesise(uint64_t seed, double seconds, struct trk_log *out_log)
{
    size_t count = samples_in(seconds);
    *out_log = (struct trk_log){.format = "synthetic"};
    struct trk_observer observer;
    trk_observer_init(&observer, seed);
    bool ok = count > 0;
    while (ok && out_log->count < count) {
        struct trk_sample sample;
        trk_observer_next(&observer, &sample);
        ok = trk_samples_add(out_log, &sample);
    }
    ok = ok && trk_samples_pack(out_log);
    if (!ok) trk_log_finish(out_log);
    return ok;
}
