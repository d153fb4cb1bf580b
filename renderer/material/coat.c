/* KHR_materials_clearcoat: a smooth or rough varnish of index 1.5 that has a normal of its own. */
#include "material/lobe.h"

#define F0 0.04f /* of index 1.5 */

struct coat {
    struct rnd_v3_frame frame; /* of the coat's normal */
    struct rnd_v3 wo;          /* in it */
};
_Static_assert(sizeof(struct coat) <= RND_LOBE_BYTES, "a share has room for it");

static bool weigh(const struct rnd_sight *sight, float left, struct rnd_lobe_share *out)
{
    const struct rnd_layers *l = &sight->surface->layers;
    struct coat *coat = (void *)out->own;
    (void)left; /* the coat is the top layer */
    if (sight->inside || !(l->coat > 0.0f)) return false;
    coat->frame = rnd_v3_frame(rnd_to_v3(l->coat_normal));
    coat->wo = rnd_v3_to_local(&coat->frame, sight->towards);
    if (!(coat->wo.z > 0.0f)) return false;
    out->strength = l->coat;
    out->taken = out->chance = l->coat * rnd_reflected(rnd_ggx_albedo(coat->wo.z, l->coat_alpha), F0, 1.0f);
    out->bent = rnd_is_bent(sight->surface, l->coat_normal);
    return true;
}

static bool evaluate(const struct rnd_sight *sight, const struct rnd_lobe_share *share,
                     const struct rnd_incoming *in, struct rnd_v3 *out_f, float *out_pdf)
{
    const struct coat *coat = (const void *)share->own;
    const struct rnd_v3 wo = coat->wo, wi = rnd_v3_to_local(&coat->frame, in->world);
    if (!in->above || !(wi.z > 0.0f)) return false;
    const float alpha = sight->surface->layers.coat_alpha, ro = rnd_ggx_reach(wo.z, alpha);
    const struct rnd_v3 h = rnd_v3_normalize(rnd_v3_add(wo, wi));
    const float d = rnd_ggx_d(h, alpha), fresnel = F0 + (1.0f - F0) * rnd_schlick(rnd_v3_dot(wi, h));
    const float gloss = 0.5f * d * wi.z * fresnel / (wi.z * ro + wo.z * rnd_ggx_reach(wi.z, alpha)),
                value = gloss * share->strength;
    *out_f = rnd_v3(value, value, value);
    *out_pdf = 0.5f * d / (wo.z + ro);
    return true;
}

static bool sample(const struct rnd_sight *sight, const struct rnd_lobe_share *share, struct rnd_v3 u,
                   struct rnd_lobe_sample *out)
{
    const struct coat *coat = (const void *)share->own;
    const struct rnd_v3 h = rnd_draw_ggx_normal(coat->wo, sight->surface->layers.coat_alpha, u.x, u.y),
                        wi = rnd_mirror(coat->wo, h);
    out->wi = rnd_unit_to_world(&coat->frame, wi);
    out->above = out->folds = true;
    return wi.z > 0.0f; /* else into another facet */
}

const struct rnd_lobe rnd_lobe_coat = {
    .name = "coat",
    .source = "KHR_materials_clearcoat",
    .weigh = weigh,
    .evaluate = evaluate,
    .sample = sample,
};
