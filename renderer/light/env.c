/* The environment map: the weights of its texels, its tables, and drawing from them. */
#include "light/env.h"
#include "math/large_pages.h"

#include <stdlib.h>
#include <string.h>

static const float *texel(const struct rnd_env *env, int x, int y)
{
    const int w = env->width, h = env->height;
    return env->texel[(size_t)(y < 0 ? 0 : y >= h ? h - 1 : y) * w + (x + w) % w];
}

/* A texel's weight: its solid angle times the mean luminance of the texels that its bilinear footprint
 * touches. So every direction that has radiance has a density. */
static float weight_of(const struct rnd_env *env, int x, int y)
{
    float sum = 0.0f;
    for (int dy = -1; dy <= 1; dy++)
        for (int dx = -1; dx <= 1; dx++) sum += rnd_luminance(texel(env, x + dx, y + dy));
    return sum * rnd_row_weight(y, env->height);
}

static uint32_t region_of(const struct rnd_env *env, int x, int y)
{
    return rnd_env_region(env, ((float)x + 0.5f) / (float)env->width, ((float)y + 0.5f) / (float)env->height);
}

/* Tell which texels each region has. A small map leaves some regions empty. */
static void divide(struct rnd_env *env)
{
    for (int y = 0; y < env->height; y++)
        for (int x = 0; x < env->width; x++) {
            struct rnd_env_region *r = &env->region[region_of(env, x, y)];
            if (r->texels++ == 0) r->x = x, r->y = y;
            r->width = x - r->x + 1;
        }
    for (int i = 1; i < RND_ENV_REGIONS; i++)
        env->region[i].first = env->region[i - 1].first + env->region[i - 1].texels;
}

/* Make the table of one region, and put the weight of each of its texels in place of the density. */
static bool make_region(struct rnd_env *env, int number, float *weight, double *out_sum)
{
    const struct rnd_env_region *r = &env->region[number];
    float any = 0.0f;
    for (uint32_t i = 0; i < r->texels; i++) {
        const int x = r->x + (int)i % r->width, y = r->y + (int)i / r->width;
        any += weight[i] = env->texel[(size_t)y * env->width + x][3] = weight_of(env, x, y);
    }
    *out_sum = 0.0;
    if (!(any > 0.0f)) return true;
    struct rnd_alias alias;
    if (!rnd_alias_init(&alias, weight, r->texels)) return false;
    for (uint32_t i = 0; i < r->texels; i++) {
        const uint32_t other = alias.entry[i].other, x = other % r->width, y = other / r->width;
        env->entry[r->first + i] = (struct rnd_alias_entry){
            alias.entry[i].keep, (uint32_t)(r->y + (int)y) * (uint32_t)env->width + (uint32_t)r->x + x};
    }
    *out_sum = alias.sum;
    rnd_alias_finish(&alias);
    return true;
}

bool rnd_env_tables(struct rnd_env *env, bool *out_black)
{
    const size_t count = (size_t)env->width * env->height;
    double sum[RND_ENV_REGIONS], all = 0.0;
    divide(env);
    float *weight = malloc(count * sizeof *weight);
    env->entry = malloc(count * sizeof *env->entry);
    bool ok = weight && env->entry;
    if (!ok) goto end;
    rnd_use_large_pages(env->entry, count * sizeof *env->entry);
    for (int i = 0; ok && i < RND_ENV_REGIONS; i++) {
        ok = make_region(env, i, weight, &sum[i]);
        all += sum[i];
    }
    *out_black = !(all > 0.0);
    if (!ok || *out_black) goto end;
    const double scale = (double)count / (2.0 * M_PI * M_PI) / all; /* beyond a float for the darkest maps */
    for (size_t i = 0; i < count; i++) env->texel[i][3] = (float)((double)env->texel[i][3] * scale);
    for (int i = 0; i < RND_ENV_REGIONS; i++) env->weight[i] = (float)(sum[i] / all);
    ok = rnd_env_choose(env, env->weight, &env->by_weight);
end:
    free(weight);
    return ok;
}

bool rnd_env_choose(const struct rnd_env *env, const float probability[RND_ENV_REGIONS],
                    struct rnd_env_choice *out)
{
    struct rnd_alias alias;
    if (!rnd_alias_init(&alias, probability, RND_ENV_REGIONS)) return false;
    memcpy(out->entry, alias.entry, sizeof out->entry);
    for (int i = 0; i < RND_ENV_REGIONS; i++)
        out->factor[i] = env->weight[i] > 0.0f ? alias.probability[i] / env->weight[i] : 0.0f;
    rnd_alias_finish(&alias);
    return true;
}

struct rnd_v3 rnd_env_radiance(const struct rnd_env *env, struct rnd_v3 direction, uint32_t *out_region,
                               float *out_pdf)
{
    float u, v;
    rnd_env_to_uv(env, direction, &u, &v);
    *out_region = rnd_env_region(env, u, v);
    const float *t = env->texel[rnd_env_texel(env, u, v, 0.5f, 0.5f)];
    *out_pdf = t[3] / fmaxf(sqrtf(direction.x * direction.x + direction.z * direction.z), 1e-6f);
    return rnd_v3(t[0], t[1], t[2]);
}

bool rnd_env_light(const struct rnd_scene *scene, const struct rnd_light_choice *choice, struct rnd_v3 point,
                   const float u[4], struct rnd_light_sample *out)
{
    const struct rnd_env *env = scene->lights.env;
    (void)point;
    float part, s, t;
    uint32_t region;
    const uint32_t place = rnd_env_place(env, &choice->env, u[1], u[0], &region, &part);
    out->direction = rnd_env_direction(env, rnd_env_texel_of(env, region, place, part), u[2], u[3], &s, &t);
    out->distance = INFINITY;
    out->radiance = rnd_env_radiance(env, out->direction, &out->part, &out->pdf);
    out->pdf *= choice->env.factor[out->part];
    out->delta = false;
    return out->pdf > 0.0f;
}

bool rnd_env_build(struct rnd_scene *scene, double *out_power)
{
    *out_power = scene->lights.env ? 1.0 : 0.0; /* a black map is refused when it is read */
    return true;
}
