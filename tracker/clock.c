/* The map from a device's own time to CLOCK_MONOTONIC: unwrapping, steps, and the line below the delays. */
#include "clock.h"

#include <math.h>
#include <string.h>

/* No delay, and no gap between stamp and arrival, is longer. A larger difference means that the counter has
 * stepped. */
static const double step_ns = 1e9;

/* Stamps are only out of order if they are at most this much older than the last one, or not newer for at
 * most this many samples in a row. */
static const double disorder_ns = 100e6;
enum { DISORDER = 8 };

/* A sample this far below the line shows that the samples that define the line were late, as in a backlog at
 * the start. */
static const double backlog_ns = 20e6;

/* Crystals are accurate to 100 ppm. A steeper slope is not drift. */
static const double steepest = 2e-3;

/* A slope is trusted once this many seconds are known. */
enum { BELIEVED = 3 };

static const double jitter_weight = 1.0 / 256;

void trk_clock_init(struct trk_clock *clock, unsigned bits, double tick_ns)
{
    *clock = (struct trk_clock){.bits = bits, .tick_ns = tick_ns};
}

/* Ticks since the last sample: the shortest way around the counter, plus as many whole turns as the time
 * since then explains. */
static double ticks_since(const struct trk_clock *clock, uint64_t ticks, double waited_ns)
{
    uint64_t mask = clock->bits < 64 ? (UINT64_C(1) << clock->bits) - 1 : UINT64_MAX;
    uint64_t forward = (ticks - clock->ticks) & mask, back = (clock->ticks - ticks) & mask;
    double shortest = forward <= back ? (double)forward : -(double)back;
    double turn = ldexp(1, (int)clock->bits);
    return shortest + turn * rint((waited_ns / clock->tick_ns - shortest) / turn);
}

static double delay_at(const struct trk_clock *clock, double device_ns)
{
    return clock->delay_ns + clock->slope * (device_ns - clock->at_ns);
}

static void forget(struct trk_clock *clock)
{
    clock->seconds = 0;
    clock->slope = clock->mean_ns = clock->variance = 0;
}

/* Find the lower convex hull of the smallest delays per second, and its edge over their mean device time: of
 * all lines below every point, this one has the smallest sum of distances. */
static void fit(struct trk_clock *clock)
{
    const struct trk_clock_second *s = clock->second;
    int hull[TRK_CLOCK_SECONDS] = {0}, corners = 0;
    double mean_ns = 0;
    for (int i = 0; i < clock->seconds; i++) {
        while (corners >= 2) {
            const struct trk_clock_second *a = &s[hull[corners - 2]], *b = &s[hull[corners - 1]];
            if ((b->device_ns - a->device_ns) * (s[i].delay_ns - a->delay_ns) >
                (s[i].device_ns - a->device_ns) * (b->delay_ns - a->delay_ns))
                break;
            corners--;
        }
        hull[corners++] = i;
        mean_ns += s[i].device_ns / clock->seconds;
    }
    int lowest = 0;
    for (int i = 1; i < corners; i++)
        if (s[hull[i]].delay_ns < s[hull[lowest]].delay_ns) lowest = i;
    clock->at_ns = s[hull[lowest]].device_ns;
    clock->delay_ns = s[hull[lowest]].delay_ns;
    clock->slope = 0;
    if (clock->seconds < BELIEVED) return;
    int edge = 1;
    while (edge < corners - 1 && s[hull[edge]].device_ns < mean_ns) edge++;
    const struct trk_clock_second *a = &s[hull[edge - 1]], *b = &s[hull[edge]];
    double slope = (b->delay_ns - a->delay_ns) / (b->device_ns - a->device_ns);
    if (fabs(slope) > steepest) return;
    clock->at_ns = a->device_ns;
    clock->delay_ns = a->delay_ns;
    clock->slope = slope;
}

static void learn(struct trk_clock *clock, double device_ns, double delay_ns)
{
    if (clock->seconds && delay_ns < delay_at(clock, device_ns) - backlog_ns) forget(clock);
    struct trk_clock_second *last = clock->seconds ? &clock->second[clock->seconds - 1] : NULL;
    if (last && floor(last->device_ns / 1e9) == floor(device_ns / 1e9)) {
        if (delay_ns < last->delay_ns) {
            *last = (struct trk_clock_second){device_ns, delay_ns};
            fit(clock);
        }
    } else {
        if (clock->seconds == TRK_CLOCK_SECONDS)
            memmove(clock->second, clock->second + 1, (size_t)--clock->seconds * sizeof *clock->second);
        clock->second[clock->seconds++] = (struct trk_clock_second){device_ns, delay_ns};
        fit(clock);
    }
    double above_ns = delay_ns - delay_at(clock, device_ns), off_ns = above_ns - clock->mean_ns;
    clock->mean_ns += jitter_weight * off_ns;
    clock->variance = (1 - jitter_weight) * (clock->variance + jitter_weight * off_ns * off_ns);
}

/* The device's time at this stamp; trk_clock_add() keeps it from going back. */
static double advance(struct trk_clock *clock, uint64_t ticks, uint64_t arrival_ns)
{
    double waited_ns = (double)(arrival_ns - clock->arrival_ns);
    double since = ticks_since(clock, ticks, waited_ns);
    clock->ticks = ticks;
    clock->arrival_ns = arrival_ns;
    bool stepped = fabs(since * clock->tick_ns - waited_ns) > step_ns;
    double device_ns = 0;
    if (!stepped) {
        clock->elapsed += (int64_t)since;
        device_ns = clock->base_ns + (double)clock->elapsed * clock->tick_ns;
        clock->behind = device_ns <= clock->device_ns ? clock->behind + 1 : 0;
        double since_ns = (double)(arrival_ns - clock->first_arrival_ns);
        stepped = clock->behind > DISORDER || device_ns < clock->device_ns - disorder_ns ||
                  since_ns - device_ns > delay_at(clock, device_ns) + step_ns;
    }
    if (!stepped) return device_ns;
    /* Keep `behind`: while a counter stands still, arrivals tell its time. */
    forget(clock);
    clock->restarts++;
    clock->elapsed = 0;
    clock->base_ns = clock->device_ns + waited_ns;
    return clock->base_ns;
}

void trk_clock_add(struct trk_clock *clock, uint64_t ticks, uint64_t arrival_ns, uint64_t *out_device_ns,
                   uint64_t *out_sensor_ns)
{
    double device_ns = 0;
    if (clock->started) {
        device_ns = advance(clock, ticks, arrival_ns);
    } else {
        clock->started = true;
        clock->ticks = ticks;
        clock->arrival_ns = clock->first_arrival_ns = arrival_ns;
    }
    double since_ns = (double)(arrival_ns - clock->first_arrival_ns);
    if (device_ns >= clock->device_ns) {
        clock->device_ns = device_ns;
        learn(clock, device_ns, since_ns - device_ns);
    }
    double sensor_ns = clock->device_ns + delay_at(clock, clock->device_ns);
    uint64_t told_ns = clock->first_arrival_ns;
    if (sensor_ns > 0) told_ns += (uint64_t)fmin(sensor_ns, since_ns);
    if (told_ns > arrival_ns) told_ns = arrival_ns;
    if (told_ns > clock->sensor_ns) clock->sensor_ns = told_ns;
    *out_device_ns = (uint64_t)clock->device_ns;
    *out_sensor_ns = clock->sensor_ns;
}

void trk_clock_figures(const struct trk_clock *clock, struct trk_clock_figures *out_figures)
{
    *out_figures = (struct trk_clock_figures){
        .jitter_ns = sqrt(clock->variance),
        .drift_ppm = -clock->slope * 1e6,
        .restarts = clock->restarts,
    };
}
