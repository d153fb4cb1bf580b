/* Sampling of materials without a render: draws follow the stated density, weights are BSDF over density,
 * BSDFs are reciprocal and create no light. Also alias tables. */
#include "renderer_bsdf.h"

static const struct case_of_bsdf cases[] = {
    {.name = "Lambert", .kind = RND_DIFFUSE, .metallic = 0, .roughness = 1, .specular = 0},
    {.name = "metal 0.2", .kind = RND_METAL_ROUGH, .metallic = 1, .roughness = 0.2f, .specular = 1},
    {.name = "metal 0.5", .kind = RND_METAL_ROUGH, .metallic = 1, .roughness = 0.5f, .specular = 1},
    {.name = "metal 1.0", .kind = RND_METAL_ROUGH, .metallic = 1, .roughness = 1, .specular = 1},
    {.name = "coat 0.3", .kind = RND_METAL_ROUGH, .metallic = 0, .roughness = 0.3f, .specular = 1},
    {.name = "coat 0.8", .kind = RND_METAL_ROUGH, .metallic = 0, .roughness = 0.8f, .specular = 1},
    {.name = "half 0.4", .kind = RND_METAL_ROUGH, .metallic = 0.5f, .roughness = 0.4f, .specular = 0.5f},
};
static const struct case_of_bsdf bent[] = {
    {.name = "metal, bent",
     .kind = RND_METAL_ROUGH,
     .metallic = 1,
     .roughness = 0.5f,
     .specular = 1,
     .bend_deg = 40},
    {.name = "coat, bent",
     .kind = RND_METAL_ROUGH,
     .metallic = 0,
     .roughness = 0.6f,
     .specular = 1,
     .bend_deg = 25},
};
enum { CASES = sizeof cases / sizeof *cases };

/* Degrees from the normal. A sanitized build tests only the second. */
static const double angles[] = {0, 30, 60, 85};
enum { ANGLES = sizeof angles / sizeof *angles, ANGLE = SANITIZED, ANGLE_STEP = SANITIZED ? ANGLES : 1 };

/* How many points per cell a quadrature takes along the azimuth: a grazing lobe is narrow in azimuth. */
static int azimuth_parts(double angle_deg)
{
    return angle_deg > 80 ? 192 : 32;
}

static void draws_follow_density(void **state)
{
    (void)state;
    for (int c = 0; c < CASES; c++)
        for (int a = ANGLE; a < ANGLES; a += ANGLE_STEP) {
            const double sum = assert_draws_follow_density(&cases[c], angles[a], 32, azimuth_parts(angles[a]),
                                                           (uint32_t)(c * ANGLES + a));
            if (cases[c].kind == RND_DIFFUSE || angles[a] == 0)
                assert_true(sum > (cases[c].roughness < 1 ? 0.9 : 0.45));
        }
}

/* When the shading normal differs from the triangle's, draws are above the triangle and follow the density,
 * and a white metal returns all light even if much of its lobe is below the triangle. */
static void bent_normals(void **state)
{
    (void)state;
    for (uint32_t k = 0; k < sizeof bent / sizeof *bent; k++)
        for (uint32_t a = 0; a < 2; a++)
            assert_draws_follow_density(&bent[k], 25.0 * a, 32, 32, 200 + 2 * k + a);
    for (int roughness = 0; roughness <= 10; roughness += SANITIZED ? 5 : 1)
        for (int bend = 0; bend <= 80; bend += 20) {
            const struct case_of_bsdf metal = {.name = "metal, bent",
                                               .kind = RND_METAL_ROUGH,
                                               .metallic = 1,
                                               .roughness = 0.1f * (float)roughness,
                                               .specular = 1,
                                               .bend_deg = (float)bend};
            const uint32_t n = 50000;
            struct rnd_material material;
            struct rnd_surface s;
            double mean = 0.0;
            make(&metal, 1.0f, &material, &s);
            for (uint32_t i = 0; i < n; i++) {
                struct rnd_scattered sample;
                if (!draw(&s, s.geometric, 91, i, &sample)) continue;
                assert_true(glms_vec3_dot(sample.wi, s.geometric) > 0.0f);
                mean += sample.weight.x / n;
            }
            print_message("metal of roughness %.1f, its normal bent by %d degrees: albedo %.4f\n",
                          metal.roughness, bend, mean);
            assert_float_equal(mean, 1.0, 0.012);
        }
}

/* The mean weight is the albedo by quadrature. A white metal returns all light, and so does Lambert. */
static void weights(void **state)
{
    (void)state;
    for (int c = 0; c < CASES; c++)
        for (int a = ANGLE; a < ANGLES; a += ANGLE_STEP) {
            struct rnd_material material;
            struct rnd_surface s;
            make(&cases[c], 1.0f, &material, &s);
            const vec3s wo = direction(&s, cos(angles[a] * deg), -2.0);
            double mean = 0.0, quadrature = 0.0;
            const uint32_t n = 50000;
            for (uint32_t i = 0; i < n; i++) {
                struct rnd_scattered sample;
                if (!draw(&s, wo, 90, i, &sample)) continue;
                assert_false(sample.delta);
                mean += sample.weight.x / n;
            }
            const int up = 400, around = 12 * azimuth_parts(angles[a]);
            for (int k = 0; k < up * around; k++) {
                const double theta = (k / around + 0.5) / up * M_PI / 2,
                             azimuth = (k % around + 0.5) / around * 2 * M_PI;
                float pdf;
                quadrature += bsdf(&s, wo, direction(&s, cos(theta), azimuth), &pdf).x * sin(theta);
            }
            quadrature *= M_PI * M_PI / ((double)up * around);
            print_message("%-9s %2.0f degrees: albedo %.4f by draws, %.4f by quadrature\n", cases[c].name,
                          angles[a], mean, quadrature);
            assert_true(fabs(mean - quadrature) < 0.01);
            assert_true(quadrature > 0.99 && quadrature < 1.005);
        }
}

/* All BSDFs but metals are reciprocal. Metals are not, because the light that they lose between facets is
 * given back according to the outgoing direction alone. */
static void reciprocity(void **state)
{
    (void)state;
    for (int c = 0; c < CASES; c++)
        for (uint32_t i = 0; i < 2000 && cases[c].metallic == 0; i++) {
            struct rnd_material material;
            struct rnd_surface s;
            make(&cases[c], 0.6f, &material, &s);
            const double ca = 0.05 + 0.95 * stat_uniform(7, 4 * i),
                         cb = 0.05 + 0.95 * stat_uniform(7, 4 * i + 1);
            const vec3s a = direction(&s, ca, 6.28 * stat_uniform(7, 4 * i + 2)),
                        b = direction(&s, cb, 6.28 * stat_uniform(7, 4 * i + 3));
            float pdf;
            const double there = bsdf(&s, a, b, &pdf).x / cb, back = bsdf(&s, b, a, &pdf).x / ca;
            assert_float_equal(there, back, 2e-3 * fmax(there, back) + 1e-6);
        }
}

/* No light passes through an opaque surface. */
static void below(void **state)
{
    (void)state;
    for (int c = 0; c < CASES; c++) {
        struct rnd_material material;
        struct rnd_surface s;
        float pdf;
        make(&cases[c], 1.0f, &material, &s);
        assert_true(bsdf(&s, direction(&s, 0.5, 0), direction(&s, -0.3, 1), &pdf).x == 0.0f && pdf == 0.0f);
    }
}

/* Draws from an alias table follow its weights, and none falls on a weight of 0. The second number tells
 * apart columns that the bits of the first cannot. */
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

    /* as many columns as an environment map of 8192 x 4096 has, all with the same weight */
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
        cmocka_unit_test(draws_follow_density), cmocka_unit_test(bent_normals), cmocka_unit_test(weights),
        cmocka_unit_test(reciprocity),          cmocka_unit_test(below),        cmocka_unit_test(tables),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
