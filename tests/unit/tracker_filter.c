/* The one-euro filter: its closed forms, and that it works the same everywhere on the sphere. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "arc.h"
#include "filter.h"

static const double dt_s = 1 / 120.0;

static void at(double azimuth_deg, double elevation_deg, float out[3])
{
    double a = azimuth_deg * M_PI / 180, e = elevation_deg * M_PI / 180;
    out[0] = (float)(sin(a) * cos(e));
    out[1] = (float)sin(e);
    out[2] = (float)(-cos(a) * cos(e));
}

/* Casiez et al. 2012, equations 1 and 2. */
static double share(double cutoff_hz)
{
    return 1 / (1 + 1 / (2 * M_PI * cutoff_hz * dt_s));
}

static void arcs_there_and_back(void **state)
{
    (void)state;
    static const double places[][4] = {{0, 0, 10, 0},    {179, 5, -179, -5}, {20, 89, -160, 89},
                                       {0, -90, 50, 10}, {0, 0, 120, 0},     {33, 33, 33, 33}};
    for (size_t i = 0; i < sizeof places / sizeof *places; i++) {
        float from[3], to[3], end[3];
        vec3 arc;
        at(places[i][0], places[i][1], from);
        at(places[i][2], places[i][3], to);
        trk_arc(from, to, arc);
        assert_float_equal(glm_vec3_norm(arc), trk_angle_deg(from, to), 1e-3);
        trk_along(from, arc, end);
        assert_float_equal(trk_angle_deg(end, to), 0, 1e-3);
    }
    float from[3] = {0, 0, -1}, to[3] = {0, 0, 1};
    vec3 arc;
    trk_arc(from, to, arc);
    assert_float_equal(glm_vec3_norm(arc), 180, 1e-3);
    assert_float_equal(arc[2], 0, 1e-3);
}

/* The first samples after a reset count alike, as in a plain mean, until the low-pass weighs a new sample
 * more. */
static void begins_as_a_mean(void **state)
{
    (void)state;
    struct trk_filter filter = {0};
    static const double azimuth[] = {1, -1, 3, 5};
    float direction[3], mean[3];
    for (int i = 0; i < 4; i++) {
        at(azimuth[i] * 0.01, 0, direction);
        trk_filter_step(&filter, direction, dt_s);
    }
    at(0.02, 0, mean);
    assert_float_equal(trk_angle_deg(filter.value, mean), 0, 2e-4);
    trk_filter_reset(&filter);
    at(90, 0, direction);
    trk_filter_step(&filter, direction, dt_s);
    assert_memory_equal(filter.value, direction, sizeof direction);
}

/* At a constant speed, the low-passed speed equals it, and the lag is that of a first-order low-pass. */
static void lags_as_it_must(void **state)
{
    (void)state;
    static const double speeds[] = {5, 20, 60};
    for (size_t i = 0; i < sizeof speeds / sizeof *speeds; i++) {
        struct trk_filter filter = {0};
        float direction[3];
        for (int k = 0; k < 360; k++) {
            at(speeds[i] * k * dt_s, 0, direction);
            trk_filter_step(&filter, direction, dt_s);
        }
        double alpha = share(2 + 0.08 * speeds[i]);
        assert_float_equal(trk_angle_deg(filter.value, direction), speeds[i] * dt_s * (1 - alpha) / alpha,
                           0.02 * speeds[i] * dt_s * (1 - alpha) / alpha);
    }
}

/* White noise keeps alpha / (2 - alpha) of its variance, and somewhat more, because the noise also raises the
 * cut-off. */
static void quietens_noise(void **state)
{
    (void)state;
    struct trk_filter filter = {0};
    unsigned seed = 1;
    double in = 0, out = 0;
    enum { N = 20000 };
    float centre[3], direction[3];
    at(0, 0, centre);
    for (int k = 0; k < N; k++) {
        double noise[2];
        for (int i = 0; i < 2; i++) {
            double sum = 0; /* Irwin-Hall distribution, with variance 1 */
            for (int j = 0; j < 12; j++) sum += (double)((seed = seed * 1664525 + 1013904223) >> 8) * 0x1p-24;
            noise[i] = 0.3 * (sum - 6);
        }
        at(noise[0], noise[1], direction);
        trk_filter_step(&filter, direction, dt_s);
        if (k < 100) continue;
        in += pow(trk_angle_deg(centre, direction), 2);
        out += pow(trk_angle_deg(centre, filter.value), 2);
    }
    double alpha = share(2);
    print_message("noise of 0.3 degrees leaves as %.3f\n", 0.3 * sqrt(out / in));
    assert_true(out / in > 0.95 * alpha / (2 - alpha));
    assert_true(out / in < 1.35 * alpha / (2 - alpha));
}

/* The same path gives the same filtered path anywhere on the sphere, at a pole and across the seam too. */
static void is_the_same_everywhere(void **state)
{
    (void)state;
    static const float axes[][3] = {{1, 0, 0}, {0, 1, 0}, {0.6f, 0, 0.8f}};
    for (int turn = 0; turn < 12; turn++) {
        struct trk_filter here = {0}, there = {0};
        versor q;
        glm_quatv(q, (float)(turn * 0.55), (float *)axes[turn % 3]);
        for (int k = 0; k < 200; k++) {
            float direction[3];
            vec3 turned, expected;
            at(8 * sin(k * 0.11), 5 * sin(k * 0.07 + 1), direction);
            glm_quat_rotatev(q, direction, turned);
            trk_filter_step(&here, direction, dt_s);
            trk_filter_step(&there, turned, dt_s);
            glm_quat_rotatev(q, here.value, expected);
            assert_float_equal(trk_angle_deg(there.value, expected), 0, 1e-3);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(arcs_there_and_back),    cmocka_unit_test(begins_as_a_mean),
        cmocka_unit_test(lags_as_it_must),        cmocka_unit_test(quietens_noise),
        cmocka_unit_test(is_the_same_everywhere),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
