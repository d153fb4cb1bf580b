/* Diffuse (Lambert) and glTF 2.0's metallic-roughness, as functions of plain floats that a compiler can
 * vectorise: they have no branches, and call nothing but square roots. Directions point away from the
 * surface. They are in a frame whose z is the shading normal.
 *
 * Metallic-roughness is a GGX lobe over a diffuse one (glTF 2.0 appendix B). It loses no energy:
 * - The facets of a metal hide light from each other. The lobe gets that light back (Turquin 2019,
 *   "Practical multiple scattering compensation for microfacet models"): it is multiplied by 1 + base (1 -
 *   E(o)) / E(o), where E is the albedo of the lobe of a white surface, and o the direction to which light
 *   is followed. This factor alone is not reciprocal.
 * - The surface of a non-metal reflects some light, and the diffuse lobe gets the rest, on the way in and
 *   on the way out (Ashikhmin and Shirley 2000, with the albedo S of the lobe in place of their Fresnel
 *   term): base (1 - S(o)) (1 - S(i)) / (pi (1 - S_mean)).
 * With base 1 all light returns. E and S are polynomials fitted to quadratures.
 */
#ifndef FOVEAD_RENDERER_GGX_H
#define FOVEAD_RENDERER_GGX_H

#include "math/v3.h"

#include <stdbool.h>

#define RND_PI 3.14159265f
/* Below this GGX's peak outgrows float; a mirror is a lobe of this width. */
#define RND_MIN_ALPHA 1e-3f
/* Directions are taken to be at least this far above the surface. */
#define RND_MIN_COSINE 1e-5f

/* GGX alpha of glTF's roughness. */
RND_INLINE float rnd_alpha(float roughness)
{
    return rnd_larger(roughness * roughness, RND_MIN_ALPHA);
}

/* --- draws from u0, u1 in [0,1) --- */

/* By cosine: density z / pi (Malley's method). */
RND_INLINE struct rnd_v3 rnd_draw_cosine(float u0, float u1)
{
    const float r = sqrtf(u0);
    float s, c;
    rnd_turn(u1, &s, &c);
    return rnd_v3(r * c, r * s, sqrtf(1.0f - u0));
}

/* A normal of GGX as seen from wo: a cap of the sphere, stretched (Dupuy and Benyoub 2023, "Sampling visible
 * GGX normals with spherical caps"). */
RND_INLINE struct rnd_v3 rnd_draw_ggx_normal(struct rnd_v3 wo, float alpha, float u0, float u1)
{
    const struct rnd_v3 v = rnd_v3_normalize(rnd_v3(alpha * wo.x, alpha * wo.y, wo.z));
    float s, c;
    rnd_turn(u1, &s, &c);
    const float down = u0 * (1.0f + v.z); /* 1 - z of the cap's point, without its cancellation */
    const float sine = sqrtf(rnd_larger(down * (2.0f - down), 0.0f));
    const struct rnd_v3 h =
        rnd_v3(alpha * (sine * c + v.x), alpha * (sine * s + v.y), rnd_larger(1.0f - down + v.z, 1e-7f));
    return rnd_v3_normalize(h);
}

/* --- parts of microfacet models --- */

RND_INLINE struct rnd_v3 rnd_mirror(struct rnd_v3 wo, struct rnd_v3 h)
{
    const float c = 2.0f * rnd_v3_dot(wo, h);
    return rnd_v3(c * h.x - wo.x, c * h.y - wo.y, c * h.z - wo.z);
}

/* Schlick's (1 - cosine)^5. */
RND_INLINE float rnd_schlick(float cosine)
{
    const float m = rnd_larger(1.0f - cosine, 0.0f), m2 = m * m;
    return m2 * m2 * m;
}

/* Density of GGX's normals: h unit, above. */
RND_INLINE float rnd_ggx_d(struct rnd_v3 h, float alpha)
{
    const float a2 = alpha * alpha;
    /* z^2 (a2 - 1) + 1 without its cancellation where the lobe is narrow */
    const float k = a2 * h.z * h.z + h.x * h.x + h.y * h.y;
    return a2 / (RND_PI * k * k);
}

/* cosine sqrt(1 + alpha^2 tan^2): all that Smith's masking needs of a direction (Heitz 2014), finite at 0. */
RND_INLINE float rnd_ggx_reach(float cosine, float alpha)
{
    const float a2 = alpha * alpha;
    return sqrtf(a2 + (1.0f - a2) * cosine * cosine);
}

/* --- albedos --- */

/* Of a white GGX lobe seen at a cosine: lost = 1 - E, and edge, the part of E that Schlick's term weighs. A
 * lobe with Fresnel f0, f90 has albedo f0 (1 - lost - edge) + f90 edge.
 * Where cosine >= 0.08, E is within 0.35 % and edge within 0.0025 of a quadrature; below, within four times
 * that. */
struct rnd_albedo {
    float lost, edge;
};

#define RND_CUBIC(y, a, b, c, d) ((a) + (y) * ((b) + (y) * ((c) + (y) * (d))))

RND_INLINE struct rnd_albedo rnd_ggx_albedo(float cosine, float alpha)
{
    const float a = alpha, r = sqrtf(alpha), x = cosine / (cosine + alpha), m = 1.0f - cosine, m2 = m * m;
    const float l = RND_CUBIC(a, 0.4271463f, -0.4791054f, 4.681958f, -0.7444674f) +
                    x * (RND_CUBIC(a, -2.666636f, 9.917059f, -18.04568f, -4.373785f) +
                         x * (RND_CUBIC(a, 13.00704f, -47.40208f, 64.19965f, 29.3581f) +
                              x * (RND_CUBIC(a, -19.31246f, 73.30661f, -53.70342f, -104.2718f) +
                                   x * RND_CUBIC(a, 8.545265f, -35.45531f, -0.9645394f, 102.7811f))));
    const float e = RND_CUBIC(r, 1.157946f, -3.370354f, 3.645919f, -1.38961f) +
                    x * (RND_CUBIC(r, 0.7058326f, -4.976704f, 5.664356f, -1.687456f) +
                         x * (RND_CUBIC(r, -5.901737f, 35.52629f, -26.94454f, 1.781405f) +
                              x * (RND_CUBIC(r, 9.34345f, -39.36181f, -35.87377f, 38.75213f) +
                                   x * RND_CUBIC(r, -4.306206f, 12.03408f, 50.7908f, -1.904311f))));
    struct rnd_albedo out;
    out.lost = rnd_smaller(rnd_larger(x * (1.0f - x) * l, 0.0f), 1.0f);
    out.edge = rnd_smaller(rnd_larger(m2 * m2 * m * e, 0.0f), 1.0f - out.lost);
    return out;
}

/* Their means over the hemisphere by cosine. */
RND_INLINE struct rnd_albedo rnd_ggx_mean_albedo(float alpha)
{
    const float r = sqrtf(alpha);
    return (struct rnd_albedo){.lost = alpha * (-0.25337833f + r * (2.07653971f - r * 1.23382284f)),
                               .edge = 0.04674541f +
                                       r * RND_CUBIC(r, 0.04194896f, -0.41517796f, 0.54513749f, -0.2152887f)};
}

/* Albedo of a lobe with Fresnel f0, f90. */
RND_INLINE float rnd_reflected(struct rnd_albedo a, float f0, float f90)
{
    return f0 * (1.0f - a.lost - a.edge) + f90 * a.edge;
}

/* --- metallic-roughness --- */

struct rnd_mr {
    struct rnd_v3 base;
    float metallic, alpha;
    struct rnd_v3 f0; /* of the non-metal */
    float f90;
    float diffuse; /* factor of the diffuse lobe */
};

/* f0, f90 are the non-metal's: f0 by channel, f90 for all; alpha as rnd_alpha() gives it; the others as in
 * glTF. */
RND_INLINE struct rnd_mr rnd_mr(struct rnd_v3 base, float metallic, float alpha, struct rnd_v3 f0, float f90)
{
    const float inside = 1.0f - rnd_reflected(rnd_ggx_mean_albedo(alpha), rnd_v3_max(f0), f90);
    return (struct rnd_mr){base, metallic, alpha, f0, f90, (1.0f - metallic) / rnd_larger(inside, 1e-3f)};
}

/* Share of light that the non-metal's surface lets through. */
RND_INLINE float rnd_mr_through(const struct rnd_mr *m, struct rnd_albedo a)
{
    return 1.0f - rnd_reflected(a, rnd_v3_max(m->f0), m->f90);
}

/* What depends on wo alone: the Fresnel terms of the glossy lobe (metal and non-metal mixed, the metal
 * compensated), and the share of draws that go to the glossy lobe, which is its share of the albedo. */
struct rnd_mr_view {
    struct rnd_v3 f0, f90;
    float through, share;
    float albedo; /* of all, mean of the channels */
};

RND_INLINE struct rnd_mr_view rnd_mr_view(const struct rnd_mr *m, float cosine)
{
    const struct rnd_albedo a = rnd_ggx_albedo(cosine, m->alpha);
    const float k = a.lost / rnd_larger(1.0f - a.lost, 1e-3f), coat = 1.0f - m->metallic;
    struct rnd_mr_view v;
    const struct rnd_v3 metal =
        rnd_v3(m->metallic * (1.0f + k * m->base.x), m->metallic * (1.0f + k * m->base.y),
               m->metallic * (1.0f + k * m->base.z));
    v.f0 = rnd_v3_muladd(m->f0, coat, rnd_v3_mul(metal, m->base));
    v.f90 = rnd_v3_add(metal, rnd_v3(coat * m->f90, coat * m->f90, coat * m->f90));
    v.through = rnd_mr_through(m, a);
    const float gloss = rnd_v3_sum(v.f0) * (1.0f - a.lost - a.edge) + rnd_v3_sum(v.f90) * a.edge;
    const float diffuse = rnd_v3_sum(m->base) * coat * v.through;
    v.share = gloss / rnd_larger(gloss + diffuse, 1e-9f);
    v.albedo = (gloss + diffuse) / 3.0f;
    return v;
}

/* The glossy lobe alone: BSDF times cosine, and its part of the density. Zero below. */
RND_INLINE void rnd_mr_gloss(const struct rnd_mr *m, const struct rnd_mr_view *v, struct rnd_v3 wo,
                             struct rnd_v3 wi, struct rnd_v3 *out_f, float *out_pdf)
{
    const float o = rnd_larger(wo.z, RND_MIN_COSINE), i = rnd_larger(wi.z, RND_MIN_COSINE);
    const struct rnd_v3 h = rnd_v3_normalize(rnd_v3(wo.x + wi.x, wo.y + wi.y, o + i));
    const float d = rnd_ggx_d(h, m->alpha), t = rnd_schlick(rnd_v3_dot(wo, h));
    const float ro = rnd_ggx_reach(o, m->alpha), ri = rnd_ggx_reach(i, m->alpha);
    const float above = wi.z > 0.0f ? 1.0f : 0.0f;
    const float gloss = above * 0.5f * d * i / (i * ro + o * ri), dull = gloss * (1.0f - t), edge = gloss * t;
    *out_f = rnd_v3(v->f0.x * dull + v->f90.x * edge, v->f0.y * dull + v->f90.y * edge,
                    v->f0.z * dull + v->f90.z * edge);
    *out_pdf = v->share * above * 0.5f * d / (o + ro);
}

/* BSDF times cosine, and the density with which rnd_mr_draw() draws wi, per steradian. Zero below. */
RND_INLINE void rnd_mr_eval(const struct rnd_mr *m, struct rnd_v3 wo, struct rnd_v3 wi, struct rnd_v3 *out_f,
                            float *out_pdf)
{
    const float i = rnd_larger(wi.z, RND_MIN_COSINE), cosine = (wi.z > 0.0f ? 1.0f : 0.0f) * i / RND_PI;
    const struct rnd_mr_view v = rnd_mr_view(m, rnd_larger(wo.z, RND_MIN_COSINE));
    const float diffuse = m->diffuse * v.through * rnd_mr_through(m, rnd_ggx_albedo(i, m->alpha)) * cosine;
    struct rnd_v3 gloss;
    rnd_mr_gloss(m, &v, wo, wi, &gloss, out_pdf);
    *out_f = rnd_v3_muladd(m->base, diffuse, gloss);
    *out_pdf += (1.0f - v.share) * cosine;
}

/* Draw wi from three numbers in [0,1). weight is BSDF times cosine over density; where the path ends, weight
 * and density are zero. */
RND_INLINE void rnd_mr_draw(const struct rnd_mr *m, struct rnd_v3 wo, struct rnd_v3 u, struct rnd_v3 *out_wi,
                            struct rnd_v3 *out_weight, float *out_pdf)
{
    const float share = rnd_mr_view(m, rnd_larger(wo.z, RND_MIN_COSINE)).share;
    const struct rnd_v3 g = rnd_mirror(wo, rnd_draw_ggx_normal(wo, m->alpha, u.x, u.y)),
                        c = rnd_draw_cosine(u.x, u.y);
    const int glossy = u.z < share;
    const struct rnd_v3 wi = rnd_v3(glossy ? g.x : c.x, glossy ? g.y : c.y, glossy ? g.z : c.z);
    struct rnd_v3 f;
    float pdf;
    rnd_mr_eval(m, wo, wi, &f, &pdf);
    const float inverse = pdf > 0.0f ? 1.0f / pdf : 0.0f;
    *out_wi = wi;
    *out_weight = rnd_v3_scale(f, inverse);
    *out_pdf = pdf;
}

/* --- shading normals that are not the triangle's ---
 *
 * A normal map or a smooth normal may reflect light to below the triangle. That light is not lost: the flat
 * surface around the bump reflects it once more, so that a lobe's part below is folded back about the
 * triangle's plane, and a white metal stays white whatever its normal. (To bend the normal until the mirror
 * direction is above, as Keller et al. 2017, "The Iray light transport simulation and rendering system",
 * section A.3, and Cycles do, keeps a mirror bright but loses up to half of a rough lobe.) The diffuse lobe
 * is not folded: the light below the triangle is light that the bump hides from itself. */

/* A direction mirrored about the plane of a unit normal. */
RND_INLINE struct rnd_v3 rnd_fold(struct rnd_v3 w, struct rnd_v3 normal)
{
    return rnd_v3_muladd(normal, -2.0f * rnd_v3_dot(w, normal), w);
}

/* rnd_mr_eval() for a triangle with that normal, in the frame of the shading normal. Zero below the triangle.
 */
RND_INLINE void rnd_mr_eval_folded(const struct rnd_mr *m, struct rnd_v3 geometric, struct rnd_v3 wo,
                                   struct rnd_v3 wi, struct rnd_v3 *out_f, float *out_pdf)
{
    *out_f = rnd_v3(0.0f, 0.0f, 0.0f);
    *out_pdf = 0.0f;
    if (!(rnd_v3_dot(wi, geometric) > 0.0f)) return;
    rnd_mr_eval(m, wo, wi, out_f, out_pdf);
    const struct rnd_v3 below = rnd_fold(wi, geometric);
    if (!(below.z > 0.0f)) return;
    const struct rnd_mr_view v = rnd_mr_view(m, rnd_larger(wo.z, RND_MIN_COSINE));
    struct rnd_v3 f;
    float pdf;
    rnd_mr_gloss(m, &v, wo, below, &f, &pdf);
    *out_f = rnd_v3_add(*out_f, f);
    *out_pdf += pdf;
}

/* rnd_mr_draw() for the same. */
RND_INLINE void rnd_mr_draw_folded(const struct rnd_mr *m, struct rnd_v3 geometric, struct rnd_v3 wo,
                                   struct rnd_v3 u, struct rnd_v3 *out_wi, struct rnd_v3 *out_weight,
                                   float *out_pdf)
{
    rnd_mr_draw(m, wo, u, out_wi, out_weight, out_pdf);
    if (!(*out_pdf > 0.0f)) return;
    const bool glossy = u.z < rnd_mr_view(m, rnd_larger(wo.z, RND_MIN_COSINE)).share;
    if (glossy && rnd_v3_dot(*out_wi, geometric) < 0.0f) *out_wi = rnd_fold(*out_wi, geometric);
    struct rnd_v3 f;
    rnd_mr_eval_folded(m, geometric, wo, *out_wi, &f, out_pdf);
    *out_weight = rnd_v3_scale(f, *out_pdf > 0.0f ? 1.0f / *out_pdf : 0.0f);
}

#endif
