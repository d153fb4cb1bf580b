/* What the lobes that transmit share: how light parts at a facet of glass. */
#ifndef FOVEAD_RENDERER_TRANSMISSION_H
#define FOVEAD_RENDERER_TRANSMISSION_H

#include "material/glass.h"
#include "material/lobe.h"

/* Of light at a facet: what is reflected, and what goes through, tinted. */
struct rnd_parting {
    struct rnd_v3 reflected, through;
    float p_reflect; /* chance with which reflection is sampled */
    float cos_t;     /* between the refracted direction and the facet's normal; 0: nothing goes through */
};

/* Of the light that the layers above leave, how much meets glass instead of metal or a diffuse base. */
static inline float rnd_glass_share(const struct rnd_surface *surface)
{
    return surface->layers.transmission * (1.0f - surface->metallic);
}

/* Reflection and transmission are sampled by their brightness. */
static inline void rnd_parting_choose(struct rnd_parting *parting)
{
    const float reflect = rnd_v3_sum(parting->reflected), pass = rnd_v3_sum(parting->through);
    parting->p_reflect = reflect + pass > 0.0f ? reflect / (reflect + pass) : 1.0f;
}

/* Mean over the channels of what is reflected and what goes through. */
static inline float rnd_parting_albedo(const struct rnd_parting *parting)
{
    return (rnd_v3_sum(parting->reflected) + rnd_v3_sum(parting->through)) / 3.0f;
}

/* The border of a dielectric: eta is the index behind over the index in front, f0 the reflectance ahead at
 * that border. */
struct rnd_dielectric {
    float eta;
    struct rnd_v3 f0;
};

static inline struct rnd_dielectric rnd_dielectric(const struct rnd_surface *surface, float eta)
{
    const struct rnd_layers *l = &surface->layers;
    const float ior = surface->material->ior, air = (ior - 1.0f) / (ior + 1.0f),
                here = (eta - 1.0f) / (eta + 1.0f), r = here * here;
    if (air * air < 1e-8f)
        return (struct rnd_dielectric){eta, rnd_v3(l->specular * r, l->specular * r, l->specular * r)};
    const float scale = r / (air * air); /* the layers' f0 is in air */
    return (struct rnd_dielectric){eta, rnd_v3(fminf(l->f0.x * scale, 1.0f), fminf(l->f0.y * scale, 1.0f),
                                               fminf(l->f0.z * scale, 1.0f))};
}

/* At a cosine to the facet's normal. Fresnel's equations run from f0 to specular, as KHR_materials_specular
 * wants. */
static inline struct rnd_parting rnd_dielectric_part(const struct rnd_dielectric *d,
                                                     const struct rnd_surface *surface, float cosine)
{
    const float specular = surface->layers.specular;
    struct rnd_parting out;
    const float whole = rnd_fresnel_dielectric(fminf(cosine, 1.0f), d->eta, &out.cos_t);
    if (out.cos_t <= 0.0f) return (struct rnd_parting){.reflected = {1, 1, 1}, .p_reflect = 1.0f};
    out.reflected = rnd_v3(rnd_fresnel_scaled(whole, d->eta, d->f0.x, specular),
                           rnd_fresnel_scaled(whole, d->eta, d->f0.y, specular),
                           rnd_fresnel_scaled(whole, d->eta, d->f0.z, specular));
    out.through = rnd_v3_scale(rnd_to_v3(surface->base), 1.0f - rnd_v3_max(out.reflected));
    rnd_parting_choose(&out);
    return out;
}

/* The facet that light is sampled at: the surface itself if it is smooth. */
static inline struct rnd_v3 rnd_sample_facet(const struct rnd_sight *sight, bool smooth, struct rnd_v3 u)
{
    return smooth ? rnd_v3(0, 0, 1) : rnd_draw_ggx_normal(sight->wo, sight->surface->alpha, u.x, u.y);
}

/* Light goes along wi, in the frame of the sight, from a facet.
 * False if it goes into another facet. */
static inline bool rnd_leave_facet(const struct rnd_sight *sight, struct rnd_v3 wi, bool above,
                                   struct rnd_lobe_sample *out)
{
    out->wi = rnd_unit_to_world(&sight->frame, wi);
    out->above = above;
    out->folds = true;
    return above == (wi.z > 0.0f);
}

/* The weight of light at a smooth facet. squeeze: factor of radiance that goes through. */
static inline void rnd_weigh_delta(const struct rnd_parting *p, const struct rnd_lobe_share *share,
                                   float squeeze, struct rnd_lobe_sample *out)
{
    const float part = share->strength / share->chance;
    out->delta = true;
    out->weight = out->above ? rnd_v3_scale(p->reflected, part / p->p_reflect)
                             : rnd_v3_scale(p->through, part * squeeze / (1.0f - p->p_reflect));
}

#endif
