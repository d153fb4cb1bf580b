/* Light that paths find without choosing a light: the sky's, and what the surfaces that they hit emit. */
#include "path/emission.h"
#include "light/area.h"
#include "light/drop.h"
#include "light/env.h"
#include "light/light.h"
#include "light/sun.h"

/* The environment's texel that each path of a list meets, by its own random neighbour of four, and the one
 * that it falls into, with its region. Both are asked of memory. */
static void sky_texels(struct rnd_tracer *tracer, const struct rnd_env *env, const uint32_t *list,
                       uint32_t count, uint32_t *restrict out_near, uint32_t *restrict out_in,
                       uint32_t *restrict out_region)
{
    const struct rnd_paths *paths = &tracer->paths[0];
    const uint32_t which = 256 + (uint32_t)tracer->depth;
#pragma GCC ivdep
    for (size_t k = 0; k < count; k++) {
        const uint32_t i = list[k];
        float u, v, r, s;
        rnd_env_to_uv(env, rnd_get(&paths->direction, i), &u, &v);
        rnd_dither(paths->seed[i], paths->index[i], which, &r, &s);
        out_near[k] = rnd_env_texel(env, u, v, r, s);
        out_in[k] = rnd_env_texel(env, u, v, 0.5f, 0.5f);
        out_region[k] = rnd_env_region(env, u, v);
    }
    for (uint32_t k = 0; k < count; k++) {
        __builtin_prefetch(env->texel[out_near[k]]);
        __builtin_prefetch(env->texel[out_in[k]]);
    }
}

void ISA(rnd_sky)(struct rnd_tracer *tracer, const uint32_t *list, uint32_t count)
{
    const struct rnd_lights *lights = &tracer->scene->lights;
    const struct rnd_paths *paths = &tracer->paths[0];
    const struct rnd_env *env = lights->env;
    const struct rnd_sun *sun = lights->sun && lights->sun->drop > 0.0f ? lights->sun : NULL;
    uint32_t *near = tracer->scratch.sky.near, *in = tracer->scratch.sky.in,
             *region = tracer->scratch.sky.region;
    if (env) sky_texels(tracer, env, list, count, near, in, region);
    for (uint32_t k = 0; k < count; k++) {
        const uint32_t i = list[k];
        const struct rnd_v3 direction = rnd_get(&paths->direction, i);
        struct rnd_v3 radiance = {0, 0, 0};
        if (env) {
            const float *t = env->texel[near[k]],
                        density = env->texel[in[k]][3] * tracer->choice->env.factor[region[k]];
            const float level = sqrtf(direction.x * direction.x + direction.z * direction.z);
            const float other = tracer->choice->group[RND_LIGHT_ENV] * density / rnd_larger(level, 1e-6f);
            const float weight = paths->pdf[i] > 0.0f ? rnd_power_heuristic(paths->pdf[i], other) : 1.0f;
            radiance = rnd_v3_scale(rnd_v3(t[0], t[1], t[2]), weight);
        }
        if (sun && rnd_drop(direction, sun->direction) <= sun->drop) {
            const float other = tracer->choice->group[RND_LIGHT_SUN] * rnd_sun_pdf(sun);
            const float weight = paths->pdf[i] > 0.0f ? rnd_power_heuristic(paths->pdf[i], other) : 1.0f;
            radiance = rnd_v3_muladd(sun->radiance, weight, radiance);
        }
        if (rnd_has_media(tracer) && paths->media[i])
            radiance =
                rnd_v3_mul(radiance, rnd_media_transmittance(tracer->scene, paths->media[i], INFINITY));
        rnd_add_radiance(tracer, paths->id[i], rnd_v3_mul(radiance, rnd_get(&paths->throughput, i)));
    }
}

void ISA(rnd_emission)(struct rnd_tracer *tracer, uint32_t count)
{
    const struct rnd_scene *scene = tracer->scene;
    const struct rnd_lights *lights = &scene->lights;
    const struct rnd_paths *paths = &tracer->paths[1];
    const struct rnd_surfaces *s = &tracer->surfaces;
    const struct rnd_alias *alias = tracer->choice->emitters[RND_LIGHT_AREA];
    if (lights->area_count == 0) return;
    for (uint32_t j = 0; j < count; j++) {
        const struct rnd_mesh *mesh = &scene->mesh[s->mesh[j]];
        if (mesh->first_light == UINT32_MAX) continue;
        const uint32_t drawn = rnd_area_at(lights, mesh->first_light + s->triangle[j], s->u[j], s->v[j]);
        const struct rnd_area *area = &lights->area[drawn];
        if (!s->front[j] && !(area->flags & RND_AREA_DOUBLE)) continue;
        const struct rnd_v3 direction = rnd_get(&paths->direction, j);
        float weight = 1.0f;
        if (paths->pdf[j] > 0.0f && lights->has[RND_LIGHT_AREA])
            weight = rnd_power_heuristic(
                paths->pdf[j], tracer->choice->group[RND_LIGHT_AREA] *
                                   rnd_area_pdf(area, alias->probability[drawn], direction, s->distance[j]));
        const struct rnd_v3 radiance = rnd_v3_scale(rnd_area_emission(scene, area, s->u[j], s->v[j]), weight);
        rnd_add_radiance(tracer, paths->id[j], rnd_v3_mul(radiance, rnd_get(&paths->throughput, j)));
    }
}
