/* RND_RICH: all that glTF's extensions lay over and put in place of metallic-roughness. */
#ifndef FOVEAD_RENDERER_RICH_H
#define FOVEAD_RENDERER_RICH_H

#include "path/ggx.h"
#include "path/glass.h"
#include "path/shade.h"

static inline struct rnd_v3 rnd_to_v3(vec3s a)
{
    return rnd_v3(a.x, a.y, a.z);
}

static inline vec3s rnd_from_v3(struct rnd_v3 a)
{
    return (vec3s){{a.x, a.y, a.z}};
}

/* Unpolarised Fresnel reflectance; eta is the index behind over the index in front; *out_cos_t is 0 when all
 * is reflected. */
static inline float rnd_fresnel_dielectric(float cos_i, float eta, float *out_cos_t)
{
    const float sin2 = (1.0f - cos_i * cos_i) / (eta * eta);
    *out_cos_t = 0.0f;
    if (sin2 >= 1.0f) return 1.0f;
    const float cos_t = *out_cos_t = sqrtf(1.0f - sin2);
    const float parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    const float perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
    return 0.5f * (parallel * parallel + perpendicular * perpendicular);
}

/* rnd_bsdf() and rnd_bsdf_draw() for RND_RICH. */
vec3s rnd_rich_bsdf(const struct rnd_surface *surface, vec3s wo, vec3s wi, float *out_pdf);
bool rnd_rich_draw(const struct rnd_surface *surface, vec3s wo, const float u[3],
                   struct rnd_bsdf_sample *out);

#endif
