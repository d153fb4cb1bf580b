/* clock: maps a device's own time to CLOCK_MONOTONIC.
 *
 * A device stamps its samples with a counter that has a limited number of bits, drifts, wraps, repeats values
 * and starts again. A sample arrives some time after its stamp, never before it. The map is the line that
 * lies closest below all (device time, delay) points of the last half minute: the edge of their lower convex
 * hull at their mean device time (Moon, Skelly and Towsley 1999; Zhang, Liu and Xia 2002). It cannot know the
 * smallest delay, so a mapped time is late by that delay.
 *
 * Pure: no threads, no system clock. Only for sources that have a device clock. */
#ifndef FOVEAD_TRACKER_CLOCK_H
#define FOVEAD_TRACKER_CLOCK_H

#include <stdbool.h>
#include <stdint.h>

enum { TRK_CLOCK_SECONDS = 32 };

struct trk_clock_second {
    double device_ns, delay_ns; /* of the least delayed sample of one second of device time */
};

struct trk_clock {
    unsigned bits;
    double tick_ns;
    bool started;
    uint64_t ticks, arrival_ns; /* of the last sample */
    uint64_t first_arrival_ns;
    int64_t elapsed; /* ticks since base_ns */
    double base_ns;
    double device_ns; /* the latest that was returned: it never goes back */
    uint64_t sensor_ns;
    unsigned behind; /* how many samples in a row were not after device_ns */
    int seconds;     /* how many are kept, oldest first */
    struct trk_clock_second second[TRK_CLOCK_SECONDS];
    double at_ns, delay_ns, slope; /* the line: delay_ns at device time at_ns */
    double mean_ns, variance;      /* of the delay above the line */
    unsigned restarts;
};

struct trk_clock_figures {
    double jitter_ns; /* standard deviation of the delay above the fit, over the last few hundred samples */
    double drift_ppm; /* how much faster than ours the device's clock runs; 0 until three seconds are known */
    unsigned restarts; /* how often the device's time stepped and the map began anew */
};

/* A counter of bits bits (1 to 64) whose ticks last tick_ns (> 0). */
void trk_clock_init(struct trk_clock *clock, unsigned bits, double tick_ns);

/* Take a sample's stamp. out_device_ns: the device's time, unwrapped, from 0 at the first sample, never going
 * back; a step of the counter that the time of arrival does not explain is left out. out_sensor_ns: that time
 * on the clock of arrival_ns; never after arrival_ns, never going back. arrival_ns must not go back. */
void trk_clock_add(struct trk_clock *clock, uint64_t ticks, uint64_t arrival_ns, uint64_t *out_device_ns,
                   uint64_t *out_sensor_ns);

void trk_clock_figures(const struct trk_clock *clock, struct trk_clock_figures *out_figures);

#endif
