/* The environment map: its radiance in a direction, and drawing directions from it. */
#ifndef FOVEAD_RENDERER_ENV_H
#define FOVEAD_RENDERER_ENV_H

#include "light/choice.h"
#include "math/uv.h"
#include "scene/scene.h"

/* One of the four texels around (u, v), chosen by two numbers r and s in [0,1): the mean over the numbers is
 * the bilinear interpolation. With 1/2 and 1/2 it is the texel that contains (u, v). */
RND_INLINE uint32_t rnd_env_texel(const struct rnd_env *env, float u, float v, float r, float s)
{
    const float x = u * (float)env->width - 0.5f + r, y = v * (float)env->height - 0.5f + s;
    int32_t ix = (int32_t)floorf(x), iy = (int32_t)floorf(y);
    ix = ix < 0 ? ix + env->width : ix;
    ix = ix >= env->width ? ix - env->width : ix;
    iy = iy < 0 ? 0 : iy;
    iy = iy >= env->height ? env->height - 1 : iy;
    return (uint32_t)(iy * env->width + ix);
}

/* The region of the texel that contains (u, v): a region has whole texels. */
RND_INLINE uint32_t rnd_env_region(const struct rnd_env *env, float u, float v)
{
    const float x = rnd_smaller(floorf(u * (float)env->width), (float)(env->width - 1)),
                y = rnd_smaller(floorf(v * (float)env->height), (float)(env->height - 1));
    const int32_t column = (int32_t)((x + 0.5f) * (RND_ENV_COLUMNS / (float)env->width)),
                  row = (int32_t)((y + 0.5f) * (RND_ENV_ROWS / (float)env->height));
    return (uint32_t)(row * RND_ENV_COLUMNS + column);
}

/* Draw a region and one of its entries, by a number in [0,1): u, with its bits below 2^-24 in v. Then
 * rnd_env_texel_of() says which of the entry's two texels is drawn. */
RND_INLINE uint32_t rnd_env_place(const struct rnd_env *env, const struct rnd_env_choice *choice, float u,
                                  float v, uint32_t *out_region, float *out_part)
{
    const double place = ((double)u + (double)v * 0x1p-24) * RND_ENV_REGIONS;
    const uint32_t drawn = (uint32_t)place < RND_ENV_REGIONS ? (uint32_t)place : RND_ENV_REGIONS - 1;
    const struct rnd_alias_entry *entry = &choice->entry[drawn];
    const double part = place - drawn, keep = (double)entry->keep;
    const bool own = part < keep;
    const uint32_t number = *out_region = own ? drawn : entry->other;
    const struct rnd_env_region *region = &env->region[number];
    const double rest = (own ? part / keep : (part - keep) / (1.0 - keep)) * region->texels;
    const uint32_t i = rest < region->texels ? (uint32_t)rest : region->texels - 1;
    *out_part = (float)(rest - i);
    return region->first + i;
}

RND_INLINE uint32_t rnd_env_texel_of(const struct rnd_env *env, uint32_t region, uint32_t place, float part)
{
    const struct rnd_env_region *r = &env->region[region];
    const uint32_t i = place - r->first, width = (uint32_t)r->width;
    if (!(part < env->entry[place].keep)) return env->entry[place].other;
    return ((uint32_t)r->y + i / width) * (uint32_t)env->width + (uint32_t)r->x + i % width;
}

RND_INLINE void rnd_env_to_uv(const struct rnd_env *env, struct rnd_v3 direction, float *out_u, float *out_v)
{
    rnd_v3_to_uv(direction, out_u, out_v);
    const float u = *out_u + env->turn;
    *out_u = u - floorf(u);
}

/* The direction of place (r, s) in [0,1) within a texel, and its coordinates (u, v) in the map. */
RND_INLINE struct rnd_v3 rnd_env_direction(const struct rnd_env *env, uint32_t texel, float r, float s,
                                           float *out_u, float *out_v)
{
    /* vectors have no division of integers; this one is exact below 2^31 */
    const int32_t i = (int32_t)texel, row = (int32_t)(((double)i + 0.5) / env->width);
    const float u = ((float)(i - row * env->width) + r) / (float)env->width;
    *out_u = u;
    *out_v = ((float)row + s) / (float)env->height;
    const float turned = u - env->turn;
    return rnd_v3_from_uv(turned - floorf(turned), *out_v);
}

/* Radiance from a direction: of the texel that contains it. *out_region is its region, *out_pdf the density
 * per steradian with which it is drawn by weight. */
struct rnd_v3 rnd_env_radiance(const struct rnd_env *env, struct rnd_v3 direction, uint32_t *out_region,
                               float *out_pdf);

/* Make a choice that draws regions with these probabilities, up to a constant factor: 0 for exactly the
 * regions that have no weight. False if memory is short. */
bool rnd_env_choose(const struct rnd_env *env, const float probability[RND_ENV_REGIONS],
                    struct rnd_env_choice *out);

/* Make the tables of a map whose texels have their radiance, and put into each texel the density with which
 * it is drawn. *out_black: the map gives no light. False if memory is short. */
bool rnd_env_tables(struct rnd_env *env, bool *out_black);

/* rnd_light_kind.build and .draw. */
bool rnd_env_build(struct rnd_scene *scene, double *out_power);
bool rnd_env_light(const struct rnd_scene *scene, const struct rnd_light_choice *choice, struct rnd_v3 point,
                   const float u[4], struct rnd_light_sample *out);

#endif
