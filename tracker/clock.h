/* clock: maps a device's own time to CLOCK_MONOTONIC.
 *
 * A device stamps its samples with a counter that has a limited number of bits, drifts, wraps, repeats values
 * and starts again. A sample arrives some time after its stamp, never before it. The map is the line that
 * lies closest below all points (device time, delay) of the last half minute: the edge of their lower convex
 * hull at their mean device time (Moon, Skelly and Towsley 1999; Zhang, Liu and Xia 2002). The smallest delay
 * is unknown, so a mapped time is late by that delay.
 *
 * The functions are pure: no threads, no system clock. Only for sources that have a device clock. */
#ifndef FOVEAD_TRACKER_CLOCK_H
#define FOVEAD_TRACKER_CLOCK_H

#include <stdbool.h>
#include <stdint.h>

enum { TRK_CLOCK_SECONDS = 32 };

struct trk_clock_second {
    double device_ns, delay_ns; /* of the sample with the smallest delay in one second of device time */
};

struct trk_clock {
    unsigned bits;
    double tick_ns;
    bool started;
    uint64_t ticks, arrival_ns; /* of the last sample */
    uint64_t first_arrival_ns;
    int64_t elapsed; /* ticks since base_ns */
    double base_ns;
    double device_ns; /* the latest time that was returned; it never goes back */
    uint64_t sensor_ns;
    unsigned behind; /* how many samples in a row were not later than device_ns */
    int seconds;     /* how many entries of second are in use, oldest first */
    struct trk_clock_second second[TRK_CLOCK_SECONDS];
    double at_ns, delay_ns, slope; /* the line: the delay is delay_ns at device time at_ns */
    double mean_ns, variance;      /* mean and variance of the delay above the line */
    unsigned restarts;
};

struct trk_clock_figures {
    double jitter_ns; /* standard deviation of the delay above the line, over the last few hundred samples */
    double drift_ppm; /* how much faster the device's clock runs than ours; 0 until three seconds are known */
    unsigned restarts; /* how often the device's time stepped, so that the map started anew */
};

/* bits: width of the counter, 1 to 64. tick_ns: length of a tick, above 0. */
void trk_clock_init(struct trk_clock *clock, unsigned bits, double tick_ns);

/* Take the stamp of a sample. out_device_ns is the device's time, unwrapped: 0 at the first sample, and never
 * going back. A step of the counter that the time of arrival does not explain is left out. out_sensor_ns is
 * the same time on the clock of arrival_ns: never after arrival_ns, and never going back. arrival_ns must not
 * go back. */
void trk_clock_add(struct trk_clock *clock, uint64_t ticks, uint64_t arrival_ns, uint64_t *out_device_ns,
                   uint64_t *out_sensor_ns);

void trk_clock_figures(const struct trk_clock *clock, struct trk_clock_figures *out_figures);

#endif
