/* The times of logs: units, times that go back, and clocks that stand still. */
#include "log/clocks.h"

#include "error.h"
#include "log/samples.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

double trk_time_unit(const struct trk_reading *reading, double own_ns)
{
    const char *unit = reading->options->time_unit;
    if (!unit) return own_ns;
    return strcmp(unit, "s") == 0 ? 1e9 : strcmp(unit, "ms") == 0 ? 1e6 : strcmp(unit, "us") == 0 ? 1e3 : 1;
}

bool trk_log_clock_count(struct trk_log_clock *clock, int64_t time_ns, struct trk_reading *reading,
                         uint64_t *out_ns, char out_error[TRK_ERROR_SIZE])
{
    if (!clock->started) {
        clock->started = true;
        clock->first_ns = time_ns;
    }
    int64_t ns = time_ns - clock->first_ns; /* cannot overflow: see trk_parse_time() */
    if (ns < 0 || (uint64_t)ns < clock->last_ns) {
        double back_ns = (double)clock->last_ns - (double)ns;
        if (back_ns > (double)TRK_MAX_STEP_BACK_NS)
            return trk_lines_fail(&reading->lines, out_error,
                                  "time goes back by %g s, expected times in order", back_ns / 1e9);
        reading->held++;
    } else {
        clock->last_ns = (uint64_t)ns;
    }
    *out_ns = clock->last_ns;
    return true;
}

/* --- clocks that stand still --- */

/* A clock that is read more often than it ticks also has mostly steps of 0, but its other steps are as long
 * as one sample. This step is longer than one sample of any tracker, so it shows that times were rounded. */
static const uint64_t coarse_ns = 100000000;

/* Limits for times that are written with an exponent, compared with the value of their last digit. From
 * coarsest_ns on, the times no longer distinguish samples; up to exact_ns, the rounding is not worth a note.
 */
static const double coarsest_ns = 5e7, exact_ns = 1e6;

enum kind { RUNS, STANDS, COARSE };

static uint64_t time_of(const struct trk_log *log, size_t i, int clock)
{
    struct trk_sample sample;
    if (clock == 0) return trk_log_time(log, i);
    trk_log_sample(log, i, &sample);
    return sample.arrival_ns;
}

static enum kind judge(const struct trk_log *log, int clock)
{
    size_t still = 0, far = 0, steps = log->count - 1;
    uint64_t last_ns = time_of(log, 0, clock);
    for (size_t i = 1; i < log->count; i++) {
        const uint64_t time_ns = time_of(log, i, clock), step_ns = time_ns - last_ns;
        last_ns = time_ns;
        still += step_ns == 0;
        far += step_ns >= coarse_ns;
    }
    if (still == steps) return STANDS;
    return still >= (steps + 1) / 2 && 2 * far >= steps - still ? COARSE : RUNS;
}

static bool fail(const struct trk_reading *reading, enum kind kind, char out_error[TRK_ERROR_SIZE])
{
    const char *name = reading->clock_names[0] ? reading->clock_names[0] : "time",
               *text = reading->exponent_time;
    bool is_rounded = *text && !reading->has_plain_times;
    char why[96] = "";
    if (is_rounded) snprintf(why, sizeof why, " (%s: a spreadsheet has rounded them)", text);
    return trk_fail(out_error, "%.200s: %.60s %s%s, expected a clock that runs", reading->lines.path, name,
                    kind == STANDS ? "stands still: all its times are the same"
                                   : "moves in steps of many samples: its times are rounded",
                    why);
}

/* Copy the arrival times to the device times, or the device times to the arrival times. Arrival times need
 * not begin at 0, so the first one is subtracted. False if memory runs out. */
static bool take_clock(struct trk_log *log, bool is_arrival)
{
    const uint64_t first_ns = time_of(log, 0, 1);
    for (size_t i = 0; i < log->count; i++) {
        struct trk_sample sample;
        trk_log_sample(log, i, &sample);
        if (is_arrival)
            sample.device_ns = sample.arrival_ns - first_ns;
        else
            sample.arrival_ns = sample.device_ns;
        if (!trk_samples_put(log, i, &sample)) return false;
    }
    return true;
}

bool trk_check_clocks(struct trk_reading *reading, char out_error[TRK_ERROR_SIZE])
{
    struct trk_log *log = reading->log;
    const char *const *names = reading->clock_names;
    if (log->count < 2) return true;
    enum kind device = judge(log, 0);
    bool is_rounded = *reading->exponent_time && !reading->has_plain_times && !names[1];
    if (is_rounded && device == RUNS && reading->exponent_step_ns >= coarsest_ns) device = COARSE;
    if (is_rounded && device == RUNS && reading->exponent_step_ns > exact_ns)
        trk_assume(reading, "a spreadsheet has rounded the times to %g ms (%s)",
                   reading->exponent_step_ns / 1e6, reading->exponent_time);
    const enum kind host = names[1] ? judge(log, 1) : device;
    if (device != RUNS && host != RUNS) return fail(reading, device, out_error);
    if (device == RUNS && host == RUNS) return true;
    const bool by_host = device != RUNS;
    if (!take_clock(log, by_host)) return trk_fail(out_error, "%.200s: no memory", reading->lines.path);
    trk_assume(reading, "%.60s %s: time is taken from %.60s", names[!by_host],
               (by_host ? device : host) == STANDS ? "stands still" : "is rounded", names[by_host]);
    return true;
}
