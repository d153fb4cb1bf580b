/* Histograms of times, fine enough for percentiles and small enough to keep for ever. */
#include <math.h>

#include "histogram.h"

/* Bins per doubling: each is 2.2 per cent wide, so its middle is right to 1.1 per cent. */
enum { PER_OCTAVE = 32, BINS = sizeof(((struct dmn_histogram *)0)->bin) / sizeof(uint32_t) };

static const double SHORTEST = 1e-6;

void dmn_histogram_add(struct dmn_histogram *histogram, double seconds)
{
    double place = seconds > SHORTEST ? PER_OCTAVE * log2(seconds / SHORTEST) : 0;

    histogram->bin[place < BINS - 1 ? (int)place : BINS - 1]++;
    histogram->count++;
}

double dmn_histogram_quantile(const struct dmn_histogram *histogram, double share)
{
    double wanted = share * (double)histogram->count, seen = 0;

    if (!histogram->count) return 0;
    for (int i = 0; i < BINS; i++) {
        seen += histogram->bin[i];
        if (seen >= wanted && histogram->bin[i]) return SHORTEST * exp2((i + 0.5) / PER_OCTAVE);
    }
    return SHORTEST * exp2((double)BINS / PER_OCTAVE);
}
