/* Next-event estimation, first half: every point chooses a light. It chooses a group of lights with the
 * probability that the survey found best, and then a light of that group in the same way. */
#include "path/lights.h"
#include "light/area.h"
#include "light/env.h"
#include "light/sun.h"
#include "light/light.h"

#include <string.h>

/* Sort the points into lists, one for each group, and note each point's group and its place in the list. What
 * is left of the first random number chooses a light within the group. */
static void choose_groups(struct rnd_tracer *tracer, uint32_t count, uint32_t number[RND_LIGHT_GROUPS],
                          uint32_t *restrict out_group, uint32_t *restrict out_rank)
{
    const float *choose = tracer->choice->group;
    /* Where each group begins in [0, 1), and one over the length that it has there. A group without length
     * begins at 1, where no random number is. */
    float begin[RND_LIGHT_GROUPS], stretch[RND_LIGHT_GROUPS], sum = 0.0f;
    uint32_t first = RND_LIGHT_GROUPS;
    for (uint32_t g = 0; g < RND_LIGHT_GROUPS; g++) {
        const bool any = choose[g] > 0.0f;
        if (any && first == RND_LIGHT_GROUPS) first = g;
        begin[g] = any ? sum : 2.0f;
        stretch[g] = any ? 1.0f / choose[g] : 0.0f;
        sum += choose[g];
        number[g] = 0;
    }
    first = first < RND_LIGHT_GROUPS ? first : 0;
    float *u = tracer->number[0];
#pragma GCC ivdep
    for (size_t j = 0; j < count; j++) {
        uint32_t g = first;
        float from = 0.0f, by = stretch[first];
        for (uint32_t k = 1; k < RND_LIGHT_GROUPS; k++) {
            const int beyond = u[j] >= begin[k];
            g = beyond ? k : g;
            from = beyond ? begin[k] : from;
            by = beyond ? stretch[k] : by;
        }
        out_group[j] = g;
        u[j] = rnd_smaller((u[j] - from) * by, 0x1.fffffep-1f);
    }
    for (uint32_t j = 0; j < count; j++) {
        const uint32_t g = out_group[j];
        out_rank[j] = number[g];
        tracer->list[g][number[g]++] = j;
    }
}

/* Draw emissive triangles for the points of a list, by their first two numbers. Each table and triangle is
 * prefetched while other points are worked on. */
static void draw_areas(struct rnd_tracer *tracer, const uint32_t *list, uint32_t count, uint32_t *out_area)
{
    const struct rnd_lights *lights = &tracer->scene->lights;
    const struct rnd_alias *alias = tracer->choice->emitters[RND_LIGHT_AREA];
    float(*u)[RND_WAVE] = tracer->number;
    for (uint32_t k = 0; k < count; k++) {
        float part;
        out_area[k] = rnd_alias_place(alias, u[1][list[k]], u[0][list[k]], &part);
        u[0][list[k]] = part;
        __builtin_prefetch(&alias->entry[out_area[k]]);
    }
    for (uint32_t k = 0; k < count; k++) {
        const struct rnd_alias_entry *entry = &alias->entry[out_area[k]];
        if (!(u[0][list[k]] < entry->keep)) out_area[k] = entry->other;
        __builtin_prefetch(&lights->area[out_area[k]]);
        __builtin_prefetch(&alias->probability[out_area[k]]);
    }
}

/* The same for the environment: draw texels, and the factors on their density. */
static void draw_texels(struct rnd_tracer *tracer, const uint32_t *list, uint32_t count, uint32_t *out_texel,
                        float *out_factor)
{
    const struct rnd_env *env = tracer->scene->lights.env;
    const struct rnd_env_choice *choice = &tracer->choice->env;
    float(*u)[RND_WAVE] = tracer->number;
    uint32_t *region = tracer->scratch.lights.region;
    for (uint32_t k = 0; k < count; k++) {
        float part;
        out_texel[k] = rnd_env_place(env, choice, u[1][list[k]], u[0][list[k]], &region[k], &part);
        u[0][list[k]] = part;
        out_factor[k] = choice->factor[region[k]];
        __builtin_prefetch(&env->entry[out_texel[k]]);
    }
    for (uint32_t k = 0; k < count; k++) {
        out_texel[k] = rnd_env_texel_of(env, region[k], out_texel[k], u[0][list[k]]);
        __builtin_prefetch(env->texel[out_texel[k]]);
    }
}

static void choose_env(struct rnd_tracer *tracer, const uint32_t *list, uint32_t count, uint32_t first)
{
    const struct rnd_lights *lights = &tracer->scene->lights;
    const struct rnd_env *env = lights->env;
    const struct rnd_paths *paths = &tracer->paths[1];
    struct rnd_light_choices *to = &tracer->chosen;
    float(*u)[RND_WAVE] = tracer->number;
    uint32_t *texel = tracer->scratch.lights.drawn, *near = tracer->scratch.lights.near;
    draw_texels(tracer, list, count, texel, &to->pdf[first]);
    const float choose = tracer->choice->group[RND_LIGHT_ENV];
    const uint32_t which = 128 + (uint32_t)tracer->depth;
#pragma GCC ivdep
    for (size_t k = 0; k < count; k++) {
        const uint32_t j = list[k];
        float s, t, a, b;
        const struct rnd_v3 direction = rnd_env_direction(env, texel[k], u[2][j], u[3][j], &s, &t);
        rnd_dither(paths->seed[j], paths->index[j], which, &a, &b);
        near[k] = rnd_env_texel(env, s, t, a, b);
        const float level = sqrtf(direction.x * direction.x + direction.z * direction.z);
        rnd_put(&to->direction, first + k, direction);
        to->pdf[first + k] *= choose / rnd_larger(level, 1e-6f);
        to->distance[first + k] = INFINITY;
        to->delta[first + k] = 0;
    }
    for (uint32_t k = 0; k < count; k++) {
        const float *radiance = env->texel[near[k]];
        rnd_put(&to->radiance, first + k, rnd_v3(radiance[0], radiance[1], radiance[2]));
        to->pdf[first + k] *= env->texel[texel[k]][3];
    }
}

static void choose_sun(struct rnd_tracer *tracer, const uint32_t *list, uint32_t count, uint32_t first)
{
    const struct rnd_lights *lights = &tracer->scene->lights;
    const struct rnd_sun *sun = lights->sun;
    struct rnd_light_choices *to = &tracer->chosen;
    const uint32_t delta = !(sun->drop > 0.0f);
    const float pdf = tracer->choice->group[RND_LIGHT_SUN] * (delta ? 1.0f : rnd_sun_pdf(sun));
    const struct rnd_v3_frame frame = rnd_v3_frame(sun->direction);
    const struct rnd_sun own = *sun; /* a constant, so that the loop has no branch */
#pragma GCC ivdep
    for (size_t k = 0; k < count; k++) {
        const uint32_t j = list[k];
        rnd_put(&to->direction, first + k,
                rnd_sun_draw(&own, &frame, tracer->number[2][j], tracer->number[3][j]));
        rnd_put(&to->radiance, first + k, own.radiance);
        to->pdf[first + k] = pdf;
        to->distance[first + k] = INFINITY;
        to->delta[first + k] = delta;
    }
}

static void choose_area(struct rnd_tracer *tracer, const uint32_t *list, uint32_t count, uint32_t first)
{
    const struct rnd_lights *lights = &tracer->scene->lights;
    struct rnd_light_choices *to = &tracer->chosen;
    struct rnd_areas *areas = &tracer->areas;
    const struct rnd_alias *alias = tracer->choice->emitters[RND_LIGHT_AREA];
    uint32_t *entry = tracer->scratch.lights.drawn;
    draw_areas(tracer, list, count, entry);
    for (uint32_t k = 0; k < count; k++) {
        const struct rnd_area *area = &lights->area[entry[k]];
        rnd_put(&areas->corner, k, area->corner);
        rnd_put(&areas->e1, k, area->e1);
        rnd_put(&areas->e2, k, area->e2);
        rnd_put(&to->radiance, first + k, area->emission);
        areas->probability[k] = alias->probability[entry[k]];
        areas->flags[k] = area->flags;
    }
    const float choose = tracer->choice->group[RND_LIGHT_AREA];
#pragma GCC ivdep
    for (size_t k = 0; k < count; k++) {
        const uint32_t j = list[k];
        const struct rnd_area area = {.corner = rnd_get(&areas->corner, k),
                                      .e1 = rnd_get(&areas->e1, k),
                                      .e2 = rnd_get(&areas->e2, k),
                                      .flags = areas->flags[k]};
        struct rnd_area_point drawn;
        to->pdf[first + k] =
            choose * rnd_area_draw(&area, areas->probability[k], rnd_get(&tracer->paths[1].origin, j),
                                   tracer->number[2][j], tracer->number[3][j], &drawn);
        to->distance[first + k] = drawn.distance;
        to->delta[first + k] = 0;
        rnd_put(&to->direction, first + k, drawn.direction);
        areas->s[k] = drawn.s;
        areas->t[k] = drawn.t;
    }
    for (uint32_t k = 0; lights->area_uneven && k < count; k++) {
        const struct rnd_area *area = &lights->area[entry[k]];
        if ((area->flags & (RND_AREA_TEXTURED | RND_AREA_COVERED)) && to->pdf[first + k] > 0.0f)
            rnd_put(&to->radiance, first + k, rnd_area_gives(tracer->scene, area, areas->s[k], areas->t[k]));
    }
}

static void choose_punctual(struct rnd_tracer *tracer, const uint32_t *list, uint32_t count, uint32_t first)
{
    struct rnd_light_choices *to = &tracer->chosen;
    float(*u)[RND_WAVE] = tracer->number;
    for (uint32_t k = 0; k < count; k++) {
        const uint32_t j = list[k];
        const float number[4] = {u[0][j], u[1][j], u[2][j], u[3][j]};
        struct rnd_light_sample light;
        to->pdf[first + k] = 0.0f;
        if (!rnd_light_draw(tracer->scene, tracer->choice, RND_LIGHT_PUNCTUAL,
                            rnd_get(&tracer->paths[1].origin, j), number, &light))
            continue;
        rnd_put(&to->direction, first + k, light.direction);
        rnd_put(&to->radiance, first + k, light.radiance);
        to->pdf[first + k] = tracer->choice->group[RND_LIGHT_PUNCTUAL] * light.pdf;
        to->distance[first + k] = light.distance;
        to->delta[first + k] = light.delta;
    }
}

/* Put what was drawn back into the order of the points. */
static void arrange(struct rnd_tracer *tracer, uint32_t count, const uint32_t begin[RND_LIGHT_GROUPS],
                    const uint32_t *restrict group, const uint32_t *restrict rank)
{
    const struct rnd_light_choices *from = &tracer->chosen;
    struct rnd_light_choices *to = &tracer->lights;
#pragma GCC ivdep
    for (size_t j = 0; j < count; j++) {
        const uint32_t i = begin[group[j]] + rank[j];
        to->direction.x[j] = from->direction.x[i];
        to->direction.y[j] = from->direction.y[i];
        to->direction.z[j] = from->direction.z[i];
        to->radiance.x[j] = from->radiance.x[i];
        to->radiance.y[j] = from->radiance.y[i];
        to->radiance.z[j] = from->radiance.z[i];
        to->distance[j] = from->distance[i];
        to->pdf[j] = from->pdf[i];
        to->delta[j] = from->delta[i];
    }
}

void ISA(rnd_choose_lights)(struct rnd_tracer *tracer, uint32_t count)
{
    static void (*const choose[RND_LIGHT_GROUPS])(struct rnd_tracer *, const uint32_t *, uint32_t,
                                                  uint32_t) = {
        [RND_LIGHT_AREA] = choose_area,
        [RND_LIGHT_ENV] = choose_env,
        [RND_LIGHT_SUN] = choose_sun,
        [RND_LIGHT_PUNCTUAL] = choose_punctual,
    };
    uint32_t number[RND_LIGHT_GROUPS], begin[RND_LIGHT_GROUPS], *group = tracer->scratch.lights.group,
                                                                *rank = tracer->scratch.lights.rank;
    if (!tracer->scene->lights.any) { /* a scene of unlit surfaces, or of emitters without coverage */
        memset(tracer->lights.pdf, 0, count * sizeof *tracer->lights.pdf);
        return;
    }
    rnd_draw_numbers(tracer, RND_DIM_LIGHT, 0, count, tracer->number[0], tracer->number[1]);
    rnd_draw_numbers(tracer, RND_DIM_LIGHT_PLACE, 0, count, tracer->number[2], tracer->number[3]);
    choose_groups(tracer, count, number, group, rank);
    for (uint32_t g = 0, sum = 0; g < RND_LIGHT_GROUPS; g++) {
        begin[g] = sum;
        if (number[g] > 0) choose[g](tracer, tracer->list[g], number[g], sum);
        sum += number[g];
    }
    arrange(tracer, count, begin, group, rank);
}
