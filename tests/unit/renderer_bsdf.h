/* Surfaces of every kind for the tests of BSDFs, and a check that draws follow their density. */
#ifndef FOVEAD_TESTS_RENDERER_BSDF_H
#define FOVEAD_TESTS_RENDERER_BSDF_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdio.h>
#include <string.h>

#include "material/ggx.h"
#include "material/glass.h"
#include "material/closure.h"
#include "../sanitized.h"
#include "statistics.h"

#define LEAST_P 0.001

static const double deg = M_PI / 180.0;

struct case_of_bsdf {
    const char *name;
    enum rnd_material_kind kind;
    float metallic, roughness, specular;
    float transmission, ior; /* 0: 1.5 */
    bool thin, back;         /* hit from the back */
    float coat, coat_roughness, coat_tilt_deg;
    float sheen, sheen_roughness;
    float bend_deg; /* angle from the triangle's normal to the shading normal */
};

/* Make out_x and out_y form an orthonormal right-handed frame with n (unit; Duff et al. 2017). */
static inline void frame_of(vec3s n, vec3s *out_x, vec3s *out_y)
{
    const float sign = copysignf(1.0f, n.z), a = -1.0f / (sign + n.z), b = n.x * n.y * a;
    *out_x = (vec3s){{1.0f + sign * n.x * n.x * a, sign * b, -sign * n.x}};
    *out_y = (vec3s){{b, sign + n.y * n.y * a, -n.y}};
}

/* Glass of this kind, which is made once. */
static inline const struct rnd_glass *glass_of(float ior, float roughness)
{
    enum { MOST = 64 };
    static struct {
        float ior, roughness;
        struct rnd_glass *glass;
    } made[MOST];
    int i = 0;
    while (i < MOST && made[i].glass && (made[i].ior != ior || made[i].roughness != roughness)) i++;
    assert_true(i < MOST);
    if (!made[i].glass) made[i].glass = rnd_glass_create(ior, roughness, roughness);
    assert_non_null(made[i].glass);
    made[i].ior = ior;
    made[i].roughness = roughness;
    return made[i].glass;
}

/* Make the surface of a case. Its normal is oblique in the world, so that its frame is tested too. */
static inline void make(const struct case_of_bsdf *from, float base, struct rnd_material *material,
                        struct rnd_surface *out)
{
    const vec3s n = glms_vec3_normalize((vec3s){{0.3f, -0.5f, -0.8f}});
    const float ior = from->ior > 0 ? from->ior : 1.5f, r = (ior - 1) / (ior + 1);
    const float f0 = r * r * from->specular, tilt = from->coat_tilt_deg * (float)deg,
                bend = from->bend_deg * (float)deg;
    vec3s x, y;
    frame_of(n, &x, &y);
    *material = (struct rnd_material){.kind = from->kind,
                                      .specular = from->specular,
                                      .ior = ior,
                                      .transmission = from->transmission,
                                      .thin = from->thin};
    if (from->transmission > 0 && !from->thin) {
        material->medium = 1;
        material->glass[0] = glass_of(ior, from->roughness);
    }
    *out = (struct rnd_surface){
        .material = material,
        .geometric = n,
        .shading = glms_vec3_muladds(y, sinf(bend), glms_vec3_scale(n, cosf(bend))),
        .front = !from->back,
        .base = {{base, base, base}},
        .metallic = from->metallic,
        .alpha = rnd_alpha(from->roughness),
        .layers = {.f0 = {{f0, f0, f0}},
                   .specular = from->specular,
                   .transmission = from->transmission,
                   .coat = from->coat,
                   .coat_alpha = rnd_alpha(from->coat_roughness),
                   .coat_normal = glms_vec3_muladds(x, sinf(tilt), glms_vec3_scale(n, cosf(tilt))),
                   .sheen = {{from->sheen, from->sheen, from->sheen}},
                   .sheen_roughness = from->sheen_roughness},
        .between = rnd_interface_in_air(material, !from->back)};
}

/* The direction with this cosine to the shading normal and this azimuth around it. */
static inline vec3s direction(const struct rnd_surface *s, double cosine, double azimuth)
{
    vec3s x, y;
    frame_of(s->shading, &x, &y);
    const double sine = sqrt(fmax(0.0, 1.0 - cosine * cosine));
    vec3s d = glms_vec3_scale(s->shading, (float)cosine);
    d = glms_vec3_muladds(x, (float)(sine * cos(azimuth)), d);
    return glms_vec3_normalize(glms_vec3_muladds(y, (float)(sine * sin(azimuth)), d));
}

/* Evaluate and sample the closure of a surface that is seen from wo. */
static inline vec3s bsdf(const struct rnd_surface *s, vec3s wo, vec3s wi, float *out_pdf)
{
    struct rnd_closure closure;
    rnd_closure_at(s, wo, &closure);
    return rnd_closure_evaluate(&closure, wi, out_pdf);
}

static inline bool bsdf_sample(const struct rnd_surface *s, vec3s wo, const float u[3],
                               struct rnd_scattered *out)
{
    struct rnd_closure closure;
    rnd_closure_at(s, wo, &closure);
    return rnd_closure_sample(&closure, u, out);
}

/* The sphere is divided into cells. Rows are even in the angle from the normal, so that narrow lobes cover
 * some. */
enum { ROWS = 48, COLUMNS = 24, CELLS = ROWS * COLUMNS };

static inline int cell_of(const struct rnd_surface *s, vec3s wi)
{
    vec3s x, y;
    frame_of(s->shading, &x, &y);
    const double theta = rnd_angle(wi, s->shading);
    const double azimuth = atan2(glms_vec3_dot(wi, y), glms_vec3_dot(wi, x)) + M_PI;
    const int row = (int)(theta / M_PI * ROWS), column = (int)(azimuth / (2.0 * M_PI) * COLUMNS);
    return (row < ROWS ? row : ROWS - 1) * COLUMNS + column % COLUMNS;
}

/* Integrate the stated density over each cell, by the midpoint rule with up x around points. Returns their
 * sum. */
static inline double masses(const struct rnd_surface *s, vec3s wo, int up, int around, double mass[CELLS])
{
    const double step_t = M_PI / (ROWS * up), step_a = 2.0 * M_PI / (COLUMNS * around);
    double sum = 0.0;
    for (int cell = 0; cell < CELLS; cell++) {
        mass[cell] = 0.0;
        for (int k = 0; k < up * around; k++) {
            const double theta = (cell / COLUMNS * up + k / around + 0.5) * step_t,
                         azimuth = (cell % COLUMNS * around + k % around + 0.5) * step_a - M_PI;
            float pdf;
            bsdf(s, wo, direction(s, cos(theta), azimuth), &pdf);
            mass[cell] += pdf * sin(theta) * step_t * step_a;
        }
        sum += mass[cell];
    }
    return sum;
}

static inline bool draw(const struct rnd_surface *s, vec3s wo, uint32_t stream, uint32_t i,
                        struct rnd_scattered *out)
{
    const float u[3] = {stat_uniform(stream, 3 * i), stat_uniform(stream, 3 * i + 1),
                        stat_uniform(stream, 3 * i + 2)};
    return bsdf_sample(s, wo, u, out);
}

/* Check that the density integrates to the share of draws that give a direction (a microfacet may reflect the
 * others below the surface), that draws follow it, and that a draw's weight is BSDF over density. Returns the
 * integral. */
static inline double assert_draws_follow_density(const struct case_of_bsdf *c, double angle_deg, int up,
                                                 int around, uint32_t stream)
{
    enum { DRAWS = SANITIZED ? 50000 : 200000 };
    static double mass[CELLS], count[CELLS];
    struct rnd_material material;
    struct rnd_surface s;
    make(c, 0.7f, &material, &s);
    const vec3s wo = direction(&s, cos(angle_deg * deg), 0.7);
    const double sum = masses(&s, wo, up, around, mass);
    int drawn = 0, deltas = 0;
    memset(count, 0, sizeof count);
    for (uint32_t i = 0; i < DRAWS; i++) {
        struct rnd_scattered sample;
        float pdf;
        if (!draw(&s, wo, stream, i, &sample)) continue;
        if (sample.delta) {
            deltas++;
            continue;
        }
        drawn++;
        count[cell_of(&s, sample.wi)]++;
        const vec3s f = bsdf(&s, wo, sample.wi, &pdf);
        assert_float_equal(pdf, sample.pdf, 2e-3 * pdf + 1e-3);
        assert_float_equal(f.x, sample.weight.x * sample.pdf, 2e-3 * f.x + 1e-3);
    }
    for (int i = 0; i < CELLS; i++) mass[i] *= drawn / sum;
    const double p = stat_chi_square_p(count, mass, CELLS), share = (double)drawn / DRAWS;
    print_message("%-22s %2.0f degrees: density %.4f, drawn %.4f, p %.3f\n", c->name, angle_deg, sum, share,
                  p);
    assert_true(p > LEAST_P);
    assert_true(fabs(sum - share) < (SANITIZED ? 0.008 : 0.004));
    return sum + (double)deltas / DRAWS;
}

#endif
