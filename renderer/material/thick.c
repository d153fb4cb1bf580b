/* KHR_materials_volume: the border of a medium, which refracts. It is smooth, or rough by GGX, and then gets
 * back what more than one bounce would bring (material/glass.h). */
#include "material/transmission.h"

struct thick {
    struct rnd_dielectric border;
    bool smooth;
};
_Static_assert(sizeof(struct thick) <= RND_LOBE_BYTES, "a share has room for it");

static bool weigh(const struct rnd_sight *sight, float left, struct rnd_lobe_share *out)
{
    const struct rnd_surface *s = sight->surface;
    const float glass = rnd_glass_share(s);
    struct thick *thick = (void *)out->own;
    if (s->material->thin || !(glass > 0.0f)) return false;
    thick->border = rnd_dielectric(s, s->material->medium ? s->between.eta : s->material->ior);
    /* facets of an index of 1 bend nothing */
    thick->smooth = s->alpha <= RND_MIN_ALPHA || fabsf(thick->border.eta - 1.0f) < 1e-3f;
    const struct rnd_parting p = rnd_dielectric_part(&thick->border, s, sight->wo.z);
    out->strength = left * glass;
    out->chance = out->strength * rnd_parting_albedo(&p);
    return true;
}

static bool evaluate(const struct rnd_sight *sight, const struct rnd_lobe_share *share,
                     const struct rnd_incoming *in, struct rnd_v3 *out_f, float *out_pdf)
{
    const struct thick *thick = (const void *)share->own;
    const struct rnd_surface *s = sight->surface;
    const struct rnd_v3 wo = sight->wo, wi = in->local;
    const bool above = wi.z > 0.0f;
    if (thick->smooth || in->above != above) return false;
    const float eta = thick->border.eta, o = fmaxf(wo.z, RND_MIN_COSINE),
                i = fmaxf(fabsf(wi.z), RND_MIN_COSINE);
    const float ro = rnd_ggx_reach(o, s->alpha), ri = rnd_ggx_reach(i, s->alpha);
    struct rnd_v3 h = rnd_v3_muladd(wi, above ? 1.0f : eta, wo);
    if (!(rnd_v3_dot(h, h) > 1e-12f)) return false; /* no facet bends light to there */
    h = rnd_v3_scale(rnd_v3_normalize(h), h.z < 0.0f ? -1.0f : 1.0f);
    const float co = rnd_v3_dot(wo, h), ci = rnd_v3_dot(wi, h), d = rnd_ggx_d(h, s->alpha);
    if (co <= 0.0f || (above ? ci <= 0.0f : ci >= 0.0f)) return false;
    const struct rnd_parting p = rnd_dielectric_part(&thick->border, s, co);
    const struct rnd_interface *between = &s->between;
    const float more =
        between->glass ? 1.0f / rnd_glass_albedo(between->glass, o, s->alpha, between->inside) : 1.0f;
    struct rnd_v3 f;
    if (above) {
        *out_pdf = p.p_reflect * 0.5f * d / (o + ro);
        f = rnd_v3_scale(p.reflected, more * 0.5f * d * i / (i * ro + o * ri));
    } else {
        /* h is a visible normal with pdf 2 D co / (o + ro); the Jacobian is eqn 17 of Walter et al.; masking
         * is separable */
        const float bend = co + eta * ci,
                    visible = 2.0f * d * co / (o + ro) * -ci / (bend * bend) * eta * eta;
        *out_pdf = (1.0f - p.p_reflect) * visible;
        f = rnd_v3_scale(p.through, more * between->squeeze * visible * 2.0f * i / (i + ri));
    }
    *out_f = rnd_v3_scale(f, share->strength);
    return true;
}

static bool sample(const struct rnd_sight *sight, const struct rnd_lobe_share *share, struct rnd_v3 u,
                   struct rnd_lobe_sample *out)
{
    const struct thick *thick = (const void *)share->own;
    const struct rnd_surface *s = sight->surface;
    const struct rnd_v3 wo = sight->wo, h = rnd_sample_facet(sight, thick->smooth, u);
    const float eta = thick->border.eta, cosine = rnd_v3_dot(wo, h);
    const struct rnd_parting p = rnd_dielectric_part(&thick->border, s, cosine);
    const bool above = u.z < p.p_reflect;
    const struct rnd_v3 wi =
        above ? rnd_mirror(wo, h) : rnd_v3_muladd(h, cosine / eta - p.cos_t, rnd_v3_scale(wo, -1.0f / eta));
    const bool leaves = rnd_leave_facet(sight, wi, above, out);
    if (!thick->smooth) return leaves;
    rnd_weigh_delta(&p, share, s->material->medium ? s->between.squeeze : 1.0f, out);
    return true;
}

static struct rnd_v3 through(const struct rnd_sight *sight, const struct rnd_lobe_share *share)
{
    const struct thick *thick = (const void *)share->own;
    return rnd_v3_scale(rnd_dielectric_part(&thick->border, sight->surface, sight->wo.z).through,
                        share->strength);
}

const struct rnd_lobe rnd_lobe_thick = {
    .name = "thick",
    .source = "Walter et al. 2007, Microfacet models for refraction through rough surfaces",
    .weigh = weigh,
    .evaluate = evaluate,
    .sample = sample,
    .through = through,
};
