/* The rate of a log and its gaps, by steps of time as trackers and hosts make them. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "log/samples.h"
#include "tracker.h"

static struct trk_log log_made;

static void add(uint64_t device_ns)
{
    assert_true(trk_samples_add(&log_made, &(const struct trk_sample){.device_ns = device_ns}));
}

static void begin(void)
{
    trk_log_finish(&log_made);
    add(0);
}

static void step(double ms)
{
    add(trk_log_time(&log_made, log_made.count - 1) + (uint64_t)(ms * 1e6));
}

/* Append these steps in turn, n times. */
static void steps(int n, const double *ms, int count)
{
    for (int i = 0; i < n; i++)
        for (int k = 0; k < count; k++) step(ms[k]);
}
#define STEPS(n, ...)                                                                                        \
    steps(n, (const double[]){__VA_ARGS__}, sizeof((const double[]){__VA_ARGS__}) / sizeof(double))

static void is(double low_hz, double high_hz, size_t gaps, double longest_ms)
{
    struct trk_rate rate;
    size_t found = 0;
    trk_log_rate(&log_made, &rate);
    if (rate.hz < low_hz || rate.hz > high_hz || rate.gaps != gaps)
        fail_msg("%.2f Hz and %zu gaps, expected %g to %g and %zu", rate.hz, rate.gaps, low_hz, high_hz,
                 gaps);
    assert_float_equal((double)rate.longest_ns / 1e6, longest_ms, 1e-6);
    for (size_t i = 1; i < log_made.count; i++) found += trk_log_is_gap(&log_made, &rate, i);
    assert_int_equal(found, gaps);
}

static void even_steps(void **state)
{
    (void)state;
    begin();
    is(0, 0, 0, 0);
    step(5);
    is(200, 200, 0, 0);
    begin();
    STEPS(100, 5);
    is(200, 200, 0, 0);
    step(12);
    is(196, 200, 0, 0);
    step(50);
    STEPS(100, 5);
    is(198, 201, 1, 50);
    begin();
    STEPS(3, 0);
    is(0, 0, 0, 0);
}

static void pauses(void **state)
{
    (void)state;
    begin();
    for (int block = 0; block < 3; block++) {
        if (block) step(1004);
        STEPS(9, 4);
    }
    is(250, 250, 2, 1004);
    begin();
    for (int block = 0; block < 8; block++) {
        if (block) step(200);
        STEPS(19, 5);
    }
    is(200, 200, 7, 200);
    begin();
    for (int block = 0; block < 3; block++) {
        if (block) step(700);
        STEPS(5, 8, 9, 8);
    }
    is(119, 121, 2, 700);
}

static void whole_ms_and_skipped_stamps(void **state)
{
    (void)state;
    begin();
    STEPS(40, 8, 8, 9);
    is(119.9, 120.1, 0, 0);
    begin();
    STEPS(10, 4, 4, 4, 8);
    is(200, 200, 0, 0);
    begin();
    STEPS(20, 16, 17, 17, 33); /* 60 Hz, where one sample in five is missing */
    is(48, 48.3, 0, 0);
}

static void bursts(void **state)
{
    (void)state;
    begin();
    STEPS(40, 2.4, 14.4);
    is(119, 119.1, 0, 0);
    step(100);
    STEPS(40, 2.4, 14.4);
    is(118, 120, 1, 100);
    begin();
    STEPS(40, 0, 16.7); /* stamped in pairs */
    is(119, 121, 0, 0);
    begin();
    STEPS(40, 1, 1, 23);
    is(119.9, 122, 0, 0);
    begin();
    STEPS(40, 0.5, 0.5, 0.5, 31.8);
    is(120, 122, 0, 0);
    begin();
    STEPS(30, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 65.9);
    is(120, 122, 0, 0);
}

/* A host was held up and then stamps all waiting samples at once: no sample is missing. */
static void catching_up(void **state)
{
    (void)state;
    begin();
    STEPS(300, 8.3);
    step(108.5);
    STEPS(12, 0.06);
    STEPS(300, 8.3);
    is(119, 121, 0, 0);
    step(108.5);
    STEPS(300, 8.3);
    is(119, 121, 1, 108.5);
}

static int finish(void **state)
{
    (void)state;
    trk_log_finish(&log_made);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(even_steps),
        cmocka_unit_test(pauses),
        cmocka_unit_test(whole_ms_and_skipped_stamps),
        cmocka_unit_test(bursts),
        cmocka_unit_test(catching_up),
    };
    return cmocka_run_group_tests(tests, NULL, finish);
}
