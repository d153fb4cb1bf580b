/* Where samples fall: the acuity model and its inversions, and every distribution against its stated density.
 * Random numbers are the test's own, from fixed seeds, and not the renderer's. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../sanitized.h"
#include "renderer.h"
#include "statistics.h"

#define LEAST_P 0.001

static const double deg = M_PI / 180.0;

/* --- the acuity model, checked by quadrature of rnd_acuity() itself, not by closed forms --- */

/* Integral of 2 pi e m(e) from a to b degrees, by the midpoint rule. */
static double acuity_mass(double a, double b)
{
    const int steps = 2000;
    double sum = 0.0;
    for (int i = 0; i < steps; i++) {
        const double e = a + (b - a) * (i + 0.5) / steps;
        sum += 2.0 * M_PI * e * rnd_acuity((float)e);
    }
    return sum * (b - a) / steps;
}

static double acuity_total(void)
{
    double total = 0.0;
    for (int i = 0; i < 80; i++) total += acuity_mass(i, i + 1);
    return total;
}

/* The eccentricity at which the integral reaches the share u of its total: bisection over the quadrature. */
static double eccentricity_by_quadrature(double u, const double cumulative[81])
{
    const double h = u * cumulative[80];
    int i = 0;
    while (i < 79 && cumulative[i + 1] < h) i++;
    double low = i, high = i + 1;
    for (int k = 0; k < 40; k++) {
        const double middle = 0.5 * (low + high);
        *(cumulative[i] + acuity_mass(i, middle) < h ? &low : &high) = middle;
    }
    return low;
}

static void acuity(void **state)
{
    (void)state;
    assert_float_equal(rnd_acuity(0), 1, 0);
    assert_float_equal(rnd_acuity(5.79f), 1, 0);
    assert_float_equal(rnd_acuity(5.7901f), 1, 2e-3);
    assert_float_equal(rnd_acuity(30), 0.0749, 1e-6);
    assert_float_equal(acuity_total(), 1091.85, 0.3);
}

static void exact_inverse(void **state)
{
    (void)state;
    enum { BINS = 80, DRAWS = SANITIZED ? 100000 : 1000000 };
    static double count[BINS], expected[BINS];
    const double total = acuity_total();
    for (int i = 0; i < BINS; i++) expected[i] = DRAWS * acuity_mass(i, i + 1) / total;
    for (uint32_t i = 0; i < DRAWS; i++) {
        const float e = rnd_eccentricity_exact(stat_uniform(1, i));
        assert_true(e >= 0.0f && e < 80.0001f);
        count[(int)fminf(e, 79.9f)]++;
    }
    const double p = stat_chi_square_p(count, expected, BINS);
    print_message("exact inverse against g(e): p %.3f\n", p);
    assert_true(p > LEAST_P);

    double cumulative[81] = {0}, worst = 0.0;
    for (int i = 0; i < 80; i++) cumulative[i + 1] = cumulative[i] + acuity_mass(i, i + 1);
    for (double u = 0.0005; u < 1.0; u += 0.0037) {
        const double e = eccentricity_by_quadrature((float)u, cumulative);
        worst = fmax(worst, fabs(rnd_eccentricity_exact((float)u) - e) / e);
    }
    print_message("exact inverse against bisection: relative %.1e\n", worst);
    assert_true(worst < 2e-6);
    assert_float_equal(rnd_eccentricity_exact(0), 0, 0);
}

/* The polynomial of Koskela 2018, eq. 7, differs from the exact inverse by at most 0.030 degrees, at the
 * outer end, and by at most 0.23 %. */
static void polynomial_fit(void **state)
{
    (void)state;
    double degrees = 0.0, relative = 0.0;
    for (int i = 1; i <= 100000; i++) {
        const float u = (float)i / 100001.0f;
        const double exact = rnd_eccentricity_exact(u), d = fabs(rnd_eccentricity_polynomial(u) - exact);
        degrees = fmax(degrees, d);
        relative = fmax(relative, d / exact);
    }
    const double gap =
        rnd_eccentricity_polynomial(nextafterf(0.0965f, 1.0f)) - rnd_eccentricity_polynomial(0.0965f);
    print_message("polynomial against exact: %.4f degrees, %.3f %%; gap between its branches %.5f degrees\n",
                  degrees, 100.0 * relative, gap);
    assert_true(degrees < 0.0301);
    assert_true(relative < 0.0023);
    assert_true(gap > 0.004 && gap < 0.005); /* no draw falls into the gap */
}

/* The stated density of a distribution e degrees from its gaze, per degree of eccentricity. */
static double per_degree_spread(const struct rnd_distribution *distribution, double e_deg, float times)
{
    const struct rnd_aim aim = {.gaze = {0, 0, -1}, .view = {0, 0, 0, 1}, .fov = {1, 1}, .spread = times};
    const float direction[3] = {(float)sin(e_deg * deg), 0, (float)-cos(e_deg * deg)};
    return distribution->density(&aim, direction) * 2.0 * M_PI * sin(e_deg * deg) * deg;
}

static double per_degree(const struct rnd_distribution *distribution, double e_deg)
{
    return per_degree_spread(distribution, e_deg, 0);
}

/* Divided by 2 pi e / h(80), the density that the polynomial implies is itself an acuity. Koskela 2018 states
 * that it differs from eq. 1 by 1.8 % at most. From 6.2 degrees on that is true of both relative and absolute
 * differences; just outside the fovea, where the quartic's slope makes up for the gap between the branches,
 * it is 2.5 %. The integral of the difference is below 0.04 %, as the paper states. */
static void polynomial_acuity(void **state)
{
    (void)state;
    const struct rnd_distribution *fv = rnd_distribution_find("fv");
    const double total = acuity_total(), inner = rnd_eccentricity_polynomial(0.0965f),
                 outer = rnd_eccentricity_polynomial(nextafterf(0.0965f, 1.0f)),
                 end = rnd_eccentricity_polynomial(0x1.fffffep-1f), step = 0.001;
    double relative[3] = {0}, difference = 0.0, sum = 0.0; /* in the fovea, up to 6.2 degrees, beyond */
    for (double e = 0.05; e < end; e += step) {
        const double m = rnd_acuity((float)e), fit = per_degree(fv, e) * total / (2.0 * M_PI * e);
        difference += (fit - m) * step;
        sum += m * step;
        if (e > inner - 2e-4 && e < outer + 2e-4) continue;
        const int zone = e < 5.7905 ? 0 : e < 6.2 ? 1 : 2;
        relative[zone] = fmax(relative[zone], fabs(fit / m - 1.0));
    }
    print_message(
        "polynomial's acuity against m(e): %.3f %% in the fovea, %.3f %% at its edge, %.3f %% beyond; "
        "integral of the difference %.4f %%; ends at %.4f degrees\n",
        100 * relative[0], 100 * relative[1], 100 * relative[2], 100 * difference / sum, end);
    assert_true(relative[0] < 0.001);
    assert_true(relative[1] > 0.018 && relative[1] < 0.0251);
    assert_true(relative[2] < 0.018);
    assert_true(fabs(difference / sum) < 0.0004);
    assert_true(end > 79.96 && end < 79.98);
}

/* What the polynomial draws follows the density that "fv" states. */
static void polynomial_draws(void **state)
{
    (void)state;
    enum { BINS = 160, DRAWS = SANITIZED ? 100000 : 1000000, STEPS = 400 };
    static double count[BINS], expected[BINS];
    const struct rnd_distribution *fv = rnd_distribution_find("fv");
    for (int i = 0; i < BINS * STEPS; i++)
        expected[i / STEPS] += DRAWS * per_degree(fv, 0.5 * (i + 0.5) / STEPS) * 0.5 / STEPS;
    for (uint32_t i = 0; i < DRAWS; i++)
        count[(int)(2.0f * rnd_eccentricity_polynomial(stat_uniform(2, i)))]++;
    const double p = stat_chi_square_p(count, expected, BINS);
    print_message("polynomial against the density stated: p %.3f\n", p);
    assert_true(p > LEAST_P);
}

/* A display caps the acuity: the density is flat as far as the eye resolves more than the display shows (to
 * 25.5 degrees at 12 pixels per degree: 7.49 / (0.3 e + 1)^2 = 6 / 60), and follows the acuity beyond. A
 * display that is finer than the eye changes nothing. */
static void capped_by_display(void **state)
{
    (void)state;
    const struct rnd_distribution *d = rnd_distribution_find("fv-exact");
    struct rnd_aim aim = {.gaze = {0, 0, -1}, .pixels_per_degree = 12};
    float direction[3], density[4], outer[2];
    static const float place_deg[4] = {1, 10, 25, 50};
    for (int i = 0; i < 4; i++) {
        rnd_direction(place_deg[i] * (float)M_PI / 180, 0, direction);
        density[i] = d->density(&aim, direction) * sinf(place_deg[i] * (float)M_PI / 180) / place_deg[i];
    }
    /* density per degree of eccentricity, divided by e: proportional to min(m, cap) */
    assert_float_equal(density[1] / density[0], 1, 1e-4);
    assert_float_equal(density[2] / density[0], 1, 1e-4);
    assert_float_equal(density[3] / density[0], rnd_acuity(50) / 0.1, 1e-4);
    rnd_direction(50 * (float)M_PI / 180, 0, direction);
    aim.pixels_per_degree = 120;
    outer[0] = d->density(&aim, direction);
    aim.pixels_per_degree = 0;
    outer[1] = d->density(&aim, direction);
    assert_float_equal(outer[0] / outer[1], 1, 1e-6);
}

/* With a spread of s the density is that of acuity m(e / s) over the same 80 degrees, and draws follow it in
 * fine bins. A spread of 1 or less changes no bit of the draws. */
static void wider(void **state)
{
    (void)state;
    enum { BINS = 160, DRAWS = 200000, STEPS = 400 };
    static const char *const names[] = {"fv", "fv-exact"};
    static const float times[] = {1, 2, 4};
    static float u[2 * DRAWS], place[3 * DRAWS], usual[3 * DRAWS];
    for (uint32_t i = 0; i < 2 * DRAWS; i++) u[i] = stat_uniform(3, i);
    for (int k = 0; k < 6; k++) {
        const struct rnd_distribution *d = rnd_distribution_find(names[k % 2]);
        const float s = times[k / 2];
        struct rnd_aim aim = {.gaze = {0, 0, -1}, .view = {0, 0, 0, 1}, .fov = {1, 1}};
        static double count[BINS], expected[BINS];
        double sum = 0.0, total = 0.0, worst = 0.0, outer = 0.0;
        memset(count, 0, sizeof count);
        memset(expected, 0, sizeof expected);
        for (int i = 0; i < 80; i++) total += acuity_mass(i / s, (i + 1) / s) * s * s;
        for (int i = 0; i < BINS * STEPS; i++) {
            const double e = 80.0 * (i + 0.5) / (BINS * STEPS), p = per_degree_spread(d, e, s),
                         m = 2.0 * M_PI * e * rnd_acuity((float)(e / s)) / total;
            expected[i / STEPS] += DRAWS * p * 80.0 / (BINS * STEPS);
            sum += p * 80.0 / (BINS * STEPS);
            if (e < 79.8 && fabs(e / s - 5.79) > 0.02) worst = fmax(worst, fabs(p / m - 1.0));
        }
        d->sample(&aim, DRAWS, u, usual);
        aim.spread = s;
        d->sample(&aim, DRAWS, u, place);
        if (s == 1) assert_memory_equal(place, usual, sizeof place);
        for (int i = 0; i < DRAWS; i++) {
            const double e = acos(fmin(1, -place[3 * i + 2])) / deg;
            outer = fmax(outer, e);
            count[(int)fmin(BINS - 1, e * BINS / 80.0)]++;
        }
        const double p = stat_chi_square_p(count, expected, BINS);
        print_message("%s, spread %.0f: p %.3f, integral %.5f, from m(e / s) %.3f %%, to %.3f degrees\n",
                      names[k % 2], s, p, sum, 100 * worst, outer);
        assert_true(p > LEAST_P);
        assert_true(fabs(sum - 1.0) < 1e-3);
        assert_true(worst < (k % 2 ? 1e-4 : 0.027));
        assert_true(outer > 79 && outer < 80.001);
    }
}

/* --- on the sphere --- */

struct named_aim {
    const char *name;
    struct rnd_aim aim;
};

/* An aim whose view is turned by yaw (to the left), pitch (up) and roll, in degrees. The gaze is independent
 * of the view, in the world frame. */
static struct rnd_aim aim_of(double yaw, double pitch, double roll, double fov_x, double fov_y,
                             const double gaze[3])
{
    const double a = 0.5 * yaw * deg, b = 0.5 * pitch * deg, c = 0.5 * roll * deg,
                 l = sqrt(gaze[0] * gaze[0] + gaze[1] * gaze[1] + gaze[2] * gaze[2]);
    /* product of the quaternions (0, sin a, 0, cos a), (sin b, 0, 0, cos b), (0, 0, sin c, cos c) */
    const double x = cos(a) * sin(b), y = sin(a) * cos(b), z = -sin(a) * sin(b), w = cos(a) * cos(b);
    return (struct rnd_aim){.gaze = {(float)(gaze[0] / l), (float)(gaze[1] / l), (float)(gaze[2] / l)},
                            .view = {(float)(x * cos(c) + y * sin(c)), (float)(y * cos(c) - x * sin(c)),
                                     (float)(z * cos(c) + w * sin(c)), (float)(w * cos(c) - z * sin(c))},
                            .fov = {(float)(fov_x * deg), (float)(fov_y * deg)}};
}

enum { AIMS = 13, AIM_STEP = SANITIZED ? 4 : 1 };

/* The same aim with a fovea `times` as wide. */
static struct rnd_aim spread(struct rnd_aim aim, float times)
{
    aim.spread = times;
    return aim;
}

/* The same aim for a display of this many pixels per degree. */
static struct rnd_aim shown(struct rnd_aim aim, float pixels_per_degree)
{
    aim.pixels_per_degree = pixels_per_degree;
    return aim;
}

static void make_aims(struct named_aim aims[AIMS])
{
    const struct named_aim made[AIMS] = {
        {"forward", aim_of(0, 0, 0, 90, 90, (double[]){0, 0, -1})},
        {"up", aim_of(0, 90, 0, 100, 80, (double[]){0, 1, 0})},
        {"down", aim_of(0, -90, 30, 60, 110, (double[]){0, -1, 0})},
        {"seam", aim_of(180, 0, 0, 110, 90, (double[]){0, 0, 1})},
        {"oblique", aim_of(-70, 35, 25, 100, 60, (double[]){0.9, 0.5, -0.2})},
        {"narrow", aim_of(155, 66, -50, 16, 7, (double[]){-0.1, 0.9, 0.2})},
        {"wide", aim_of(-170, -20, 10, 165, 140, (double[]){0.2, -0.4, 0.8})},
        {"spread 1", spread(aim_of(20, 10, 0, 90, 90, (double[]){0.4, 0.2, -0.9}), 1)},
        {"spread 2", spread(aim_of(20, 10, 0, 90, 90, (double[]){0.4, 0.2, -0.9}), 2)},
        {"spread 4", spread(aim_of(-40, 0, 0, 90, 90, (double[]){-0.9, 0.1, -0.3}), 4)},
        {"display of 12 per degree", shown(aim_of(20, 10, 0, 90, 90, (double[]){0.4, 0.2, -0.9}), 12)},
        {"display of 40, spread 2",
         shown(spread(aim_of(0, 80, 0, 90, 90, (double[]){0.1, 0.9, -0.1}), 2), 40)},
        {"display finer than the eye", shown(aim_of(0, 0, 0, 90, 90, (double[]){0, 0, -1}), 200)},
    };
    memcpy(aims, made, sizeof made);
}

enum { ROWS = 18, COLUMNS = 36, CELLS = ROWS * COLUMNS, DRAWN = 200000 };

/* Integrate the stated density over a cell of the equirectangular image, by the midpoint rule with parts x
 * parts points. *out_zero is at how many of these points the density is 0. */
static double cell_mass(const struct rnd_distribution *distribution, const struct rnd_aim *aim, int cell,
                        int parts, int *out_zero)
{
    double sum = 0.0;
    *out_zero = 0;
    for (int k = 0; k < parts * parts; k++) {
        const double u = (cell % COLUMNS + (k % parts + 0.5) / parts) / COLUMNS,
                     v = (cell / COLUMNS + (k / parts + 0.5) / parts) / ROWS;
        const double around = 2.0 * M_PI * (u - 0.5), elevation = M_PI * (0.5 - v), c = cos(elevation);
        const float d[3] = {(float)(c * sin(around)), (float)sin(elevation), (float)(-c * cos(around))};
        const double density = distribution->density(aim, d);
        *out_zero += density == 0.0;
        sum += density * c;
    }
    return sum * 2.0 * M_PI * M_PI / ((double)CELLS * parts * parts);
}

/* Integrate over all cells, with more points where the edge of the distribution is. Returns the sum. */
static double cell_masses(const struct rnd_distribution *distribution, const struct rnd_aim *aim,
                          double mass[CELLS])
{
    const int parts = 32;
    double sum = 0.0;
    for (int cell = 0; cell < CELLS; cell++) {
        int zero;
        mass[cell] = cell_mass(distribution, aim, cell, parts, &zero);
        if (zero > 0 && zero < parts * parts)
            mass[cell] = cell_mass(distribution, aim, cell, 4 * parts, &zero);
        sum += mass[cell];
    }
    return sum;
}

static int cell_of(const float d[3])
{
    const double u = 0.5 + atan2(d[0], -d[2]) / (2.0 * M_PI), v = 0.5 - asin(fmax(-1, fmin(1, d[1]))) / M_PI;
    const int x = (int)(u * COLUMNS) % COLUMNS, y = (int)(v * ROWS);
    return (y < ROWS ? y : ROWS - 1) * COLUMNS + x;
}

static void assert_unit(const float d[3])
{
    assert_true(fabs(d[0] * d[0] + d[1] * d[1] + d[2] * d[2] - 1.0) < 2e-6);
}

/* The draws of a distribution fall into the cells of the image as its stated density says, the density
 * integrates to one, and every draw is a unit vector at which the density is not 0. */
static void assert_follows(const struct rnd_distribution *distribution, const struct named_aim *at,
                           uint32_t stream)
{
    static double mass[CELLS], count[CELLS];
    static float u[2 * DRAWN], place[3 * DRAWN];
    const double sum = cell_masses(distribution, &at->aim, mass);
    for (uint32_t i = 0; i < 2 * DRAWN; i++) u[i] = stat_uniform(stream, i);
    distribution->sample(&at->aim, DRAWN, u, place);
    memset(count, 0, sizeof count);
    int outside = 0;
    for (uint32_t i = 0; i < DRAWN; i++) {
        assert_unit(place + 3 * i);
        outside += distribution->density(&at->aim, place + 3 * i) == 0.0f;
        count[cell_of(place + 3 * i)]++;
    }
    assert_true(outside < DRAWN / 100000); /* only draws that rounding moved across the edge */
    for (int i = 0; i < CELLS; i++) mass[i] *= DRAWN / sum;
    const double p = stat_chi_square_p(count, mass, CELLS);
    print_message("%-8s %-8s: p %.3f, integral %.5f\n", distribution->name, at->name, p, sum);
    assert_true(p > LEAST_P);
    assert_true(fabs(sum - 1.0) < 1e-3);
}

static void sphere(void **state)
{
    (void)state;
    struct named_aim aims[AIMS];
    uint32_t stream = 100;
    make_aims(aims);
    for (size_t k = 0; rnd_distribution_at(k); k++, stream += AIMS)
        for (int i = 0; i < AIMS; i += AIM_STEP)
            assert_follows(rnd_distribution_at(k), &aims[i], stream + (uint32_t)i);
}

/* The corners of the unit square also give unit vectors. */
static void corners(void **state)
{
    (void)state;
    static const float u[8] = {0, 0, 0x1.fffffep-1f, 0, 0, 0x1.fffffep-1f, 0x1.fffffep-1f, 0x1.fffffep-1f};
    struct named_aim aims[AIMS];
    make_aims(aims);
    for (size_t k = 0; rnd_distribution_at(k); k++)
        for (int i = 0; i < AIMS; i++) {
            float place[12];
            rnd_distribution_at(k)->sample(&aims[i].aim, 4, u, place);
            for (int c = 0; c < 4; c++) assert_unit(place + 3 * c);
        }
}

/* The foveated distributions are uniform in the azimuth around the gaze, whatever the gaze. */
static void azimuth(void **state)
{
    (void)state;
    static const char *const names[] = {"fv", "fv-exact"};
    enum { BINS = 72 };
    static float u[2 * DRAWN], place[3 * DRAWN];
    struct named_aim aims[AIMS];
    make_aims(aims);
    for (int k = 0; k < 2; k++)
        for (int i = 0; i < AIMS; i += AIM_STEP) {
            const float *g = aims[i].aim.gaze;
            double count[BINS] = {0}, expected[BINS];
            /* two axes perpendicular to the gaze, made from a world axis that is far from it */
            const int far = fabsf(g[0]) < 0.6f ? 0 : 1;
            double x[3], y[3], l = 0.0;
            for (int c = 0; c < 3; c++) x[c] = (c == far) - g[far] * g[c];
            for (int c = 0; c < 3; c++) l += x[c] * x[c];
            for (int c = 0; c < 3; c++) x[c] /= sqrt(l);
            for (int c = 0; c < 3; c++)
                y[c] = g[(c + 1) % 3] * x[(c + 2) % 3] - g[(c + 2) % 3] * x[(c + 1) % 3];
            for (uint32_t j = 0; j < 2 * DRAWN; j++) u[j] = stat_uniform(50 + (uint32_t)i, j);
            rnd_distribution_find(names[k])->sample(&aims[i].aim, DRAWN, u, place);
            for (int j = 0; j < DRAWN; j++) {
                const float *d = place + 3 * j;
                const double across = d[0] * x[0] + d[1] * x[1] + d[2] * x[2],
                             along = d[0] * y[0] + d[1] * y[1] + d[2] * y[2];
                count[(int)((atan2(along, across) / (2.0 * M_PI) + 0.5) * BINS) % BINS]++;
            }
            for (int j = 0; j < BINS; j++) expected[j] = (double)DRAWN / BINS;
            const double p = stat_chi_square_p(count, expected, BINS);
            print_message("azimuth of %s, %s: p %.3f\n", names[k], aims[i].name, p);
            assert_true(p > LEAST_P);
        }
}

static void table(void **state)
{
    (void)state;
    static const char *const names[] = {"od", "vp", "fv", "fv-exact"};
    size_t count = 0;
    while (rnd_distribution_at(count)) {
        assert_ptr_equal(rnd_distribution_find(rnd_distribution_at(count)->name), rnd_distribution_at(count));
        count++;
    }
    assert_int_equal(count, 4);
    for (int i = 0; i < 4; i++) assert_string_equal(rnd_distribution_find(names[i])->name, names[i]);
    assert_null(rnd_distribution_find("fov"));
    assert_null(rnd_distribution_find(""));
}

/* The flags of a distribution's row agree with its density. */
static void rows_say_what_they_do(void **state)
{
    (void)state;
    const struct rnd_distribution *d;
    for (size_t k = 0; (d = rnd_distribution_at(k)) != NULL; k++) {
        const struct rnd_aim aim = {.gaze = {0, 0, -1}, .view = {0, 0, 0, 1}, .fov = {1.5f, 1.5f}};
        struct rnd_aim turned = aim, wide = aim;
        turned.view[1] = turned.view[3] = 0.70710678f;
        wide.spread = 3;
        bool zero = false, by_view = false, by_spread = false;
        for (int y = 0; y < 32; y++)
            for (int x = 0; x < 64; x++) {
                float direction[3];
                rnd_direction(((float)x + 0.5f) / 32 * (float)M_PI,
                              (((float)y + 0.5f) / 32 - 0.5f) * (float)M_PI, direction);
                const float density = d->density(&aim, direction);
                zero |= density == 0.0f;
                by_view |= d->density(&turned, direction) != density;
                by_spread |= d->density(&wide, direction) != density;
            }
        assert_int_equal(d->covers_sphere, !zero);
        assert_int_equal(d->has_viewport, by_view);
        assert_int_equal(d->is_foveated, by_spread);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rows_say_what_they_do),
        cmocka_unit_test(acuity),
        cmocka_unit_test(exact_inverse),
        cmocka_unit_test(polynomial_fit),
        cmocka_unit_test(polynomial_acuity),
        cmocka_unit_test(polynomial_draws),
        cmocka_unit_test(wider),
        cmocka_unit_test(capped_by_display),
        cmocka_unit_test(sphere),
        cmocka_unit_test(corners),
        cmocka_unit_test(azimuth),
        cmocka_unit_test(table),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
