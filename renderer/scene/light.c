/* Lights: their tables at load, and drawing from them. The environment's own part is env.c. */
#include "scene/light.h"
#include "scene/scene.h"

#include <float.h>
#include <stdio.h>
#include <stdlib.h>

/* --- sun --- */

void rnd_sun_init(struct rnd_sun *sun, const float options[4])
{
    float towards[3];
    rnd_direction(glm_rad(options[0]), glm_rad(options[1]), towards);
    sun->direction = rnd_v3(towards[0], towards[1], towards[2]);
    /* A disc that is no wider than the steps between directions is a point. */
    const double radius = (double)options[3] * 0.5 * M_PI / 180.0, sine = sin(radius);
    const bool disc = radius > 1e-6;
    sun->drop = disc ? rnd_drop_of(radius) : 0.0f;
    const float value = disc ? (float)((double)options[2] / (M_PI * sine * sine)) : options[2];
    sun->radiance = rnd_v3(value, value, value);
}

/* --- tables --- */

/* Texture of an emissive triangle at barycentric (u, v); bilinear in its finest level. */
static struct rnd_v3 emission_texture(const struct rnd_scene *scene, const struct rnd_area *area, float u,
                                      float v)
{
    const struct rnd_mesh *mesh = &scene->mesh[area->mesh];
    const struct rnd_map *map = &scene->material[mesh->material].map[RND_MAP_EMISSION];
    float place[2];
    rnd_map_uv(map, mesh, mesh->index[area->triangle], u, v, place);
    const struct rnd_texel t =
        rnd_texture_at(&scene->texture[map->texture], map->wrap, map->nearest, place[0], place[1]);
    return rnd_v3(t.r, t.g, t.b);
}

struct rnd_v3 rnd_area_emission(const struct rnd_scene *scene, const struct rnd_area *area, float u, float v)
{
    if (!(area->flags & RND_AREA_TEXTURED)) return area->emission;
    return rnd_v3_mul(area->emission, emission_texture(scene, area, u, v));
}

struct rnd_v3 rnd_area_gives(const struct rnd_scene *scene, const struct rnd_area *area, float s, float t)
{
    float u, v;
    rnd_area_place(area, s, t, &u, &v);
    const struct rnd_v3 emission = rnd_area_emission(scene, area, u, v);
    if (!(area->flags & RND_AREA_COVERED)) return emission;
    return rnd_v3_scale(emission, rnd_coverage(scene, area->mesh, area->triangle, u, v));
}

/* A coordinate of a thousand steps, as ten bits with two zeros before each. */
static uint32_t spread(float coordinate)
{
    uint32_t bits = (uint32_t)fminf(fmaxf(coordinate, 0.0f), 1023.0f);
    bits = (bits | bits << 16) & 0x030000ffu;
    bits = (bits | bits << 8) & 0x0300f00fu;
    bits = (bits | bits << 4) & 0x030c30c3u;
    return (bits | bits << 2) & 0x09249249u;
}

struct place {
    uint32_t code, lamp;
};

static int by_code(const void *a, const void *b)
{
    const struct place *x = a, *y = b;
    return x->code != y->code ? (x->code > y->code) - (x->code < y->code)
                              : (x->lamp > y->lamp) - (x->lamp < y->lamp);
}

/* Along a curve that keeps near what is near (Morton 1966), parts of as many lamps and as much power. */
static void divide(struct place *place, const vec3s *position, uint32_t count, struct rnd_lamps *lamps)
{
    vec3s low = glms_vec3_fill(INFINITY), high = glms_vec3_fill(-INFINITY);
    for (uint32_t i = 0; i < count; i++) {
        low = glms_vec3_minv(low, position[i]);
        high = glms_vec3_maxv(high, position[i]);
    }
    const float scale = 1023.0f / fmaxf(glms_vec3_max(glms_vec3_sub(high, low)), FLT_MIN);
    for (uint32_t i = 0; i < count; i++) {
        const vec3s p = glms_vec3_scale(glms_vec3_sub(position[i], low), scale);
        place[i] = (struct place){spread(p.x) | spread(p.y) << 1 | spread(p.z) << 2, i};
    }
    qsort(place, count, sizeof *place, by_code);
    double before = 0.0;
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t lamp = place[i].lamp, part = (uint32_t)(before * RND_LIGHT_PARTS);
        lamps->part[lamp] = (uint16_t)(part < RND_LIGHT_PARTS ? part : RND_LIGHT_PARTS - 1);
        before += 0.5 * ((double)lamps->by_power.probability[lamp] + 1.0 / count);
    }
}

/* False if memory is short. */
static bool build_lamps(struct rnd_lamps *lamps, const vec3s *position, const float *power, uint32_t count)
{
    struct place *place = malloc(count * sizeof *place);
    lamps->part = malloc(count * sizeof *lamps->part);
    const bool ok = place && lamps->part && rnd_alias_init(&lamps->by_power, power, count);
    if (ok) divide(place, position, count, lamps);
    free(place);
    return ok;
}

static bool build_area(struct rnd_scene *scene, double *out_power)
{
    struct rnd_lights *lights = &scene->lights;
    float *weight;
    double sum = 0.0;
    bool ok = rnd_emitters_build(scene, &weight);
    if (!ok || lights->area_count == 0) goto end;
    vec3s *position = malloc(lights->area_count * sizeof *position);
    ok = position != NULL;
    for (uint32_t i = 0; ok && i < lights->area_count; i++) {
        const struct rnd_area *area = &lights->area[i];
        const struct rnd_v3 middle = rnd_v3_muladd(rnd_v3_add(area->e1, area->e2), 1.0f / 3.0f, area->corner);
        position[i] = (vec3s){{middle.x, middle.y, middle.z}};
        sum += (double)weight[i];
    }
    lights->has[RND_LIGHT_AREA] = sum > 0.0;
    if (ok && sum > 0.0 && isfinite(sum))
        ok = build_lamps(&lights->lamps[RND_LIGHT_AREA], position, weight, lights->area_count);
    free(position);
end:
    *out_power = sum;
    free(weight);
    return ok;
}

static bool build_punctual(struct rnd_scene *scene, double *out_power)
{
    struct rnd_lights *lights = &scene->lights;
    if (lights->punctual_count == 0) return true;
    double square = 0.0;
    for (int k = 0; k < 3; k++) square += pow(scene->info.bounds[1][k] - scene->info.bounds[0][k], 2.0);
    const float radius = 0.5f * (float)sqrt(square);
    float *power = malloc(lights->punctual_count * sizeof *power), sum = 0.0f;
    vec3s *position = malloc(lights->punctual_count * sizeof *position);
    bool ok = power && position;
    for (uint32_t i = 0; ok && i < lights->punctual_count; i++) {
        const struct rnd_punctual *light = &lights->punctual[i];
        const float reach = light->kind == RND_DIRECTIONAL ? radius * radius : 4.0f;
        sum += power[i] = rnd_v3_luminance(light->intensity) * reach * (float)M_PI;
        position[i] = (vec3s){{light->position.x, light->position.y, light->position.z}};
    }
    lights->has[RND_LIGHT_PUNCTUAL] = sum > 0.0f;
    *out_power = sum;
    if (ok && sum > 0.0f && isfinite(sum))
        ok = build_lamps(&lights->lamps[RND_LIGHT_PUNCTUAL], position, power, lights->punctual_count);
    free(power);
    free(position);
    return ok;
}

/* Is there a surface that an eye sees without a light: an unlit one, or one that emits? */
static bool shows_itself(const struct rnd_scene *scene)
{
    for (uint32_t m = 0; m < scene->mesh_count; m++) {
        const struct rnd_material *material = &scene->material[scene->mesh[m].material];
        if (material->unlit || rnd_emits(material)) return true;
    }
    return false;
}

bool rnd_lights_build(struct rnd_scene *scene, const char *path, char out_error[RND_ERROR_SIZE])
{
    struct rnd_lights *lights = &scene->lights;
    double area = 0.0, punctual = 0.0;
    if (!build_area(scene, &area) || !build_punctual(scene, &punctual)) {
        snprintf(out_error, RND_ERROR_SIZE, "%.200s: not enough memory for its lights", path);
        return false;
    }
    if (!isfinite(area + punctual + (lights->sun ? lights->sun->radiance.x : 0.0f))) {
        snprintf(out_error, RND_ERROR_SIZE, "%.200s: its lights are too bright: their power is not finite",
                 path);
        return false;
    }
    lights->has[RND_LIGHT_ENV] = lights->env != NULL;
    lights->has[RND_LIGHT_SUN] = lights->sun && rnd_v3_luminance(lights->sun->radiance) > 0.0f;
    for (int i = 0; i < RND_LIGHT_GROUPS; i++) lights->any |= lights->has[i];
    if (lights->any || shows_itself(scene)) return true;
    snprintf(
        out_error, RND_ERROR_SIZE,
        "%.200s: nothing in the scene gives light: expected an emissive material, a light, --env or --sun",
        path);
    return false;
}

void rnd_lights_finish(struct rnd_lights *lights)
{
    if (lights->env) {
        free(lights->env->texel);
        free(lights->env->entry);
    }
    free(lights->env);
    free(lights->sun);
    free(lights->area);
    free(lights->punctual);
    for (int g = 0; g < RND_LIGHT_GROUPS; g++) {
        rnd_alias_finish(&lights->lamps[g].by_power);
        free(lights->lamps[g].part);
    }
}

void rnd_light_choose_evenly(const struct rnd_lights *lights, struct rnd_light_choice *choice)
{
    float groups = 0.0f;
    for (int g = 0; g < RND_LIGHT_GROUPS; g++) groups += lights->has[g];
    for (int g = 0; g < RND_LIGHT_GROUPS; g++) {
        choice->group[g] = lights->has[g] ? 1.0f / groups : 0.0f;
        choice->lamps[g] = &lights->lamps[g].by_power;
    }
    if (lights->env) choice->env = lights->env->by_weight;
}

void rnd_light_choice_finish(struct rnd_light_choice *choice)
{
    for (int g = 0; g < RND_LIGHT_GROUPS; g++) rnd_alias_finish(&choice->own[g]);
}

/* --- drawing --- */

static bool draw_area(const struct rnd_scene *scene, const struct rnd_alias *alias, struct rnd_v3 point,
                      const float u[4], struct rnd_light_sample *out)
{
    const uint32_t i = rnd_alias_draw(alias, u[1], u[0]);
    const struct rnd_area *area = &scene->lights.area[i];
    float s, t;
    out->part = scene->lights.lamps[RND_LIGHT_AREA].part[i];
    out->pdf = rnd_area_draw(area, alias->probability[i], point, u[2], u[3], &out->direction, &out->distance,
                             &s, &t);
    out->delta = false;
    if (!(out->pdf > 0.0f)) return false;
    out->radiance = rnd_area_gives(scene, area, s, t);
    return true;
}

static bool draw_env(const struct rnd_env *env, const struct rnd_env_choice *choice, const float u[4],
                     struct rnd_light_sample *out)
{
    float part, s, t;
    uint32_t region;
    const uint32_t place = rnd_env_place(env, choice, u[1], u[0], &region, &part);
    out->direction = rnd_env_direction(env, rnd_env_texel_of(env, region, place, part), u[2], u[3], &s, &t);
    out->distance = INFINITY;
    out->radiance = rnd_env_radiance(env, out->direction, &out->part, &out->pdf);
    out->pdf *= choice->factor[out->part];
    out->delta = false;
    return out->pdf > 0.0f;
}

static bool draw_sun(const struct rnd_lights *lights, const float u[4], struct rnd_light_sample *out)
{
    const struct rnd_sun *sun = lights->sun;
    out->distance = INFINITY;
    out->radiance = sun->radiance;
    out->delta = !(sun->drop > 0.0f);
    out->direction = sun->direction;
    out->part = 0;
    out->pdf = 1.0f;
    if (out->delta) return true;
    const struct rnd_v3_frame frame = rnd_v3_frame(sun->direction);
    out->direction = rnd_sun_draw(sun, &frame, u[2], u[3]);
    out->pdf = rnd_sun_pdf(sun);
    return true;
}

static bool draw_punctual(const struct rnd_lights *lights, const struct rnd_alias *alias, struct rnd_v3 point,
                          const float u[4], struct rnd_light_sample *out)
{
    const uint32_t i = rnd_alias_draw(alias, u[1], u[0]);
    const struct rnd_punctual *light = &lights->punctual[i];
    out->part = lights->lamps[RND_LIGHT_PUNCTUAL].part[i];
    out->pdf = alias->probability[i];
    out->delta = true;
    out->radiance = light->intensity;
    if (light->kind == RND_DIRECTIONAL) {
        out->direction = rnd_v3_scale(light->direction, -1.0f);
        out->distance = INFINITY;
        return true;
    }
    const struct rnd_v3 to = rnd_v3_sub(light->position, point);
    const float square = rnd_v3_dot(to, to);
    if (!(square > 0.0f)) return false;
    out->distance = sqrtf(square);
    out->direction = rnd_v3_scale(to, 1.0f / out->distance);
    float falloff = 1.0f / square;
    if (light->kind ==
        RND_SPOT) { /* KHR_lights_punctual: squared linear ramp of the cosine between the cones */
        const float drop = rnd_drop(rnd_v3_scale(out->direction, -1.0f), light->direction);
        const float span = fmaxf(light->drop_outer - light->drop_inner, FLT_MIN);
        const float ramp = fmaxf(0.0f, fminf(1.0f, (light->drop_outer - drop) / span));
        falloff *= ramp * ramp;
    }
    out->radiance = rnd_v3_scale(light->intensity, falloff);
    return falloff > 0.0f;
}

bool rnd_light_draw(const struct rnd_scene *scene, const struct rnd_light_choice *choice, int group,
                    struct rnd_v3 point, const float u[4], struct rnd_light_sample *out)
{
    const struct rnd_lights *lights = &scene->lights;
    switch (group) {
    case RND_LIGHT_AREA:
        return draw_area(scene, choice->lamps[group], point, u, out);
    case RND_LIGHT_ENV:
        return draw_env(lights->env, &choice->env, u, out);
    case RND_LIGHT_SUN:
        return draw_sun(lights, u, out);
    default:
        return draw_punctual(lights, choice->lamps[group], point, u, out);
    }
}
