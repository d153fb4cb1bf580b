/* What paths draw from, by itself: materials, whose draws follow the density stated and whose weights are
 * what BSDF and density say, reciprocal, with no light from nothing; and tables of weights. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdio.h>
#include <string.h>

#include "path/shade.h"
#include "statistics.h"

#define LEAST_P 0.001

static const double deg = M_PI / 180.0;

struct case_of_bsdf {
    const char *name;
    enum rnd_material_kind kind;
    float metallic, roughness, specular;
};

static const struct case_of_bsdf cases[] = {
    {"Lambert", RND_DIFFUSE, 0, 1, 0},
    {"metal 0.2", RND_METAL_ROUGH, 1, 0.2f, 1},
    {"metal 0.5", RND_METAL_ROUGH, 1, 0.5f, 1},
    {"metal 1.0", RND_METAL_ROUGH, 1, 1, 1},
    {"coat 0.3", RND_METAL_ROUGH, 0, 0.3f, 1},
    {"coat 0.8", RND_METAL_ROUGH, 0, 0.8f, 1},
    {"half 0.4", RND_METAL_ROUGH, 0.5f, 0.4f, 0.5f},
};
enum { CASES = sizeof cases / sizeof *cases };

static const double angles[] = {0, 30, 60, 85};
enum { ANGLES = sizeof angles / sizeof *angles };

/* A surface whose normal is oblique in the world, so that its frame is tried too; base 1 unless told. */
static void make(const struct case_of_bsdf *from, float base, struct rnd_material *material,
                 struct rnd_surface *out)
{
    const vec3s n = glms_vec3_normalize((vec3s){{0.3f, -0.5f, -0.8f}});
    *material = (struct rnd_material){.kind = from->kind, .specular = from->specular, .ior = 1.5f};
    *out = (struct rnd_surface){.material = material,
                                .geometric = n,
                                .shading = n,
                                .front = true,
                                .base = {{base, base, base}},
                                .metallic = from->metallic,
                                .alpha = fmaxf(from->roughness * from->roughness, 1e-3f)};
}

/* A direction by cosine to the surface's normal and azimuth around it. */
static vec3s direction(const struct rnd_surface *s, double cosine, double azimuth)
{
    vec3s x, y;
    rnd_frame(s->shading, &x, &y);
    const double sine = sqrt(fmax(0.0, 1.0 - cosine * cosine));
    vec3s d = glms_vec3_scale(s->shading, (float)cosine);
    d = glms_vec3_muladds(x, (float)(sine * cos(azimuth)), d);
    return glms_vec3_normalize(glms_vec3_muladds(y, (float)(sine * sin(azimuth)), d));
}

enum { ROWS = 24, COLUMNS = 24, CELLS = ROWS * COLUMNS, DRAWS = 200000 };

/* Rows are even in the angle from the normal, so that narrow lobes have some. */
static int cell_of(const struct rnd_surface *s, vec3s wi)
{
    vec3s x, y;
    rnd_frame(s->shading, &x, &y);
    const double theta = rnd_angle(wi, s->shading);
    const double azimuth = atan2(glms_vec3_dot(wi, y), glms_vec3_dot(wi, x)) + M_PI;
    const int row = (int)(theta / (M_PI / 2) * ROWS), column = (int)(azimuth / (2.0 * M_PI) * COLUMNS);
    return (row < ROWS ? row : ROWS - 1) * COLUMNS + column % COLUMNS;
}

/* Places a cell that a quadrature takes along the azimuth: a grazing lobe is narrow across. */
static int azimuth_parts(double angle_deg)
{
    return angle_deg > 80 ? 192 : 32;
}

/* Mass of the stated density in each cell, midpoint rule; their sum is returned. */
static double masses(const struct rnd_surface *s, vec3s wo, int around, double mass[CELLS])
{
    const int up = 32;
    const double step_t = M_PI / 2 / (ROWS * up), step_a = 2.0 * M_PI / (COLUMNS * around);
    double sum = 0.0;
    for (int cell = 0; cell < CELLS; cell++) {
        mass[cell] = 0.0;
        for (int k = 0; k < up * around; k++) {
            const double theta = (cell / COLUMNS * up + k / around + 0.5) * step_t,
                         azimuth = (cell % COLUMNS * around + k % around + 0.5) * step_a - M_PI;
            float pdf;
            rnd_bsdf(s, wo, direction(s, cos(theta), azimuth), &pdf);
            mass[cell] += pdf * sin(theta) * step_t * step_a;
        }
        sum += mass[cell];
    }
    return sum;
}

/* The density integrates to the share of draws that give a direction (a microfacet may send the rest below
 * the surface), and the draws follow it. */
static void draws_follow_density(void **state)
{
    (void)state;
    static double mass[CELLS], count[CELLS];
    for (int c = 0; c < CASES; c++)
        for (int a = 0; a < ANGLES; a++) {
            struct rnd_material material;
            struct rnd_surface s;
            make(&cases[c], 0.7f, &material, &s);
            const vec3s wo = direction(&s, cos(angles[a] * deg), 0.7);
            const double sum = masses(&s, wo, azimuth_parts(angles[a]), mass);
            int drawn = 0;
            memset(count, 0, sizeof count);
            for (uint32_t i = 0; i < DRAWS; i++) {
                const uint32_t stream = (uint32_t)(c * ANGLES + a);
                const float u[3] = {stat_uniform(stream, 3 * i), stat_uniform(stream, 3 * i + 1),
                                    stat_uniform(stream, 3 * i + 2)};
                struct rnd_bsdf_sample sample;
                if (!rnd_bsdf_draw(&s, wo, u, &sample)) continue;
                drawn++;
                count[cell_of(&s, sample.wi)]++;
            }
            for (int i = 0; i < CELLS; i++) mass[i] *= drawn / sum;
            const double p = stat_chi_square_p(count, mass, CELLS), share = (double)drawn / DRAWS;
            print_message("%-9s %2.0f degrees: density %.4f, drawn %.4f, p %.3f\n", cases[c].name, angles[a],
                          sum, share, p);
            assert_true(p > LEAST_P);
            assert_true(fabs(sum - share) < 0.004);
            if (cases[c].kind == RND_DIFFUSE || angles[a] == 0)
                assert_true(sum > (cases[c].roughness < 1 ? 0.9 : 0.45));
        }
}

/* A draw's weight is BSDF over density at its direction, and its mean is the albedo by quadrature. */
static void weights(void **state)
{
    (void)state;
    for (int c = 0; c < CASES; c++)
        for (int a = 0; a < ANGLES; a++) {
            struct rnd_material material;
            struct rnd_surface s;
            make(&cases[c], 1.0f, &material, &s);
            const vec3s wo = direction(&s, cos(angles[a] * deg), -2.0);
            double mean = 0.0, quadrature = 0.0;
            const uint32_t n = 50000;
            for (uint32_t i = 0; i < n; i++) {
                const float u[3] = {stat_uniform(90, 3 * i), stat_uniform(90, 3 * i + 1),
                                    stat_uniform(90, 3 * i + 2)};
                struct rnd_bsdf_sample sample;
                float pdf;
                if (!rnd_bsdf_draw(&s, wo, u, &sample)) continue;
                const vec3s f = rnd_bsdf(&s, wo, sample.wi, &pdf);
                assert_float_equal(pdf, sample.pdf, 1e-5 * pdf);
                assert_float_equal(f.x, sample.weight.x * sample.pdf, 1e-4 * f.x + 1e-6);
                assert_false(sample.delta);
                mean += sample.weight.x / n;
            }
            const int up = 400, around = 12 * azimuth_parts(angles[a]);
            for (int k = 0; k < up * around; k++) {
                const double theta = (k / around + 0.5) / up * M_PI / 2,
                             azimuth = (k % around + 0.5) / around * 2 * M_PI;
                float pdf;
                quadrature += rnd_bsdf(&s, wo, direction(&s, cos(theta), azimuth), &pdf).x * sin(theta);
            }
            quadrature *= M_PI * M_PI / ((double)up * around);
            print_message("%-9s %2.0f degrees: albedo %.4f by draws, %.4f by quadrature\n", cases[c].name,
                          angles[a], mean, quadrature);
            assert_true(fabs(mean - quadrature) < 0.01);
            if (cases[c].metallic == 1 || cases[c].kind == RND_DIFFUSE) assert_true(quadrature < 1.0 + 1e-3);
        }
}

static void reciprocity(void **state)
{
    (void)state;
    for (int c = 0; c < CASES; c++)
        for (uint32_t i = 0; i < 2000; i++) {
            struct rnd_material material;
            struct rnd_surface s;
            make(&cases[c], 0.6f, &material, &s);
            const double ca = 0.05 + 0.95 * stat_uniform(7, 4 * i),
                         cb = 0.05 + 0.95 * stat_uniform(7, 4 * i + 1);
            const vec3s a = direction(&s, ca, 6.28 * stat_uniform(7, 4 * i + 2)),
                        b = direction(&s, cb, 6.28 * stat_uniform(7, 4 * i + 3));
            float pdf;
            const double there = rnd_bsdf(&s, a, b, &pdf).x / cb, back = rnd_bsdf(&s, b, a, &pdf).x / ca;
            assert_float_equal(there, back, 2e-3 * fmax(there, back) + 1e-6);
        }
}

/* Nothing passes through an opaque surface, and nothing is found of a smooth one by evaluation. */
static void below_and_delta(void **state)
{
    (void)state;
    struct rnd_material material;
    struct rnd_surface s;
    float pdf;
    for (int c = 0; c < CASES; c++) {
        make(&cases[c], 1.0f, &material, &s);
        assert_true(rnd_bsdf(&s, direction(&s, 0.5, 0), direction(&s, -0.3, 1), &pdf).x == 0.0f &&
                    pdf == 0.0f);
    }
    const struct case_of_bsdf glass = {"glass", RND_RICH, 0, 0, 1};
    make(&glass, 1.0f, &material, &s);
    assert_true(rnd_bsdf(&s, direction(&s, 0.5, 0), direction(&s, 0.5, 3), &pdf).x == 0.0f && pdf == 0.0f);
}

/* Snell and Fresnel at a smooth dielectric: known reflectances, directions, and total reflection. */
static void dielectric(void **state)
{
    (void)state;
    const struct case_of_bsdf glass = {"glass", RND_RICH, 0, 0, 1};
    static const struct {
        double angle, reflectance;
        bool front;
    } known[] = {
        {0, 0.04, true}, {0, 0.04, false}, {56.3099325, 0.0739645, true}, {45, 1, false}, {80, 0.3877, true}};
    for (size_t k = 0; k < sizeof known / sizeof *known; k++) {
        struct rnd_material material;
        struct rnd_surface s;
        make(&glass, 1.0f, &material, &s);
        s.front = known[k].front;
        const vec3s wo = direction(&s, cos(known[k].angle * deg), 0.3);
        const double eta = s.front ? 1.5 : 1 / 1.5;
        int reflected = 0;
        const int n = 20000;
        for (int i = 0; i < n; i++) {
            const float u[3] = {0.5f, 0.5f, (float)((i + 0.5) / n)};
            struct rnd_bsdf_sample sample;
            assert_true(rnd_bsdf_draw(&s, wo, u, &sample));
            assert_true(sample.delta);
            const double c = glms_vec3_dot(sample.wi, s.shading), sine = sqrt(fmax(0, 1 - c * c));
            reflected += c > 0;
            assert_float_equal(glms_vec3_norm(sample.wi), 1, 1e-5);
            assert_float_equal(sine, sin(known[k].angle * deg) / (c > 0 ? 1 : eta), 1e-3);
            assert_float_equal(sample.weight.x, c > 0 ? 1 : 1 / (eta * eta), 1e-5);
        }
        assert_float_equal((double)reflected / n, known[k].reflectance, 2e-4);
    }
}

/* Draws from a table follow its weights, none falls on a weight of zero, and the second number alone tells
 * the columns apart that the first has no bits for. */
static void tables(void **state)
{
    (void)state;
    enum { COUNT = 300, DRAWN = 300000 };
    float weight[COUNT];
    double count[COUNT] = {0}, expected[COUNT];
    struct rnd_alias alias;
    double sum = 0.0;
    for (uint32_t i = 0; i < COUNT; i++)
        sum += weight[i] = i % 7 == 3 ? 0 : (float)pow(stat_uniform(3, i), 4);
    assert_true(rnd_alias_init(&alias, weight, COUNT));
    assert_float_equal(alias.sum, sum, 1e-9);
    for (uint32_t i = 0; i < DRAWN; i++)
        count[rnd_alias_draw(&alias, stat_uniform(4, 2 * i), stat_uniform(4, 2 * i + 1))]++;
    for (int i = 0; i < COUNT; i++) {
        assert_float_equal(alias.probability[i], weight[i] / sum, 1e-7);
        if (weight[i] == 0.0f) assert_true(count[i] == 0.0);
        expected[i] = DRAWN * weight[i] / sum;
    }
    const double p = stat_chi_square_p(count, expected, COUNT);
    print_message("alias table: p %.3f\n", p);
    assert_true(p > LEAST_P);
    rnd_alias_finish(&alias);

    const float one = 1.0f;
    assert_true(rnd_alias_init(&alias, &one, 1));
    assert_int_equal(rnd_alias_draw(&alias, 0x1.fffffep-1f, 0x1.fffffep-1f), 0);
    rnd_alias_finish(&alias);

    /* as many columns as an environment map of 8192 x 4096 has, all alike */
    const uint32_t large = 1u << 25;
    alias = (struct rnd_alias){.count = large, .entry = malloc(large * sizeof *alias.entry)};
    assert_non_null(alias.entry);
    for (uint32_t i = 0; i < large; i++) alias.entry[i].keep = 1.0f;
    assert_int_equal(rnd_alias_draw(&alias, 0x1p-24f, 0.0f), 2);
    assert_int_equal(rnd_alias_draw(&alias, 0x1p-24f, 0.5f), 3);
    assert_int_equal(rnd_alias_draw(&alias, 0x1.fffffep-1f, 0x1.fffffep-1f), large - 1);
    rnd_alias_finish(&alias);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(draws_follow_density), cmocka_unit_test(weights),
        cmocka_unit_test(reciprocity),          cmocka_unit_test(tables),
        cmocka_unit_test(below_and_delta),      cmocka_unit_test(dielectric),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
