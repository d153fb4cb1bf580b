/* What materials of all formats share: their defaults, their reflectance, and the stage of the integrator
 * that serves them. */
#include "material/material.h"
#include "material/ggx.h"
#include "material/glass.h"

#include <stdlib.h>

void rnd_material_init(struct rnd_material *material)
{
    *material = (struct rnd_material){.kind = RND_METAL_ROUGH,
                                      .base = {{1.0f, 1.0f, 1.0f}},
                                      .alpha = 1.0f,
                                      .alpha_cutoff = 0.5f,
                                      .metallic = 1.0f,
                                      .roughness = 1.0f,
                                      .specular = 1.0f,
                                      .specular_colour = {{1.0f, 1.0f, 1.0f}},
                                      .ior = 1.5f,
                                      .thin = true,
                                      .normal_scale = 1.0f,
                                      .clearcoat_normal_scale = 1.0f};
    for (int use = 0; use < RND_MAPS; use++)
        material->map[use] = (struct rnd_map){.texture = -1, .transform = {[0] = 1.0f, [4] = 1.0f}};
}

void rnd_material_set_f0(struct rnd_material *material, vec3s f0)
{
    const float most = fmaxf(f0.x, fmaxf(f0.y, f0.z));
    const float root = sqrtf(fminf(most, 0.99f)); /* at 1 the index is infinite */
    material->ior = (1.0f + root) / (1.0f - root);
    material->specular = most > 0.0f ? 1.0f : 0.0f;
    material->specular_colour = most > 0.0f ? glms_vec3_divs(f0, most) : glms_vec3_one();
}

static bool is_plain(const struct rnd_map *map)
{
    return map->texture < 0 || map->uv_set == 0;
}

/* What a pane lets through is known without a look at the surface. */
static bool is_pane(const struct rnd_material *m)
{
    for (int use = 0; use < RND_MAPS; use++)
        if (m->map[use].texture >= 0) return false;
    return m->thin && !m->unlit && m->transmission == 1.0f && m->metallic == 0.0f &&
           m->alpha_mode == RND_OPAQUE && rnd_alpha(m->roughness) <= RND_MIN_ALPHA &&
           glms_vec3_min(m->base) > 0.0f && m->clearcoat == 0.0f && glms_vec3_max(m->sheen_colour) == 0.0f &&
           glms_vec3_max(m->emission) == 0.0f && glms_vec3_eqv(m->specular_colour, glms_vec3_one());
}

void rnd_material_set_kind(struct rnd_material *m)
{
    bool rich = m->unlit || m->transmission > 0.0f || m->clearcoat > 0.0f ||
                glms_vec3_max(m->sheen_colour) > 0.0f ||
                (m->specular > 0.0f && !glms_vec3_eqv(m->specular_colour, glms_vec3_one()));
    for (int use = 0; use < RND_MAPS; use++) {
        const bool common = use == RND_MAP_BASE || use == RND_MAP_METAL_ROUGH || use == RND_MAP_NORMAL ||
                            use == RND_MAP_EMISSION || use == RND_MAP_COVERAGE;
        /* a normal map that is turned would need its tangents turned */
        if (use == RND_MAP_NORMAL && m->map[use].texture >= 0 && m->map[use].has_transform) rich = true;
        if (use != RND_MAP_COVERAGE && !is_plain(&m->map[use])) rich = true; /* the filters handle it */
        if (!common && m->map[use].texture >= 0) rich = true;
    }
    const bool lambert = m->specular == 0.0f && m->metallic == 0.0f &&
                         m->map[RND_MAP_METAL_ROUGH].texture < 0 && m->map[RND_MAP_NORMAL].texture < 0;
    m->f0 = powf((m->ior - 1.0f) / (m->ior + 1.0f), 2.0f) * m->specular;
    m->kind = rich ? RND_RICH : lambert ? RND_DIFFUSE : RND_METAL_ROUGH;
    m->pane = is_pane(m);
}

/* --- media --- */

/* The number of an index of refraction among the scene's. */
static uint32_t index_of(const struct rnd_scene *scene, float ior)
{
    uint32_t next = 0;
    for (uint32_t k = 0; k <= scene->medium_count; k++) {
        if (scene->medium[k].ior == ior) return scene->medium[k].index;
        if (scene->medium[k].index >= next) next = scene->medium[k].index + 1;
    }
    return next;
}

/* Materials often share a medium. */
static void add_medium(struct rnd_scene *scene, struct rnd_material *m)
{
    uint32_t k = 1;
    while (k <= scene->medium_count &&
           (scene->medium[k].ior != m->ior || !glms_vec3_eqv(scene->medium[k].absorption, m->absorption)))
        k++;
    if (k > UINT16_MAX) k = UINT16_MAX; /* more are taken for the last one */
    if (k > scene->medium_count) {
        const uint32_t index = index_of(scene, m->ior);
        scene->medium[++scene->medium_count] = (struct rnd_medium){m->ior, index, m->absorption};
    }
    m->medium = (uint16_t)k;
}

/* The table of a material's medium in another: they often share these too. NULL if memory is short. */
static const struct rnd_glass *glass_in(struct rnd_scene *scene, const struct rnd_material *m, float ior)
{
    const float ratio = m->ior / ior, least = m->map[RND_MAP_METAL_ROUGH].texture >= 0 ? 0.0f : m->roughness;
    for (uint32_t i = 0; i < scene->glass_count; i++)
        if (rnd_glass_is(scene->glass[i], ratio, least, m->roughness)) return scene->glass[i];
    return scene->glass[scene->glass_count++] = rnd_glass_create(ratio, least, m->roughness);
}

bool rnd_materials_build(struct rnd_scene *scene)
{
    const uint32_t count = scene->material_count;
    scene->medium = calloc(count + 1, sizeof *scene->medium);
    scene->glass = calloc((size_t)count * RND_GLASS_INDICES + 1, sizeof *scene->glass);
    if (!scene->medium || !scene->glass) return false;
    scene->medium[0].ior = 1.0f;
    for (uint32_t i = 0; i < count; i++) {
        struct rnd_material *m = &scene->material[i];
        if (m->kind == RND_RICH && m->transmission > 0.0f && !m->thin) add_medium(scene, m);
    }
    for (uint32_t i = 0; i < count; i++) {
        struct rnd_material *m = &scene->material[i];
        if (!m->medium || !(m->roughness > 0.0f)) continue;
        for (uint32_t k = 0; k <= scene->medium_count; k++) {
            const struct rnd_medium *other = &scene->medium[k];
            if (other->index >= RND_GLASS_INDICES || other->ior == m->ior || m->glass[other->index]) continue;
            if (!(m->glass[other->index] = glass_in(scene, m, other->ior))) return false;
        }
    }
    return true;
}
