/* KHR_materials_transmission without a volume: a thin sheet. Light that passes keeps to its way, spread as a
 * reflection would be. Rays go straight through panes unseen (material/glass.h); what hits a pane is
 * reflected, or is the rest that a tint lets through. */
#include "material/transmission.h"

struct thin {
    struct rnd_dielectric border;
    float pane, rest; /* of the light that does not pass a pane unseen: reflected, and not reflected */
    bool smooth;
};
_Static_assert(sizeof(struct thin) <= RND_LOBE_BYTES, "a share has room for it");

static struct rnd_parting part(const struct rnd_sight *sight, const struct thin *thin, float cosine)
{
    const struct rnd_surface *s = sight->surface;
    if (!s->pane) return rnd_dielectric_part(&thin->border, s, cosine);
    const float unseen = glms_vec3_min(s->base);
    struct rnd_parting out;
    out.reflected = rnd_v3(thin->pane, thin->pane, thin->pane);
    out.through = rnd_v3_scale(rnd_v3_sub(rnd_to_v3(s->base), rnd_v3(unseen, unseen, unseen)), thin->rest);
    rnd_parting_choose(&out);
    return out;
}

static bool weigh(const struct rnd_sight *sight, float left, struct rnd_lobe_share *out)
{
    const struct rnd_surface *s = sight->surface;
    const float glass = rnd_glass_share(s);
    struct thin *thin = (void *)out->own;
    if (!s->material->thin || !(glass > 0.0f)) return false;
    thin->border = rnd_dielectric(s, s->material->ior);
    thin->smooth = s->alpha <= RND_MIN_ALPHA;
    if (s->pane) {
        float passes;
        const float reflects =
            rnd_pane_reflects(s->material, rnd_v3_dot(sight->towards, rnd_to_v3(s->geometric)), &passes);
        thin->pane = passes < 1.0f ? reflects / (1.0f - passes) : 1.0f;
        thin->rest = passes < 1.0f ? (1.0f - reflects) / (1.0f - passes) : 0.0f;
    }
    const struct rnd_parting p = part(sight, thin, sight->wo.z);
    out->strength = left * glass;
    out->chance = out->strength * rnd_parting_albedo(&p);
    return true;
}

/* The lobe below is the mirror image of the one above. Both get back what facets hide. */
static bool evaluate(const struct rnd_sight *sight, const struct rnd_lobe_share *share,
                     const struct rnd_incoming *in, struct rnd_v3 *out_f, float *out_pdf)
{
    const struct thin *thin = (const void *)share->own;
    const struct rnd_v3 wo = sight->wo, wi = in->local;
    const bool above = wi.z > 0.0f;
    if (thin->smooth || in->above != above) return false;
    const float alpha = sight->surface->alpha, o = fmaxf(wo.z, RND_MIN_COSINE),
                i = fmaxf(fabsf(wi.z), RND_MIN_COSINE);
    const struct rnd_v3 h = rnd_v3_normalize(rnd_v3(wo.x + wi.x, wo.y + wi.y, o + i));
    const float d = rnd_ggx_d(h, alpha), ro = rnd_ggx_reach(o, alpha), ri = rnd_ggx_reach(i, alpha);
    const struct rnd_parting p = part(sight, thin, rnd_v3_dot(wo, h));
    const float gloss = 0.5f * d * i / (i * ro + o * ri) / (1.0f - rnd_ggx_albedo(o, alpha).lost);
    *out_pdf = 0.5f * d / (o + ro) * (above ? p.p_reflect : 1.0f - p.p_reflect);
    *out_f = rnd_v3_scale(rnd_v3_scale(above ? p.reflected : p.through, gloss), share->strength);
    return true;
}

static bool sample(const struct rnd_sight *sight, const struct rnd_lobe_share *share, struct rnd_v3 u,
                   struct rnd_lobe_sample *out)
{
    const struct thin *thin = (const void *)share->own;
    const struct rnd_v3 h = rnd_sample_facet(sight, thin->smooth, u), r = rnd_mirror(sight->wo, h);
    const struct rnd_parting p = part(sight, thin, rnd_v3_dot(sight->wo, h));
    const bool above = u.z < p.p_reflect,
               leaves = rnd_leave_facet(sight, above ? r : rnd_v3(r.x, r.y, -r.z), above, out);
    if (!thin->smooth) return leaves;
    rnd_weigh_delta(&p, share, 1.0f, out);
    return true;
}

static struct rnd_v3 through(const struct rnd_sight *sight, const struct rnd_lobe_share *share)
{
    return rnd_v3_scale(part(sight, (const void *)share->own, sight->wo.z).through, share->strength);
}

const struct rnd_lobe rnd_lobe_thin = {
    .name = "thin",
    .source = "KHR_materials_transmission; Turquin 2019",
    .weigh = weigh,
    .evaluate = evaluate,
    .sample = sample,
    .through = through,
};
