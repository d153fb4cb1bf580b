/* The synthetic observer: it is repeatable, and keeps to the figures of the literature that it is built on.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "source/observer.h"
#include "tracker.h"
#include "tracker_samples.h"

#include <math.h>
#include <string.h>

static void same_seed_same_samples(void **state)
{
    (void)state;
    struct trk_log a, b, c;
    assert_true(trk_synthesise(5, 30, &a));
    assert_true(trk_synthesise(5, 30, &b));
    assert_true(trk_synthesise(6, 30, &c));
    assert_int_equal(a.count, 3600);
    assert_string_equal(a.format, "synthetic");
    assert_true(same_samples(&a, &b));
    assert_false(same_samples(&a, &c));
    assert_int_equal(sample_at(&a, 120)->device_ns, 1000000000);
    trk_log_finish(&a);
    trk_log_finish(&b);
    trk_log_finish(&c);
}

static void no_length_no_log(void **state)
{
    (void)state;
    static const double bad[] = {0, -1, NAN, INFINITY, 1e300, 1e-9};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        struct trk_log log;
        assert_false(trk_synthesise(1, bad[i], &log));
        assert_null(log.samples);
    }
}

/* The source delivers the samples of trk_synthesise() when they are due, and does not end. */
static void source_is_the_same_observer(void **state)
{
    (void)state;
    char error[TRK_ERROR_SIZE] = "";
    struct trk_log log;
    assert_true(trk_synthesise(9, 4, &log));
    struct trk_source_options options = {.spec = "synthetic:9", .virtual_clock = true};
    struct trk_source *source = trk_open(&options, error);
    if (!source) fail_msg("%s", error);
    struct trk_sample sample;
    for (size_t i = 0; i < log.count; i++) {
        const struct trk_sample *expected = sample_at(&log, i);
        if (i > 0) assert_int_equal(trk_read(source, expected->device_ns - 1, &sample, error), TRK_TIMEOUT);
        assert_int_equal(trk_read(source, expected->device_ns, &sample, error), TRK_SAMPLE);
        assert_memory_equal(&sample, expected, sizeof sample);
    }
    assert_int_equal(trk_read(source, UINT64_MAX, &sample, error), TRK_SAMPLE);
    trk_close(source);
    trk_log_finish(&log);
}

/* The peak velocity is 600 (1 - exp(-A / 6)) deg/s; the time above 30 deg/s follows from the same closed
 * form. */
static void saccades_are_on_the_main_sequence(void **state)
{
    (void)state;
    static const struct {
        double amplitude_deg, peak, duration_s;
    } cases[] = {{10, 486.7, 0.039}, {20, 578.6, 0.056}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        double amplitude = cases[i].amplitude_deg, end_s = trk_saccade_s(amplitude), step_s = 1e-5;
        double peak = 0, fast_s = 0;
        for (double t = 0; t < end_s; t += step_s) {
            double speed = (trk_saccade_deg(amplitude, t + step_s) - trk_saccade_deg(amplitude, t)) / step_s;
            assert_true(speed >= 0);
            peak = fmax(peak, speed);
            if (speed > 30) fast_s += step_s;
        }
        assert_float_equal(peak, cases[i].peak, 0.1);
        assert_float_equal(fast_s, cases[i].duration_s, 0.001);
        assert_float_equal(trk_saccade_deg(amplitude, 0), 0, 0.02);
        assert_float_equal(trk_saccade_deg(amplitude, end_s), amplitude, 0.02);
    }
}

enum { MINUTES = 60, TICKS = MINUTES * 60 * TRK_OBSERVER_HZ };

static void fixations_and_saccades(void **state)
{
    (void)state;
    struct trk_observer observer;
    struct trk_sample sample;
    trk_observer_init(&observer, 11);
    double fixations = 0, fixation_s = 0, saccades = 0, amplitude_deg = 0, largest_deg = 0, last_s = 0;
    for (int i = 0; i < TICKS; i++) {
        bool was_saccade = observer.is_saccade;
        trk_observer_next(&observer, &sample);
        if (observer.is_saccade && !was_saccade) {
            fixations++;
            fixation_s += observer.phase_start_s - last_s;
            if (observer.amplitude_deg > 0) {
                saccades++;
                amplitude_deg += observer.amplitude_deg;
                largest_deg = fmax(largest_deg, observer.amplitude_deg);
            }
        }
        if (!observer.is_saccade) last_s = observer.phase_start_s;
    }
    print_message("fixations %.0f, mean %.0f ms; saccades mean %.2f, largest %.1f degrees\n", fixations,
                  fixation_s / fixations * 1000, amplitude_deg / saccades, largest_deg);
    assert_in_range((int)(fixation_s / fixations * 1000), 250, 300);
    assert_true(amplitude_deg / saccades > 5 && amplitude_deg / saccades < 8);
    assert_true(largest_deg <= 30);
}

static double angle_deg(const float a[3], const float b[3])
{
    double x = a[1] * b[2] - a[2] * b[1], y = a[2] * b[0] - a[0] * b[2], z = a[0] * b[1] - a[1] * b[0];
    return atan2(sqrt(x * x + y * y + z * z), a[0] * b[0] + a[1] * b[1] + a[2] * b[2]) * 180 / M_PI;
}

/* While the head turns and the eye fixates, gaze turns against the head in the head frame, and stays still in
 * the world. */
static void gaze_is_stable_while_the_head_moves(void **state)
{
    (void)state;
    enum { STEP = 6 };
    struct trk_observer observer;
    struct trk_sample past[STEP], sample;
    trk_observer_init(&observer, 12);
    double head_deg = 0, eye_deg = 0, world_deg = 0;
    int steady = 0, count = 0;
    double past_head_deg[STEP];
    for (int i = 0; i < TICKS; i++) {
        trk_observer_next(&observer, &sample);
        steady = observer.is_saccade ? 0 : steady + 1;
        float now[3], then[3];
        double turned_deg = fabs(observer.head_deg[0] - past_head_deg[i % STEP]);
        if (steady > STEP && turned_deg > 2 && trk_world_direction(&sample, now) &&
            trk_world_direction(&past[i % STEP], then)) {
            head_deg += turned_deg;
            eye_deg += angle_deg(sample.direction, past[i % STEP].direction);
            world_deg += angle_deg(now, then);
            count++;
        }
        past[i % STEP] = sample;
        past_head_deg[i % STEP] = observer.head_deg[0];
    }
    print_message("head turns %.2f degrees in 50 ms, the eye in it %.2f, gaze in the world %.2f\n",
                  head_deg / count, eye_deg / count, world_deg / count);
    assert_true(count > 1000);
    assert_true(eye_deg > 0.9 * head_deg);
    assert_true(world_deg / count < 0.4); /* what remains is noise, drift and microsaccades */
}

static void blinks_noise_and_dropouts(void **state)
{
    (void)state;
    struct trk_observer observer;
    struct trk_sample last = {0}, sample;
    trk_observer_init(&observer, 13);
    int blinks = 0, dropouts = 0, lost = 0, pairs = 0, low = 0, seen = 0, steady = 0;
    double blink_s = 0, noise = 0;
    for (int i = 0; i < TICKS; i++) {
        trk_observer_next(&observer, &sample);
        steady = observer.is_saccade ? 0 : steady + 1;
        assert_true(sample.valid & TRK_HEAD);
        bool lid = sample.valid & TRK_LEFT_OPENNESS, was_lid = last.valid & TRK_LEFT_OPENNESS;
        if (lid && sample.eye[0].openness < 1) blink_s += 1.0 / TRK_OBSERVER_HZ;
        if (lid && was_lid && sample.eye[0].openness < 1 && last.eye[0].openness == 1) blinks++;
        if (!lid && was_lid) dropouts++;
        if (lid && sample.eye[0].openness < 0.49f) assert_false(sample.valid & TRK_DIRECTION);
        lost += !(sample.valid & TRK_DIRECTION);
        float world[3];
        if (trk_world_direction(&sample, world)) {
            seen++;
            low += fabs(asin(world[1])) < 35 * M_PI / 180;
        }
        bool still = fabs(observer.head_speed[0]) + fabs(observer.head_speed[1]) < 1;
        if (steady > 1 && still && sample.valid & last.valid & TRK_DIRECTION) {
            noise += pow(angle_deg(sample.direction, last.direction), 2);
            pairs++;
        }
        last = sample;
    }
    print_message(
        "blinks %.1f a minute of %.0f ms, drop-outs %.1f a minute, lost %.1f %%, noise %.2f degrees rms, "
        "%.1f %% of gaze within 35 degrees of the horizon\n",
        (double)blinks / MINUTES, blink_s / blinks * 1000, (double)dropouts / MINUTES, 100.0 * lost / TICKS,
        sqrt(noise / pairs), 100.0 * low / seen);
    assert_true(blinks >= 10 * MINUTES && blinks <= 20 * MINUTES);
    assert_true(blink_s / blinks > 0.1 && blink_s / blinks < 0.4);
    assert_true(dropouts >= 3 * MINUTES && dropouts <= 9 * MINUTES);
    assert_true(pairs > 1000 && sqrt(noise / pairs) > 0.1 && sqrt(noise / pairs) < 0.3);
    assert_true(low > 0.85 * seen);
}

/* Samples are made from the truth: without noise and bias they agree with it, and saccades start and land
 * where and when it says. */
static void tells_the_truth(void **state)
{
    (void)state;
    struct trk_observer observer;
    struct trk_sample sample;
    struct trk_truth truth, before = {0};
    int saccades = 0, blinks = 0;
    trk_observer_init_with(&observer, 15, 1000, 0, 0);
    for (int i = 0; i < 60 * 1000; i++) {
        float world[3];
        trk_observer_next(&observer, &sample);
        trk_observer_truth(&observer, &truth);
        assert_int_equal(sample.device_ns, (uint64_t)i * 1000000);
        assert_int_equal(truth.is_hidden, !trk_world_direction(&sample, world));
        if (!truth.is_hidden) assert_true(angle_deg(world, truth.direction) < 0.005);
        assert_true(truth.is_hidden || !truth.is_blink);
        blinks += truth.is_blink && !before.is_blink;
        double t_s = i / 1000.0;
        if (i > 0 && truth.is_saccade && before.is_saccade && truth.saccade_number == before.saccade_number) {
            double speed = angle_deg(truth.direction, before.direction) * 1000;
            bool fast = t_s - 0.002 > truth.onset_s && t_s + 0.001 < truth.end_s;
            bool slow = t_s + 0.001 < truth.onset_s || t_s - 0.002 > truth.end_s;
            assert_true(!fast || speed > 29 || truth.amplitude_deg < 0.4);
            assert_true(!slow || speed < 31 || truth.amplitude_deg < 0.4);
        }
        if (before.is_saccade && !truth.is_saccade) {
            assert_true(angle_deg(before.landing, truth.direction) < 0.2);
            saccades++;
        }
        before = truth;
    }
    assert_true(saccades > 100 && blinks > 5);
}

/* In an hour, gaze has pointed in all directions along the horizon. */
static void goes_all_around(void **state)
{
    (void)state;
    enum { SECTORS = 36 };
    struct trk_observer observer;
    struct trk_sample sample;
    float world[3];
    int visits[SECTORS] = {0};
    trk_observer_init(&observer, 14);
    for (int i = 0; i < TICKS; i++) {
        trk_observer_next(&observer, &sample);
        if (!trk_world_direction(&sample, world)) continue;
        assert_float_equal(sqrt(world[0] * world[0] + world[1] * world[1] + world[2] * world[2]), 1, 1e-5);
        assert_true(sample.direction[2] <
                    -0.5f); /* 60 degrees: the most an eye can turn, plus the tracker's errors */
        visits[(int)((atan2(world[0], -world[2]) / (2 * M_PI) + 0.5) * SECTORS) % SECTORS]++;
    }
    for (int i = 0; i < SECTORS; i++) assert_true(visits[i] > TICKS / SECTORS / 10);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(same_seed_same_samples),
        cmocka_unit_test(no_length_no_log),
        cmocka_unit_test(source_is_the_same_observer),
        cmocka_unit_test(saccades_are_on_the_main_sequence),
        cmocka_unit_test(fixations_and_saccades),
        cmocka_unit_test(gaze_is_stable_while_the_head_moves),
        cmocka_unit_test(blinks_noise_and_dropouts),
        cmocka_unit_test(goes_all_around),
        cmocka_unit_test(tells_the_truth),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
