/* Glass: what it reflects, panes, and the energy of rough glass.
 *
 * Rays pass straight through panes. For rough glass, tables say how much light one bounce off or through a
 * facet brings out, so that the rest can be given back (Turquin 2019, "Practical multiple scattering
 * compensation for microfacet models").
 */
#ifndef FOVEAD_RENDERER_GLASS_H
#define FOVEAD_RENDERER_GLASS_H

#include "scene/scene.h"

#include <math.h>
#include <stdbool.h>

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

/* The same, rescaled as KHR_materials_specular asks: from f0 at normal incidence to specular at grazing
 * angles. */
static inline float rnd_fresnel_scaled(float whole, float eta, float f0, float specular)
{
    const float r = (eta - 1.0f) / (eta + 1.0f);
    const float t = fmaxf(0.0f, (whole - r * r) / (1.0f - r * r));
    return f0 * (1.0f - t) + specular * t;
}

/* --- panes ---
 *
 * A pane is not there for the rays that go straight through it: Embree's filters let each ray pass with the
 * chance of light to do so, whatever its colour, and what hits it is reflected, or is the rest that a tint
 * lets through. So light is found through a window as well as without it, shadow rays and all. */

/* Does light go straight through the mesh? */
static inline bool rnd_is_pane(const struct rnd_mesh *mesh, const struct rnd_material *material)
{
    return material->pane && !mesh->colour;
}

/* Share of light that a pane reflects, and that passes it unseen, at the cosine between its way and the
 * triangle. */
static inline float rnd_pane_reflects(const struct rnd_material *material, float cosine, float *out_passes)
{
    float cos_t;
    const float whole = rnd_fresnel_dielectric(fminf(cosine, 1.0f), material->ior, &cos_t),
                reflected = rnd_fresnel_scaled(whole, material->ior, material->f0, material->specular);
    *out_passes = glms_vec3_min(material->base) * (1.0f - reflected);
    return reflected;
}

/* --- clear glass --- */

/* Rougher glass is not treated as clear. It scatters so widely that lights drawn at its own surface find what
 * is behind it, and much of its light comes out after bounces that a straight line does not have. */
#define RND_CLEAR_ROUGHNESS 0.25f

static inline bool rnd_is_clear(const struct rnd_scene *scene, uint32_t mesh)
{
    const struct rnd_material *material = &scene->material[scene->mesh[mesh].material];
    return scene->clear_glass && material->kind == RND_RICH && material->transmission > 0.0f &&
           material->alpha_mode == RND_OPAQUE && material->roughness <= RND_CLEAR_ROUGHNESS &&
           !rnd_is_pane(&scene->mesh[mesh], material);
}

/* --- rough glass --- */

struct rnd_glass;

/* Tables of glass, by quadrature: for an index relative to the medium around it, seen from both sides, and
 * any roughness between these two. NULL if memory is short. The caller frees. */
struct rnd_glass *rnd_glass_create(float ior, float least_roughness, float most_roughness);
/* Was the table made for this index and these roughnesses? */
bool rnd_glass_is(const struct rnd_glass *glass, float ior, float least_roughness, float most_roughness);
/* Share of light that white glass reflects and lets through in one bounce, by the cosine of the direction
 * that it is seen from, from inside or from outside. */
float rnd_glass_albedo(const struct rnd_glass *glass, float cosine, float alpha, bool inside);

#endif
