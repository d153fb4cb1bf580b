/* What to render for while gaze is known: filtered, predicted, frozen, steady as the head turns. */
#include "tracker_attention.h"

#include "source/observer.h"
#include "tracker_samples.h"

#include <stdlib.h>

static void one_eye_is_enough(void **state)
{
    (void)state;
    for (int i = 0; i < 30; i++) {
        struct trk_sample s = sample_of(TRK_LEFT_DIRECTION, 10);
        at(90, 0, s.eye[1].direction); /* not valid */
        take(&s);
    }
    is(TRK_FIXATION, "left eye");
    aims_at(10, 0.01);
    for (int i = 0; i < 30; i++) {
        struct trk_sample s = sample_of(TRK_RIGHT_DIRECTION, 10);
        at(90, 0, s.eye[0].direction);
        take(&s);
    }
    is(TRK_FIXATION, "right eye");
    aims_at(10, 0.01);
    for (int i = 0; i < 30; i++) {
        struct trk_sample s = sample_of(TRK_LEFT_DIRECTION | TRK_RIGHT_DIRECTION, 0);
        at(9, 0, s.eye[0].direction);
        at(11, 0, s.eye[1].direction);
        take(&s);
    }
    is(TRK_FIXATION, "both eyes");
    aims_at(10, 0.01);
}

/* The aim ignores shifts of less than a degree. A larger shift moves the aim at once if it is a saccade. */
static void dead_zone(void **state)
{
    (void)state;
    look(60, 0);
    look(120, 0.8);
    aims_at(0, 0.01);
    assert_false(gaze.moved);
    look(240, 1.6); /* the step is too small for an onset, so the filter follows it */
    assert_true(gaze.direction[0] > sin(0.8 * M_PI / 180));
    look(1, 12);
    aims_at(12, 0.01);
    is(TRK_SACCADE, "both eyes");
    look(30, 12);
    is(TRK_FIXATION, "both eyes");
    aims_at(12, 0.01);
    begin(&(struct trk_attention_options){.raw = true});
    look(60, 0);
    look(1, 0.5);
    aims_at(0.5, 0.001);
}

/* Pursuit at 20 deg/s: the aim follows outside any dead zone, with the lag of a low-pass of 3.6 Hz, about 40
 * ms. */
static void pursuit(void **state)
{
    (void)state;
    look(60, 0);
    for (int i = 0; i < 120; i++) {
        double azimuth = i / 6.0;
        look(1, azimuth);
        assert_int_not_equal(gaze.state, TRK_SACCADE);
        if (i < 60) continue;
        is(TRK_PURSUIT, "both eyes");
        assert_true(gaze.moved);
        aims_at(azimuth - 0.8, 0.3);
    }
}

static void freezing(void **state)
{
    (void)state;
    look(60, 10);
    trk_attention_freeze(attention, true);
    look(60, -40);
    is(TRK_FROZEN, "last gaze");
    aims_at(10, 0.01);
    assert_false(gaze.moved);
    assert_int_equal(gaze.sequence, 120);
    hide(600, 0);
    is(TRK_FROZEN, "last gaze");
    assert_true(gaze.spread == 1);
    look(60, -40);
    trk_attention_freeze(attention, false);
    trk_attend(attention, NULL, 5000 * MS + now_ns(), &gaze);
    is(TRK_FIXATION, "both eyes");
    aims_at(-40, 0.01);
    assert_true(gaze.moved);
}

/* The eyes hold a still target while the head turns at 60 deg/s. The filter works in the world frame, so the
 * aim does not move. */
static void head_turns(void **state)
{
    (void)state;
    for (int i = 0; i < 240; i++) {
        double turned = i < 60 ? 0 : (i - 60) * 0.5;
        struct trk_sample s = sample_of(TRK_DIRECTION | TRK_HEAD, 30 - turned);
        turn_head(&s, turned);
        take(&s);
        is(TRK_FIXATION, "both eyes");
        aims_at(30, 0.02);
    }
    for (int i = 0; i < 400; i++) {
        struct trk_sample s = sample_of(TRK_HEAD, 0);
        turn_head(&s, 50);
        take(&s);
    }
    is(TRK_FALLBACK, "view centre");
    aims_at(50, 0.01);
}

/* Without noise, prediction is never worse than following the gaze, and in mid-flight it removes at least two
 * fifths of the distance that is left. */
static void prediction(void **state)
{
    (void)state;
    static const double amplitudes[] = {5, 8, 10, 13};
    for (size_t k = 0; k < sizeof amplitudes / sizeof *amplitudes; k++) {
        begin(&(struct trk_attention_options){.predict = true});
        look(60, 0);
        double best = 1;
        for (int i = 0; i < 12; i++) {
            double azimuth = trk_saccade_deg(amplitudes[k], (i + 1) / 120.0), left = amplitudes[k] - azimuth;
            look(1, azimuth);
            if (gaze.state != TRK_SACCADE) continue;
            is(TRK_SACCADE, "prediction");
            float landing[3];
            at(amplitudes[k], 0, landing);
            double error = trk_angle_deg(landing, gaze.direction);
            assert_true(error < left + 0.1);
            if (left > 1) best = fmin(best, error / left);
        }
        assert_true(best < 0.6);
        aims_at(amplitudes[k], 0.1);
    }
}

/* The same calls give the same answers, bit for bit. */
static void repeats_itself(void **state)
{
    (void)state;
    struct trk_log log;
    assert_true(trk_synthesise(3, 60, &log));
    struct trk_aim *first = calloc(log.count, sizeof *first);
    assert_non_null(first);
    for (int pass = 0; pass < 2; pass++) {
        begin(&(struct trk_attention_options){.predict = true});
        for (size_t i = 0; i < log.count; i++) {
            memset(&gaze, 0, sizeof gaze);
            trk_attend(attention, sample_at(&log, i), sample_at(&log, i)->arrival_ns, &gaze);
            if (pass == 0)
                first[i] = gaze;
            else
                assert_memory_equal(&gaze, &first[i], sizeof gaze);
            assert_float_equal(glm_vec3_norm(gaze.direction), 1, 1e-5);
        }
    }
    free(first);
    trk_log_finish(&log);
}

/* Whatever the bytes of a sample are, the answer is a direction. */
static void anything(void **state)
{
    (void)state;
    uint64_t seed = 1, arrival_ns = 0;
    for (int i = 0; i < 200000; i++) {
        struct trk_sample s;
        unsigned char bytes[sizeof s];
        for (size_t k = 0; k < sizeof bytes; k++)
            bytes[k] = (unsigned char)((seed = seed * 6364136223846793005 + 1442695040888963407) >> 56);
        memcpy(&s, bytes, sizeof s);
        if (i % 2) s.device_ns = (uint64_t)i * 8333333; /* otherwise time jumps */
        if (i % 3) at((double)(seed >> 40) / 1e5, 20, s.direction);
        if (i % 5) s.head[3] = s.head[4] = s.head[5] = 0, s.head[6] = 1;
        s.arrival_ns = arrival_ns += seed >> 38;
        take(&s);
        assert_float_equal(glm_vec3_norm(gaze.direction), 1, 1e-4);
        assert_true(gaze.spread >= 1 && gaze.spread <= 4 && gaze.noise_deg > 0 && gaze.noise_deg < 180);
        assert_non_null(gaze.why);
        assert_non_null(gaze.source);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(one_eye_is_enough), TEST(dead_zone),  TEST(pursuit),        TEST(freezing),
        TEST(head_turns),        TEST(prediction), TEST(repeats_itself), TEST(anything),
    };
    return cmocka_run_group_tests_name("tracker_attention", tests, NULL, NULL);
}
