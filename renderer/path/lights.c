/* Next-event estimation, first half: a light is chosen for every point, from groups as often as the survey
 * found worth while, and within a group by power. */
#include "path/wave.h"

/* Sort the points into the groups' lists; what is left of the first number chooses again within the group. */
static void choose_groups(struct rnd_tracer *tracer, uint32_t count, uint32_t number[RND_LIGHT_GROUPS])
{
    const float *choose = tracer->scene->lights.choose;
    int only = -1;
    uint32_t first = RND_LIGHT_GROUPS - 1;
    for (int g = RND_LIGHT_GROUPS - 1; g >= 0; g--) {
        number[g] = 0;
        if (choose[g] > 0.0f) first = (uint32_t)g;
        if (choose[g] >= 1.0f) only = g;
    }
    if (only >= 0) {
        for (uint32_t j = 0; j < count; j++) tracer->list[only][j] = j;
        number[only] = count;
        return;
    }
    /* Where each group begins in [0, 1), and one over its length. What has no length begins where no number
     * is. */
    float begin[RND_LIGHT_GROUPS], stretch[RND_LIGHT_GROUPS], sum = 0.0f;
    for (int g = 0; g < RND_LIGHT_GROUPS; g++) {
        begin[g] = choose[g] > 0.0f ? sum : 2.0f;
        stretch[g] = choose[g] > 0.0f ? 1.0f / choose[g] : 0.0f;
        sum += choose[g];
    }
    float *u = tracer->number[0];
    uint32_t *group = tracer->order;
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
        group[j] = g;
        u[j] = rnd_smaller((u[j] - from) * by, 0x1.fffffep-1f);
    }
    for (uint32_t j = 0; j < count; j++) {
        const uint32_t g = group[j];
        tracer->list[g][number[g]++] = j;
    }
}

/* Draw entries of an alias table for the points of a list, by their first two numbers. What one needs of
 * memory is asked for while others are at it: the table, and then what its entries stand for, size bytes each
 * from first on. */
static void draw_entries(struct rnd_tracer *tracer, const struct rnd_alias *alias, const uint32_t *list,
                         uint32_t count, const void *first, size_t size, uint32_t *out_entry)
{
    float(*u)[RND_WAVE] = tracer->number;
    for (uint32_t k = 0; k < count; k++) {
        float part;
        out_entry[k] = rnd_alias_place(alias, u[1][list[k]], u[0][list[k]], &part);
        u[0][list[k]] = part;
        __builtin_prefetch(&alias->entry[out_entry[k]]);
    }
    for (uint32_t k = 0; k < count; k++) {
        const struct rnd_alias_entry *entry = &alias->entry[out_entry[k]];
        if (!(u[0][list[k]] < entry->keep)) out_entry[k] = entry->other;
        __builtin_prefetch((const char *)first + out_entry[k] * size);
    }
}

static void choose_env(struct rnd_tracer *tracer, const uint32_t *list, uint32_t count)
{
    const struct rnd_lights *lights = &tracer->scene->lights;
    const struct rnd_env *env = lights->env;
    const struct rnd_paths *paths = &tracer->paths[1];
    struct rnd_light_choices *to = &tracer->lights;
    float(*u)[RND_WAVE] = tracer->number;
    uint32_t *texel = tracer->order;
    draw_entries(tracer, &env->alias, list, count, env->texel, sizeof *env->texel, texel);
    const float choose = lights->choose[RND_LIGHT_ENV];
    const uint32_t which = 128 + (uint32_t)tracer->depth;
#pragma GCC ivdep
    for (size_t k = 0; k < count; k++) {
        const uint32_t j = list[k];
        float s, t, a, b;
        const struct rnd_v3 direction = rnd_env_direction(env, texel[k], u[2][j], u[3][j], &s, &t);
        rnd_dither(paths->seed[j], paths->index[j], which, &a, &b);
        const float *radiance = env->texel[rnd_env_texel(env, s, t, a, b)];
        const float level = sqrtf(direction.x * direction.x + direction.z * direction.z);
        rnd_put(&to->direction, j, direction);
        rnd_put(&to->radiance, j, rnd_v3(radiance[0], radiance[1], radiance[2]));
        to->pdf[j] = choose * env->texel[texel[k]][3] / rnd_larger(level, 1e-6f);
        to->distance[j] = INFINITY;
        to->delta[j] = 0;
    }
}

static void choose_sun(struct rnd_tracer *tracer, const uint32_t *list, uint32_t count)
{
    const struct rnd_lights *lights = &tracer->scene->lights;
    const struct rnd_sun *sun = lights->sun;
    struct rnd_light_choices *to = &tracer->lights;
    const uint32_t delta = !(sun->cos_radius < 1.0f);
    const float pdf = lights->choose[RND_LIGHT_SUN] * (delta ? 1.0f : rnd_sun_pdf(sun));
    const struct rnd_v3_frame frame = rnd_v3_frame(sun->direction);
    for (uint32_t k = 0; k < count; k++) {
        const uint32_t j = list[k];
        rnd_put(&to->direction, j, rnd_sun_draw(sun, &frame, tracer->number[2][j], tracer->number[3][j]));
        rnd_put(&to->radiance, j, sun->radiance);
        to->pdf[j] = pdf;
        to->distance[j] = INFINITY;
        to->delta[j] = delta;
    }
}

static void choose_area(struct rnd_tracer *tracer, const uint32_t *list, uint32_t count)
{
    const struct rnd_lights *lights = &tracer->scene->lights;
    struct rnd_light_choices *to = &tracer->lights;
    uint32_t *entry = tracer->order;
    draw_entries(tracer, &lights->area_alias, list, count, lights->area, sizeof *lights->area, entry);
    float *at_s = tracer->look_x, *at_t = tracer->look_y; /* not in use now */
#pragma GCC ivdep
    for (size_t k = 0; k < count; k++) {
        const uint32_t j = list[k];
        const struct rnd_area *area = &lights->area[entry[k]];
        struct rnd_v3 direction;
        to->pdf[j] = rnd_area_draw(lights, area, rnd_get(&tracer->paths[1].origin, j), tracer->number[2][j],
                                   tracer->number[3][j], &direction, &to->distance[j], &at_s[k], &at_t[k]);
        to->delta[j] = 0;
        rnd_put(&to->direction, j, direction);
        rnd_put(&to->radiance, j, area->emission);
    }
    for (uint32_t k = 0; lights->area_textured && k < count; k++) {
        const uint32_t j = list[k];
        const struct rnd_area *area = &lights->area[entry[k]];
        if ((area->flags & RND_AREA_TEXTURED) && to->pdf[j] > 0.0f)
            rnd_put(&to->radiance, j, rnd_area_emission(tracer->scene, area, at_s[k], at_t[k]));
    }
}

static void choose_punctual(struct rnd_tracer *tracer, const uint32_t *list, uint32_t count)
{
    struct rnd_light_choices *to = &tracer->lights;
    float(*u)[RND_WAVE] = tracer->number;
    for (uint32_t k = 0; k < count; k++) {
        const uint32_t j = list[k];
        const float number[4] = {u[0][j], u[1][j], u[2][j], u[3][j]};
        struct rnd_light_sample light;
        to->pdf[j] = 0.0f;
        if (!rnd_light_draw(tracer->scene, RND_LIGHT_PUNCTUAL, rnd_get(&tracer->paths[1].origin, j), number,
                            &light))
            continue;
        rnd_put(&to->direction, j, light.direction);
        rnd_put(&to->radiance, j, light.radiance);
        to->pdf[j] = light.pdf;
        to->distance[j] = light.distance;
        to->delta[j] = light.delta;
    }
}

void ISA(rnd_choose_lights)(struct rnd_tracer *tracer, uint32_t count)
{
    uint32_t number[RND_LIGHT_GROUPS];
    rnd_draw_numbers(tracer, RND_DIM_LIGHT, 0, count, tracer->number[0], tracer->number[1]);
    rnd_draw_numbers(tracer, RND_DIM_LIGHT_PLACE, 0, count, tracer->number[2], tracer->number[3]);
    choose_groups(tracer, count, number);
    if (number[RND_LIGHT_AREA]) choose_area(tracer, tracer->list[RND_LIGHT_AREA], number[RND_LIGHT_AREA]);
    if (number[RND_LIGHT_ENV]) choose_env(tracer, tracer->list[RND_LIGHT_ENV], number[RND_LIGHT_ENV]);
    if (number[RND_LIGHT_SUN]) choose_sun(tracer, tracer->list[RND_LIGHT_SUN], number[RND_LIGHT_SUN]);
    if (number[RND_LIGHT_PUNCTUAL])
        choose_punctual(tracer, tracer->list[RND_LIGHT_PUNCTUAL], number[RND_LIGHT_PUNCTUAL]);
}
