/* The map from a device's clock to ours: drift, jitter, wraps, duplicates, steps, and a counter that stands
 * still. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "clock.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* A device whose microsecond counter has a limited number of bits and runs at `rate`. A sample arrives
 * base_ns plus an exponentially distributed time after it is taken. */
struct device {
    struct trk_clock clock;
    uint64_t seed, now_ns, mask;
    double rate, base_ns, jitter_ns;
    uint64_t counter; /* at time 0 */
    uint64_t arrival_ns, device_ns, sensor_ns;
};

static struct device make(unsigned bits, double drift_ppm, double base_ns, double jitter_ns)
{
    struct device d = {
        .seed = 7,
        .mask = bits < 64 ? (UINT64_C(1) << bits) - 1 : UINT64_MAX,
        .rate = 1 + drift_ppm * 1e-6,
        .base_ns = base_ns,
        .jitter_ns = jitter_ns,
        .now_ns = 5000000000,
    };
    trk_clock_init(&d.clock, bits, 1000);
    return d;
}

static double uniform(struct device *d)
{
    d->seed = d->seed * 6364136223846793005u + 1442695040888963407u;
    return ((double)(d->seed >> 11) + 0.5) * 0x1p-53;
}

/* Take a sample step_ns after the last one. Returns its mapped time less the true one. */
static double sample(struct device *d, uint64_t step_ns)
{
    d->now_ns += step_ns;
    uint64_t ticks = (d->counter + (uint64_t)((double)d->now_ns * d->rate / 1000)) & d->mask;
    uint64_t arrival_ns = d->now_ns + (uint64_t)(d->base_ns - d->jitter_ns * log(uniform(d)));
    uint64_t device_ns = d->device_ns, sensor_ns = d->sensor_ns;
    if (arrival_ns > d->arrival_ns) d->arrival_ns = arrival_ns;
    trk_clock_add(&d->clock, ticks, d->arrival_ns, &d->device_ns, &d->sensor_ns);
    assert_true(d->device_ns >= device_ns);
    assert_true(d->sensor_ns >= sensor_ns);
    assert_true(d->sensor_ns <= d->arrival_ns);
    return (double)d->sensor_ns - (double)d->now_ns;
}

static void run(struct device *d, int samples)
{
    while (samples-- > 0) sample(d, 2000000);
}

/* Ten minutes at 500 Hz: mapped times are late by the smallest delay; drift and jitter are found. */
static void drift_and_jitter(void **state)
{
    (void)state;
    static const double drifts[] = {-500, -50, 0, 50, 500};
    for (int k = 0; k < 5; k++) {
        struct device d = make(64, drifts[k], 1e6, 500e3);
        struct trk_clock_figures figures;
        double worst = 0;
        run(&d, 5000);
        for (int i = 0; i < 300000; i++) worst = fmax(worst, fabs(sample(&d, 2000000) - 1e6));
        trk_clock_figures(&d.clock, &figures);
        assert_true(worst < 60e3); /* ns; the delay is 500 us on average */
        assert_true(fabs(figures.drift_ppm - drifts[k]) < 5);
        assert_true(fabs(figures.jitter_ns - 500e3) < 150e3);
        assert_int_equal(figures.restarts, 0);
    }
}

static void no_jitter_is_exact(void **state)
{
    (void)state;
    struct device d = make(64, 0, 250e3, 0);
    for (int i = 0; i < 20000; i++) assert_true(fabs(sample(&d, 1000000) - 250e3) < 2);
    assert_int_equal(d.device_ns, 19999 * UINT64_C(1000000));
}

static void wraps_are_unseen(void **state)
{
    (void)state;
    static const unsigned bits[] = {16, 24, 31, 32, 64};
    for (int k = 0; k < 5; k++) {
        struct device d = make(bits[k], 0, 1e6, 100e3);
        d.counter = d.mask - 4000000; /* wraps at once; a short counter wraps more than once */
        sample(&d, 2000000);
        for (int i = 1; i <= 5000; i++) {
            sample(&d, 2000000);
            assert_int_equal(d.device_ns, (uint64_t)i * 2000000);
        }
        struct trk_clock_figures figures;
        trk_clock_figures(&d.clock, &figures);
        assert_int_equal(figures.restarts, 0);
    }
}

/* After a silence longer than one turn of the counter, the arrival tells how many turns have passed. */
static void silence_beyond_a_wrap(void **state)
{
    (void)state;
    struct device d = make(24, 0, 1e6, 100e3); /* 16.8 s */
    run(&d, 1000);
    uint64_t before_ns = d.device_ns;
    sample(&d, UINT64_C(100000000000));
    assert_int_equal(d.device_ns - before_ns, UINT64_C(100000000000));
    assert_true(fabs(sample(&d, 2000000) - 1e6) < 200e3);
}

static void duplicates_stand_still(void **state)
{
    (void)state;
    struct device d = make(32, 0, 1e6, 100e3);
    run(&d, 1000);
    uint64_t device_ns = d.device_ns;
    for (int i = 0; i < 5; i++) {
        sample(&d, 0);
        assert_int_equal(d.device_ns, device_ns);
    }
    sample(&d, 2000000);
    assert_int_equal(d.device_ns, device_ns + 2000000);
    struct trk_clock_figures figures;
    trk_clock_figures(&d.clock, &figures);
    assert_int_equal(figures.restarts, 0);
}

/* One stamp in a hundred is 5 ms too old: its time is held, and the errors do not add up. */
static void disorder_is_held(void **state)
{
    (void)state;
    struct device d = make(64, 0, 1e6, 100e3);
    sample(&d, 2000000);
    for (int i = 1; i <= 50000; i++) {
        d.counter -= i % 100 == 50 ? 5000 : 0;
        sample(&d, 2000000);
        d.counter += i % 100 == 50 ? 5000 : 0;
    }
    assert_int_equal(d.device_ns, 50000 * UINT64_C(2000000));
    struct trk_clock_figures figures;
    trk_clock_figures(&d.clock, &figures);
    assert_int_equal(figures.restarts, 0);
}

/* The counter jumps forward or back for good: the map starts anew from the last time, and is right again
 * soon. */
static void steps_are_left_out(void **state)
{
    (void)state;
    static const double steps_us[] = {-30e3, -300e3, -3e6, -1e9, 3e6, 1e9};
    for (int k = 0; k < 6; k++) {
        struct device d = make(64, 0, 1e6, 100e3);
        d.counter = 2000000000;
        run(&d, 5000);
        uint64_t before_ns = d.device_ns, at_ns = d.now_ns;
        d.counter += (uint64_t)(int64_t)steps_us[k];
        run(&d, 100);
        assert_true(fabs((double)(d.device_ns - before_ns) - (double)(d.now_ns - at_ns)) < 20e6);
        run(&d, 5000);
        for (int i = 0; i < 1000; i++) assert_true(fabs(sample(&d, 2000000) - 1e6) < 200e3);
        struct trk_clock_figures figures;
        trk_clock_figures(&d.clock, &figures);
        assert_int_equal(figures.restarts, 1);
    }
}

/* At the start the samples of a backlog arrive late. They are forgotten once others arrive in time. */
static void backlog_is_forgotten(void **state)
{
    (void)state;
    struct device d = make(64, 0, 128e6, 0);
    while (d.base_ns > 1e6) {
        sample(&d, 2000000);
        d.base_ns -= 1.9e6;
    }
    d.base_ns = 1e6;
    run(&d, 10);
    for (int i = 0; i < 1000; i++) assert_true(fabs(sample(&d, 2000000) - 1e6) < 100e3);
}

/* Counters that stand still or count in another unit than they claim: arrival replaces them, and the mapped
 * time is never far from it. */
static void useless_counters(void **state)
{
    (void)state;
    static const double rates[] = {0, 1e-6, 1000, 1e6};
    for (int k = 0; k < 4; k++) {
        struct device d = make(64, 0, 1e6, 100e3);
        d.rate = rates[k];
        run(&d, 100);
        for (int i = 0; i < 5000; i++) {
            sample(&d, 2000000);
            assert_true(d.arrival_ns - d.sensor_ns <= 1100000000);
        }
        assert_true(fabs((double)d.device_ns - 5099 * 2e6) < 1.5e9);
        struct trk_clock_figures figures;
        trk_clock_figures(&d.clock, &figures);
        assert_true(figures.restarts > 5);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(drift_and_jitter),       cmocka_unit_test(no_jitter_is_exact),
        cmocka_unit_test(wraps_are_unseen),       cmocka_unit_test(silence_beyond_a_wrap),
        cmocka_unit_test(duplicates_stand_still), cmocka_unit_test(disorder_is_held),
        cmocka_unit_test(steps_are_left_out),     cmocka_unit_test(backlog_is_forgotten),
        cmocka_unit_test(useless_counters),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
