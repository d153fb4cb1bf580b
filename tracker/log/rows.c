/* Checks on the samples of every format: order, limits, sorting. */
#include "log/rows.h"

#include "log/clocks.h"
#include "log/samples.h"

#include <stdlib.h>

static bool append(struct trk_reading *reading, const struct trk_sample *sample,
                   char out_error[TRK_ERROR_SIZE])
{
    struct trk_log *log = reading->log;
    if (sample->device_ns > TRK_MAX_DEVICE_NS)
        return trk_check_clocks(reading, out_error) &&
               trk_lines_fail(&reading->lines, out_error, "device time is %.0f days, expected at most %.0f",
                              (double)sample->device_ns / 86400e9, (double)TRK_MAX_DEVICE_NS / 86400e9);
    if (log->count == TRK_MAX_ROWS)
        return trk_lines_fail(&reading->lines, out_error, "is one row too many, expected at most %d",
                              TRK_MAX_ROWS);
    if (!trk_samples_add(log, sample))
        return trk_lines_fail(&reading->lines, out_error, "no memory for more than %zu samples", log->count);
    reading->last_ns = sample->device_ns;
    reading->last_arrival_ns = sample->arrival_ns;
    reading->last_sequence = sample->sequence;
    return true;
}

bool trk_log_append(struct trk_reading *reading, const struct trk_sample *sample,
                    char out_error[TRK_ERROR_SIZE])
{
    uint64_t slack = reading->disordered ? TRK_MAX_DISORDER_NS : 0;
    if (sample->device_ns + slack < reading->last_ns)
        return trk_lines_fail(&reading->lines, out_error, "device time goes back by %llu ns, expected %s",
                              (unsigned long long)(reading->last_ns - sample->device_ns),
                              slack ? "less than a second" : "times in order");
    if (sample->arrival_ns + slack < reading->last_arrival_ns)
        return trk_lines_fail(&reading->lines, out_error,
                              "arrival time goes back by %llu ns, expected times in order",
                              (unsigned long long)(reading->last_arrival_ns - sample->arrival_ns));
    if (sample->sequence <= reading->last_sequence)
        return trk_lines_fail(&reading->lines, out_error, "sequence %llu, expected more than %llu",
                              (unsigned long long)sample->sequence,
                              (unsigned long long)reading->last_sequence);
    if (sample->device_ns < reading->last_ns) reading->late++;
    return append(reading, sample, out_error);
}

/* The index and the time of a sample. */
struct moment {
    uint64_t device_ns;
    size_t place;
};

static int by_time(const void *a, const void *b)
{
    const struct moment *x = a, *y = b;
    if (x->device_ns != y->device_ns) return x->device_ns > y->device_ns ? 1 : -1;
    return (x->place > y->place) - (x->place < y->place);
}

/* Sort by time; samples of equal time keep their order. False if memory runs out. */
static bool sort(struct trk_log *log)
{
    struct moment *moments = malloc(log->count * sizeof *moments);
    struct trk_log sorted = {0};
    bool ok = moments != NULL;
    for (size_t i = 0; i < log->count && ok; i++) moments[i] = (struct moment){trk_log_time(log, i), i};
    if (ok) qsort(moments, log->count, sizeof *moments, by_time);
    for (size_t i = 0; i < log->count && ok; i++) {
        struct trk_sample sample;
        trk_log_sample(log, moments[i].place, &sample);
        ok = trk_samples_add(&sorted, &sample);
    }
    free(moments);
    trk_samples_destroy(ok ? log->samples : sorted.samples);
    if (ok) log->samples = sorted.samples;
    return ok;
}

bool trk_rows_sort(struct trk_reading *reading)
{
    struct trk_log *log = reading->log;
    if (reading->late) {
        if (!sort(log)) return false;
        trk_assume(reading, "rows out of order, sorted by time: %zu", reading->late);
    }
    const uint64_t first_ns = trk_log_time(log, 0);
    for (size_t i = 0; i < log->count; i++) {
        struct trk_sample sample;
        trk_log_sample(log, i, &sample);
        sample.device_ns -= first_ns;
        sample.arrival_ns = sample.device_ns;
        sample.sequence = i + 1;
        if (!trk_samples_put(log, i, &sample)) return false;
    }
    return true;
}
