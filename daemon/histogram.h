/* histogram: of times, fine enough for percentiles and small enough to keep for ever. */
#ifndef FOVEAD_DAEMON_HISTOGRAM_H
#define FOVEAD_DAEMON_HISTOGRAM_H

#include <stdint.h>

/* Counts of times in bins of two per cent, from a microsecond to two hours. All zero: empty. */
struct dmn_histogram {
    uint64_t count;
    uint32_t bin[1088];
};

void dmn_histogram_add(struct dmn_histogram *histogram, double seconds);
/* The time below which share (0 to 1) of all times lie; 0 if there are none. */
double dmn_histogram_quantile(const struct dmn_histogram *histogram, double share);

#endif
