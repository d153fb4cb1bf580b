/* glTF 2.0's metallic-roughness: a GGX lobe over a diffuse one, which get the light that layers above leave
 * and that the base does not transmit. The two are one row because they share their energy (material/ggx.h);
 * KHR_materials_specular and _ior give the reflectance of the non-metal. */
#include "material/lobe.h"

_Static_assert(sizeof(struct rnd_mr) <= RND_LOBE_BYTES, "a share has room for it");

static bool weigh(const struct rnd_sight *sight, float left, struct rnd_lobe_share *out)
{
    const struct rnd_surface *s = sight->surface;
    const struct rnd_layers *l = &s->layers;
    struct rnd_mr *mr = (void *)out->own;
    const float rest = 1.0f - l->transmission * (1.0f - s->metallic);
    if (!(rest > 0.0f)) return false;
    *mr = rnd_mr(rnd_to_v3(s->base), s->metallic / rest, s->alpha, rnd_to_v3(l->f0), l->specular);
    out->strength = left * rest;
    out->chance = out->strength * rnd_mr_view(mr, fmaxf(sight->wo.z, RND_MIN_COSINE)).albedo;
    return true;
}

/* The diffuse part is not folded. */
static bool evaluate(const struct rnd_sight *sight, const struct rnd_lobe_share *share,
                     const struct rnd_incoming *in, struct rnd_v3 *out_f, float *out_pdf)
{
    const struct rnd_mr *mr = (const void *)share->own;
    struct rnd_v3 f;
    if (!in->above || !(in->local.z > 0.0f)) return false;
    if (in->folded) {
        const struct rnd_mr_view v = rnd_mr_view(mr, fmaxf(sight->wo.z, RND_MIN_COSINE));
        rnd_mr_gloss(mr, &v, sight->wo, in->local, &f, out_pdf);
    } else {
        rnd_mr_eval(mr, sight->wo, in->local, &f, out_pdf);
    }
    *out_f = rnd_v3_scale(f, share->strength);
    return true;
}

static bool sample(const struct rnd_sight *sight, const struct rnd_lobe_share *share, struct rnd_v3 u,
                   struct rnd_lobe_sample *out)
{
    const struct rnd_mr *mr = (const void *)share->own;
    struct rnd_v3 wi, weight;
    float pdf;
    rnd_mr_draw(mr, sight->wo, u, &wi, &weight, &pdf);
    out->wi = rnd_unit_to_world(&sight->frame, wi);
    out->above = true;
    out->folds = u.z < rnd_mr_view(mr, fmaxf(sight->wo.z, RND_MIN_COSINE)).share;
    return wi.z > 0.0f; /* else into another facet */
}

const struct rnd_lobe rnd_lobe_metal_rough = {
    .name = "metal-rough",
    .source = "glTF 2.0 appendix B; Turquin 2019; Ashikhmin and Shirley 2000",
    .weigh = weigh,
    .evaluate = evaluate,
    .sample = sample,
};
