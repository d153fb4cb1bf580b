/* Materials with all of glTF's extensions: draws and densities, the white furnace, and Fresnel, Snell, Beer
 * and Lambert where closed forms are known. */
#include "path/media.h"
#include "renderer_bsdf.h"

#include <stdlib.h>

static const struct case_of_bsdf cases[] = {
    {.name = "plain", .roughness = 0.5f, .specular = 1},
    {.name = "coat", .roughness = 0.6f, .specular = 1, .coat = 1, .coat_roughness = 0.2f},
    {.name = "half a coat, tilted",
     .roughness = 0.4f,
     .metallic = 1,
     .specular = 1,
     .coat = 0.5f,
     .coat_roughness = 0.4f,
     .coat_tilt_deg = 12},
    {.name = "coat, tilted, over a bent metal",
     .roughness = 0.5f,
     .metallic = 1,
     .specular = 1,
     .coat = 0.5f,
     .coat_roughness = 0.4f,
     .coat_tilt_deg = 50,
     .bend_deg = 20},
    {.name = "glass, bent", .roughness = 0.4f, .specular = 1, .transmission = 1, .bend_deg = 20},
    {.name = "sheen", .roughness = 0.8f, .specular = 1, .sheen = 0.8f, .sheen_roughness = 0.4f},
    {.name = "thin glass", .roughness = 0.4f, .specular = 1, .transmission = 1, .thin = true},
    {.name = "glass", .roughness = 0.3f, .specular = 1, .transmission = 1},
    {.name = "glass, from inside", .roughness = 0.4f, .specular = 1, .transmission = 1, .back = true},
    {.name = "half glass", .roughness = 0.4f, .metallic = 0.2f, .specular = 0.7f, .transmission = 0.5f},
    {.name = "half smooth glass",
     .roughness = 0,
     .specular = 0,
     .transmission = 0.6f,
     .sheen = 0.5f,
     .sheen_roughness = 0.5f},
    {.name = "all",
     .roughness = 0.5f,
     .metallic = 0.3f,
     .specular = 1,
     .transmission = 0.5f,
     .thin = true,
     .coat = 0.7f,
     .coat_roughness = 0.3f,
     .sheen = 0.3f,
     .sheen_roughness = 0.6f},
};
enum { CASES = sizeof cases / sizeof *cases };

static struct case_of_bsdf rich(struct case_of_bsdf c)
{
    c.kind = RND_RICH;
    return c;
}

static void draws_follow_density(void **state)
{
    (void)state;
    static const double angles[] = {0, 35, 70};
    for (int k = 0; k < CASES; k++)
        for (int a = SANITIZED; a < 3; a += SANITIZED ? 3 : 1) { /* a sanitized build tests only the second */
            const struct case_of_bsdf c = rich(cases[k]);
            assert_true(assert_draws_follow_density(&c, angles[a], 14, 14, (uint32_t)(3 * k + a)) > 0.85);
        }
}

/* The light that leaves a white surface in a white world. Inside a volume of index n the radiance is n^2. */
static double furnace(const struct case_of_bsdf *c, double angle_deg)
{
    struct rnd_material material;
    struct rnd_surface s;
    make(c, 1.0f, &material, &s);
    const vec3s wo = direction(&s, cos(angle_deg * deg), 0.4);
    const double eta = !material.medium ? 1.0 : c->back ? 1 / material.ior : material.ior;
    const uint32_t side = SANITIZED ? 100 : 200;
    double sum = 0.0;
    for (uint32_t k = 0; k < side * side; k++) {
        const float u[3] = {(k / side + 0.5f) / side, (k % side + 0.5f) / side,
                            (float)(k * 0x9e3779b1u >> 8) * 0x1p-24f};
        struct rnd_scattered sample;
        if (!bsdf_sample(&s, wo, u, &sample)) continue;
        sum += sample.weight.x * (glms_vec3_dot(sample.wi, s.geometric) < 0 ? eta * eta : 1.0);
    }
    return sum / (side * side);
}

/* Every material returns all light, within the error of fits: at most `off` is lost, and at most half of that
 * is gained. */
static void white_furnace(void **state)
{
    (void)state;
    static const struct {
        struct case_of_bsdf c;
        double off;
    } kinds[] = {
        {{.name = "plain", .specular = 1}, 0.01},
        {{.name = "metal", .specular = 1, .metallic = 1}, 0.01},
        {{.name = "smooth coat", .specular = 1, .coat = 1}, 0.01},
        {{.name = "rough coat", .specular = 1, .coat = 1, .coat_roughness = 0.5f}, 0.01},
        {{.name = "coat over metal", .specular = 1, .metallic = 1, .coat = 1, .coat_roughness = 0.1f}, 0.01},
        {{.name = "sheen", .specular = 1, .sheen = 1, .sheen_roughness = 0.3f}, 0.01},
        {{.name = "rough sheen", .specular = 1, .sheen = 1, .sheen_roughness = 1}, 0.01},
        {{.name = "thin glass", .specular = 1, .transmission = 1, .thin = true}, 0.01},
        {{.name = "half thin glass", .specular = 1, .transmission = 0.5f, .thin = true}, 0.01},
        {{.name = "glass", .specular = 1, .transmission = 1}, 0.01},
        {{.name = "glass, from inside", .specular = 1, .transmission = 1, .back = true}, 0.01},
        {{.name = "metal, bent", .specular = 1, .metallic = 1, .bend_deg = 9}, 0.01},
        {{.name = "thin glass, bent", .specular = 1, .transmission = 1, .thin = true, .bend_deg = 9}, 0.01},
        {{.name = "glass, bent", .specular = 1, .transmission = 1, .bend_deg = 9}, 0.01},
        {{.name = "glass, bent, from inside", .specular = 1, .transmission = 1, .back = true, .bend_deg = 9},
         0.01},
        {{.name = "tilted coat over metal",
          .specular = 1,
          .metallic = 1,
          .coat = 1,
          .coat_roughness = 0.1f,
          .coat_tilt_deg = 9},
         0.01},
        {{.name = "water", .specular = 1, .transmission = 1, .ior = 1.33f}, 0.01},
        {{.name = "water, from inside", .specular = 1, .transmission = 1, .ior = 1.33f, .back = true}, 0.01},
    };
    static const float roughness[] = {0, 0.1f, 0.3f, 0.6f, 1};
    static const double angles[] = {0, 30, 60, 80};
    int wrong = 0;
    for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++)
        for (int r = 0; r < 5; r += SANITIZED ? 2 : 1) {
            struct case_of_bsdf c = rich(kinds[k].c);
            c.roughness = roughness[r];
            const double off = SANITIZED ? 2.0 * kinds[k].off : kinds[k].off;
            double out[4];
            for (int a = 0; a < 4; a++) {
                out[a] = furnace(&c, angles[a]);
                wrong += out[a] < 1 - off || out[a] > 1 + 0.5 * off;
            }
            print_message("white furnace: %-20s roughness %.1f: %.4f %.4f %.4f %.4f\n", c.name, roughness[r],
                          out[0], out[1], out[2], out[3]);
        }
    assert_int_equal(wrong, 0);
}

/* The table for all roughnesses, which textured roughness uses, agrees with the tables of single roughnesses.
 */
static void glass_of_any_roughness(void **state)
{
    (void)state;
    struct rnd_glass *any = rnd_glass_create(1.45f, 0, 1);
    double worst = 0;
    for (int r = 1; r <= 40; r++) {
        const float roughness = (float)r / 40, alpha = rnd_alpha(roughness);
        struct rnd_glass *one = rnd_glass_create(1.45f, roughness, roughness);
        assert_true(any && one);
        for (int k = 0; k < 2 * 50; k++) {
            const float cosine = ((float)(k / 2) + 0.5f) / 50;
            const double a = rnd_glass_albedo(any, cosine, alpha, k % 2),
                         b = rnd_glass_albedo(one, cosine, alpha, k % 2);
            worst = fmax(worst, fabs(a / b - 1));
        }
        free(one);
    }
    print_message("glass of any roughness: %.4f off at most\n", worst);
    assert_true(worst < 0.013); /* largest half a degree above the surface */
    free(any);
}

/* The BSDF of rough glass is the same in both directions, except for the square of the index and for the
 * albedo that restores the light lost between facets, which depends on the outgoing direction alone. */
static void glass_is_reciprocal(void **state)
{
    (void)state;
    struct case_of_bsdf there =
                            rich((struct case_of_bsdf){.roughness = 0.5f, .specular = 1, .transmission = 1}),
                        back = there;
    back.back = true;
    int seen = 0;
    for (uint32_t i = 0; i < 2000; i++) {
        struct rnd_material material;
        struct rnd_surface s, behind;
        struct rnd_scattered sample;
        float pdf;
        make(&there, 0.8f, &material, &s);
        make(&back, 0.8f, &material, &behind);
        behind.geometric = behind.shading = behind.layers.coat_normal = glms_vec3_negate(s.shading);
        const float ca = 0.05f + 0.95f * stat_uniform(7, i);
        const vec3s a = direction(&s, ca, 6.28 * stat_uniform(8, i));
        if (!draw(&s, a, 9, i, &sample) || glms_vec3_dot(sample.wi, s.shading) > 0) continue;
        const float cb = -glms_vec3_dot(sample.wi, s.shading);
        const double f = bsdf(&s, a, sample.wi, &pdf).x / cb *
                         rnd_glass_albedo(material.glass[0], ca, s.alpha, false),
                     g = bsdf(&behind, sample.wi, a, &pdf).x / ca *
                         rnd_glass_albedo(material.glass[0], cb, s.alpha, true);
        seen++;
        assert_float_equal(2.25 * f, g, 5e-3 * g + 1e-6);
    }
    assert_true(seen > 1000);
}

/* Smooth glass after Snell and Fresnel: known reflectances (at Brewster's angle only one polarisation is
 * reflected), directions, and total reflection from 41.8103 degrees on. */
static void smooth_glass(void **state)
{
    (void)state;
    static const struct {
        double angle, reflectance;
        bool back;
    } known[] = {{0, 0.04, false},
                 {0, 0.04, true},
                 {56.3099325, 0.0739645, false},
                 {33.6900675, 0.0739645, true},
                 {41.82, 1, true},
                 {45, 1, true},
                 {80, 0.3877, false}};
    for (size_t k = 0; k < sizeof known / sizeof *known; k++) {
        const struct case_of_bsdf glass =
            rich((struct case_of_bsdf){.specular = 1, .transmission = 1, .back = known[k].back});
        struct rnd_material material;
        struct rnd_surface s;
        float pdf;
        make(&glass, 1.0f, &material, &s);
        const vec3s wo = direction(&s, cos(known[k].angle * deg), 0.3);
        assert_true(bsdf(&s, wo, direction(&s, cos(known[k].angle * deg), 0.3 + M_PI), &pdf).x == 0.0f &&
                    pdf == 0.0f);
        const double eta = known[k].back ? 1 / 1.5 : 1.5;
        int reflected = 0;
        const int n = 20000;
        for (int i = 0; i < n; i++) {
            const float u[3] = {0.5f, 0.5f, (float)((i + 0.5) / n)};
            struct rnd_scattered sample;
            assert_true(bsdf_sample(&s, wo, u, &sample));
            assert_true(sample.delta);
            const double c = glms_vec3_dot(sample.wi, s.shading), sine = sqrt(fmax(0, 1 - c * c));
            reflected += c > 0;
            assert_float_equal(glms_vec3_norm(sample.wi), 1, 1e-5);
            assert_float_equal(sine, sin(known[k].angle * deg) / (c > 0 ? 1 : eta), 1e-3);
            assert_float_equal(sample.weight.x, c > 0 ? 1 : 1 / (eta * eta), 1e-5);
        }
        assert_float_equal((double)reflected / n, known[k].reflectance, 2e-4);
    }
    /* thin glass does not bend light */
    const struct case_of_bsdf thin =
        rich((struct case_of_bsdf){.specular = 1, .transmission = 1, .thin = true});
    struct rnd_material material;
    struct rnd_surface s;
    struct rnd_scattered sample;
    make(&thin, 0.5f, &material, &s);
    const vec3s wo = direction(&s, 0.6, 0.3);
    assert_true(bsdf_sample(&s, wo, (float[]){0.5f, 0.5f, 0.9f}, &sample));
    assert_true(sample.delta && glms_vec3_dot(sample.wi, wo) < -1 + 1e-6);
}

/* An absorbing slab of thickness d at normal incidence: (1 - R)^2 e^(-s d) / (1 - R^2 e^(-2 s d)) of the
 * light passes. */
static void absorbing_slab(void **state)
{
    (void)state;
    const struct case_of_bsdf glass = rich((struct case_of_bsdf){.specular = 1, .transmission = 1});
    const double sigma = 3, d = 0.2, r = 0.04, left = exp(-sigma * d);
    const double expected = (1 - r) * (1 - r) * left / (1 - r * r * left * left);
    struct rnd_medium media[] = {{.ior = 1}, {.ior = 1.5f, .absorption = {{(float)sigma, 0, 0}}}};
    const struct rnd_scene scene = {.medium_count = 1, .medium = media};
    double passed = 0.0;
    const uint32_t n = 200000;
    for (uint32_t i = 0; i < n; i++) {
        struct rnd_material material;
        struct rnd_surface s;
        struct rnd_scattered sample;
        make(&glass, 1, &material, &s);
        const vec3s out = s.geometric;
        vec3s wo = out;
        double weight = 1.0;
        for (uint32_t hit = 0;; hit++) {
            s.geometric = s.shading = wo;
            s.front = hit == 0;
            s.between = rnd_interface_in_air(&material, s.front);
            const struct rnd_v3 t = rnd_media_transmittance(&scene, hit > 0, (float)d);
            weight *= t.x;
            assert_true(t.y == 1.0f);
            assert_true(hit < 60 && draw(&s, wo, hit, i, &sample));
            weight *= sample.weight.x;
            const bool through = glms_vec3_dot(sample.wi, wo) < 0;
            if (through == (hit > 0)) { /* outside again */
                if (glms_vec3_dot(sample.wi, out) < 0) passed += weight / n;
                break;
            }
            wo = glms_vec3_negate(sample.wi);
        }
    }
    print_message("absorbing slab: %.4f of %.4f passes\n", passed, expected);
    assert_float_equal(passed, expected, 0.002);
}

static void unlit(void **state)
{
    (void)state;
    const struct case_of_bsdf plain = rich((struct case_of_bsdf){.specular = 1, .roughness = 1});
    struct rnd_material material;
    struct rnd_surface s;
    struct rnd_scattered sample;
    float pdf;
    make(&plain, 1, &material, &s);
    material.unlit = true;
    assert_false(draw(&s, direction(&s, 0.5, 0), 1, 1, &sample));
    assert_true(bsdf(&s, direction(&s, 0.5, 0), direction(&s, 0.5, 3), &pdf).x == 0 && pdf == 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(draws_follow_density),
        cmocka_unit_test(white_furnace),
        cmocka_unit_test(glass_of_any_roughness),
        cmocka_unit_test(glass_is_reciprocal),
        cmocka_unit_test(smooth_glass),
        cmocka_unit_test(absorbing_slab),
        cmocka_unit_test(unlit),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
