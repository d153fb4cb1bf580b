/* The synthetic observer as a source and as a log. */
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
    struct trk_sample next; /* already drawn, but not due yet */
    bool has_next;
};

static const uint64_t default_seed = 1;

static enum trk_result synthetic_read(struct trk_source *source, uint64_t until_ns,
                                      struct trk_sample *out_sample, char out_error[TRK_ERROR_SIZE])
{
    (void)out_error;
    struct synthetic *synthetic = (struct synthetic *)source;
    uint64_t due_ns;
    if (!synthetic->has_next) trk_observer_next(&synthetic->observer, &synthetic->next);
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
    struct synthetic *synthetic = trk_source_create(sizeof *synthetic, &methods, options->virtual_clock);
    if (!synthetic) {
        trk_fail(out_error, "gaze source 'synthetic': no memory");
        return NULL;
    }
    snprintf(synthetic->source.description, sizeof synthetic->source.description,
             "synthetic observer with seed %lld: without end, %d Hz, head pose", (long long)seed,
             TRK_OBSERVER_HZ);
    trk_observer_init(&synthetic->observer, (uint64_t)seed);
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
    const double count = rint(seconds * TRK_OBSERVER_HZ);
    bool ok = count >= 1 && count <= TRK_MAX_ROWS;
    struct trk_observer observer;
    *out_log = (struct trk_log){.format = "synthetic"};
    trk_observer_init(&observer, seed);
    while (ok && (double)out_log->count < count) {
        struct trk_sample sample;
        trk_observer_next(&observer, &sample);
        ok = trk_samples_add(out_log, &sample);
    }
    ok = ok && trk_samples_pack(out_log);
    if (!ok) trk_log_finish(out_log);
    return ok;
}
