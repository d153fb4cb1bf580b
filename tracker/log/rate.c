/* The rate of a log. In many logs the steps of time are uneven: a tracker stamps its samples in bursts, a
 * host falls behind and catches up, the times of a camera at 120 Hz are rounded to whole ms, or stamps are
 * skipped. There are also pauses and lost samples, which must not count. So the rate follows from the mean of
 * all steps that are not gaps. The gaps depend on the rate and the rate on the gaps, so the search for both
 * alternates. It starts from the median step; if most steps are even, few of them are gaps compared with the
 * median. If many are, samples come in bursts, and the search starts again from the mean of all steps. */
#include "tracker.h"

/* Steps are even if at least least_even of them are from half to twice the median, and if the search that
 * starts from the median finds at most most_gaps of them to be gaps, or at most most_short_gaps if no gap is
 * longer than the pause of a burst. */
static const double least_even = 0.7, most_gaps = 0.15, most_short_gaps = 0.05;

enum { TURNS = 64 };

/* How many samples may come at once, and how long a step must be to be a gap whatever its neighbours are. */
static const struct burst {
    size_t samples;
    double pause_ns;
} catching_up = {32, 2.5e8}, bursts = {8, 1e8};

static double step_ns(const struct trk_log *log, size_t i)
{
    return (double)(trk_log_time(log, i) - trk_log_time(log, i - 1));
}

/* The time that is missing around a step: the least excess over the mean in any run of up to `samples` steps
 * that includes it. A step that is long only because its neighbours are short, as in bursts, misses little.
 */
static double missing_ns(const struct trk_log *log, double mean_ns, size_t samples, size_t i)
{
    double least = step_ns(log, i) - mean_ns, before = least;
    for (size_t first = i;; before += step_ns(log, --first) - mean_ns) {
        double sum = before;
        for (size_t last = i;; sum += step_ns(log, ++last) - mean_ns) {
            if (sum < least) least = sum;
            if (last + 1 == log->count || last + 1 - first == samples) break;
        }
        if (first == 1 || i + 1 - first == samples) return least;
    }
}

static bool is_gap(const struct trk_log *log, double mean_ns, const struct burst *burst, size_t i)
{
    const double step = step_ns(log, i);
    return step > TRK_GAP_STEPS * mean_ns &&
           (step > burst->pause_ns ||
            missing_ns(log, mean_ns, burst->samples, i) > (TRK_GAP_STEPS - 1) * mean_ns);
}

/* The median step, found digit by digit from the highest, so that no list of all steps is needed. Each pass
 * counts the next digit of the steps that share the digits found so far. */
static uint64_t find_median(const struct trk_log *log)
{
    enum { DIGIT = 11, HIGHEST = 55 }; /* bits */
    size_t rank = (log->count - 1) / 2;
    uint64_t median_ns = 0;
    for (int shift = HIGHEST; shift >= 0; shift -= DIGIT) {
        size_t counts[1 << DIGIT] = {0};
        uint64_t digit = 0, last_ns = trk_log_time(log, 0);
        for (size_t i = 1; i < log->count; i++) {
            const uint64_t time_ns = trk_log_time(log, i), step = time_ns - last_ns;
            last_ns = time_ns;
            if ((step ^ median_ns) >> shift >> DIGIT == 0) counts[step >> shift & ((1 << DIGIT) - 1)]++;
        }
        while (rank >= counts[digit]) rank -= counts[digit++];
        median_ns |= digit << shift;
    }
    return median_ns;
}

/* The fraction of steps that are from half to twice the median. */
static double find_even(const struct trk_log *log, uint64_t median_ns)
{
    size_t even = 0;
    for (size_t i = 1; i < log->count; i++) {
        const uint64_t step = trk_log_time(log, i) - trk_log_time(log, i - 1);
        even += 2 * step >= median_ns && step <= 2 * median_ns;
    }
    return (double)even / (double)(log->count - 1);
}

/* Leave out the steps that are gaps compared with the mean, take the mean of the other steps, and repeat
 * until the number of gaps stays the same. */
static void settle(const struct trk_log *log, double mean_ns, const struct burst *burst,
                   struct trk_rate *rate)
{
    const uint64_t span_ns = trk_log_time(log, log->count - 1) - trk_log_time(log, 0);
    for (int turn = 0; turn < TURNS; turn++) {
        uint64_t gaps_ns = 0;
        size_t last = rate->gaps;
        rate->gaps = rate->longest_ns = 0;
        for (size_t i = 1; i < log->count; i++) {
            if (!is_gap(log, mean_ns, burst, i)) continue;
            uint64_t gap_ns = trk_log_time(log, i) - trk_log_time(log, i - 1);
            gaps_ns += gap_ns;
            if (gap_ns > rate->longest_ns) rate->longest_ns = gap_ns;
            rate->gaps++;
        }
        const size_t steps = log->count - 1 - rate->gaps;
        rate->step_ns = steps ? (span_ns - gaps_ns) / steps : 0;
        rate->hz = span_ns > gaps_ns ? (double)steps * 1e9 / (double)(span_ns - gaps_ns) : 0;
        if (rate->hz == 0 || (turn && rate->gaps == last)) return;
        mean_ns = 1e9 / rate->hz;
    }
}

void trk_log_rate(const struct trk_log *log, struct trk_rate *out_rate)
{
    *out_rate = (struct trk_rate){0};
    if (log->count < 2) return;
    out_rate->median_ns = find_median(log);
    const double steps = (double)(log->count - 1), even = find_even(log, out_rate->median_ns);
    const uint64_t span_ns = trk_log_time(log, log->count - 1) - trk_log_time(log, 0);
    if (out_rate->median_ns) settle(log, (double)out_rate->median_ns, &catching_up, out_rate);
    const double gaps = (double)out_rate->gaps / steps;
    out_rate->in_bursts = out_rate->hz == 0 || even < least_even || gaps > most_gaps ||
                          (gaps > most_short_gaps && (double)out_rate->longest_ns <= bursts.pause_ns);
    if (out_rate->in_bursts && span_ns) settle(log, (double)span_ns / steps, &bursts, out_rate);
}

bool trk_log_is_gap(const struct trk_log *log, const struct trk_rate *rate, size_t i)
{
    return rate->hz > 0 && is_gap(log, 1e9 / rate->hz, rate->in_bursts ? &bursts : &catching_up, i);
}
