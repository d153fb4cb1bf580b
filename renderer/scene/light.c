/* Lights: their tables at load, and drawing from them. The environment's own part is env.c. */
#include "scene/light.h"
#include "scene/scene.h"

#include <stdio.h>
#include <stdlib.h>

/* --- sun --- */

void rnd_sun_init(struct rnd_sun *sun, const float options[4])
{
    float towards[3];
    rnd_direction(glm_rad(options[0]), glm_rad(options[1]), towards);
    sun->direction = rnd_v3(towards[0], towards[1], towards[2]);
    sun->cos_radius = cosf(glm_rad(options[3]) * 0.5f);
    /* The cosine of so small a radius is rounded, to 1 below 0.03 degrees: the radiance is that of the disc
     * as it then is, so that the irradiance is as asked for. */
    const float cap = rnd_sun_cap(sun), sin2 = cap * (2.0f - cap);
    const float value = cap > 0.0f ? options[2] / ((float)M_PI * sin2) : options[2];
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
        rnd_texture_bilinear(&scene->texture[map->texture], map->wrap, place[0], place[1]);
    return rnd_v3(t.r, t.g, t.b);
}

struct rnd_v3 rnd_area_emission(const struct rnd_scene *scene, const struct rnd_area *area, float u, float v)
{
    if (!(area->flags & RND_AREA_TEXTURED)) return area->emission;
    return rnd_v3_mul(area->emission, emission_texture(scene, area, u, v));
}

static float area_of(const struct rnd_area *area)
{
    const struct rnd_v3 twice = rnd_v3_cross(area->e1, area->e2);
    return 0.5f * sqrtf(rnd_v3_dot(twice, twice));
}

/* Power of an emissive triangle; its texture is looked at in seven places, which a drawn point need not be.
 */
static float power_of(const struct rnd_scene *scene, const struct rnd_area *area)
{
    static const float place[7][2] = {{1 / 3.f, 1 / 3.f}, {0.05f, 0.05f}, {0.9f, 0.05f}, {0.05f, 0.9f},
                                      {0.45f, 0.05f},     {0.05f, 0.45f}, {0.45f, 0.45f}};
    float sum = 0.0f;
    for (int i = 0; i < 7; i++)
        sum += rnd_v3_luminance(rnd_area_emission(scene, area, place[i][0], place[i][1])) / 7.0f;
    /* A textured light may be dark in all seven places and bright between: it keeps some chance. */
    if (area->flags & RND_AREA_TEXTURED) sum += 0.01f * rnd_v3_luminance(area->emission);
    return sum * area_of(area) * (float)M_PI * (area->flags & RND_AREA_DOUBLE ? 2 : 1);
}

static bool emits(const struct rnd_material *material)
{
    return rnd_luminance(material->emission.raw) > 0.0f && !material->unlit;
}

static struct rnd_area make_area(const struct rnd_scene *scene, uint32_t m, uint32_t triangle)
{
    const struct rnd_mesh *mesh = &scene->mesh[m];
    const struct rnd_material *material = &scene->material[mesh->material];
    struct rnd_v3 p[3];
    for (int k = 0; k < 3; k++) {
        const float *from = mesh->position + 3 * (size_t)mesh->index[triangle][k];
        p[k] = rnd_v3(from[0], from[1], from[2]);
    }
    return (struct rnd_area){.corner = p[0],
                             .e1 = rnd_v3_sub(p[1], p[0]),
                             .e2 = rnd_v3_sub(p[2], p[0]),
                             .emission =
                                 rnd_v3(material->emission.x, material->emission.y, material->emission.z),
                             .mesh = m,
                             .triangle = triangle,
                             .flags = (material->map[RND_MAP_EMISSION].texture >= 0 ? RND_AREA_TEXTURED : 0) |
                                      (material->double_sided ? RND_AREA_DOUBLE : 0)};
}

static bool build_area(struct rnd_scene *scene, double *out_power)
{
    struct rnd_lights *lights = &scene->lights;
    uint64_t count = 0;
    double sum = 0.0;
    for (uint32_t m = 0; m < scene->mesh_count; m++)
        if (emits(&scene->material[scene->mesh[m].material])) count += scene->mesh[m].triangles;
    scene->info.emissive_triangles = count;
    if (count == 0) return true;

    lights->area = aligned_alloc(64, count * sizeof *lights->area);
    float *power = malloc(count * sizeof *power);
    bool ok = lights->area && power;
    for (uint32_t m = 0; ok && m < scene->mesh_count; m++) {
        struct rnd_mesh *mesh = &scene->mesh[m];
        if (!emits(&scene->material[mesh->material])) continue;
        mesh->first_light = lights->area_count;
        for (uint32_t t = 0; t < mesh->triangles; t++) {
            struct rnd_area *area = &lights->area[lights->area_count];
            *area = make_area(scene, m, t);
            lights->area_textured |= (area->flags & RND_AREA_TEXTURED) != 0;
            power[lights->area_count] = power_of(scene, area);
            sum += power[lights->area_count++];
        }
    }
    lights->has[RND_LIGHT_AREA] = sum > 0.0;
    *out_power = sum;
    if (ok && sum > 0.0 && isfinite(sum)) {
        ok = rnd_alias_init(&lights->area_alias, power, lights->area_count);
        for (uint32_t i = 0; ok && i < lights->area_count; i++)
            lights->area[i].probability = lights->area_alias.probability[i];
    }
    free(power);
    return ok;
}

static bool build_punctual(struct rnd_scene *scene, double *out_power)
{
    struct rnd_lights *lights = &scene->lights;
    if (lights->punctual_count == 0) return true;
    const float radius =
        0.5f * glms_vec3_distance(rnd_vec(scene->info.bounds[0]), rnd_vec(scene->info.bounds[1]));
    float *power = malloc(lights->punctual_count * sizeof *power), sum = 0.0f;
    if (!power) return false;
    for (uint32_t i = 0; i < lights->punctual_count; i++) {
        const struct rnd_punctual *light = &lights->punctual[i];
        const float reach = light->kind == RND_DIRECTIONAL ? radius * radius : 4.0f;
        sum += power[i] = rnd_v3_luminance(light->intensity) * reach * (float)M_PI;
    }
    lights->has[RND_LIGHT_PUNCTUAL] = sum > 0.0f;
    *out_power = sum;
    const bool ok = !(sum > 0.0f) || rnd_alias_init(&lights->punctual_alias, power, lights->punctual_count);
    free(power);
    return ok;
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
    for (int i = 0; i < RND_LIGHT_GROUPS; i++)
        if (lights->has[i]) return true;
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
    rnd_alias_finish(&lights->area_alias);
    free(lights->punctual);
    rnd_alias_finish(&lights->punctual_alias);
}

/* --- drawing --- */

static bool draw_area(const struct rnd_scene *scene, struct rnd_v3 point, const float u[4],
                      struct rnd_light_sample *out)
{
    const struct rnd_lights *lights = &scene->lights;
    const struct rnd_area *area = &lights->area[rnd_alias_draw(&lights->area_alias, u[1], u[0])];
    float s, t;
    out->pdf = rnd_area_draw(area, point, u[2], u[3], &out->direction, &out->distance, &s, &t);
    out->delta = false;
    if (!(out->pdf > 0.0f)) return false;
    out->radiance = rnd_area_emission(scene, area, s, t);
    return true;
}

static bool draw_env(const struct rnd_lights *lights, const float u[4], struct rnd_light_sample *out)
{
    const struct rnd_env *env = lights->env;
    float part, s, t;
    uint32_t region;
    const uint32_t place = rnd_env_place(env, &env->by_weight, u[1], u[0], &region, &part);
    out->direction = rnd_env_direction(env, rnd_env_texel_of(env, region, place, part), u[2], u[3], &s, &t);
    out->distance = INFINITY;
    out->radiance = rnd_env_radiance(env, out->direction, &region, &out->pdf);
    out->delta = false;
    return out->pdf > 0.0f;
}

static bool draw_sun(const struct rnd_lights *lights, const float u[4], struct rnd_light_sample *out)
{
    const struct rnd_sun *sun = lights->sun;
    out->distance = INFINITY;
    out->radiance = sun->radiance;
    out->delta = !(sun->cos_radius < 1.0f);
    out->direction = sun->direction;
    out->pdf = 1.0f;
    if (out->delta) return true;
    const struct rnd_v3_frame frame = rnd_v3_frame(sun->direction);
    out->direction = rnd_sun_draw(sun, &frame, u[2], u[3]);
    out->pdf = rnd_sun_pdf(sun);
    return true;
}

static bool draw_punctual(const struct rnd_lights *lights, struct rnd_v3 point, const float u[4],
                          struct rnd_light_sample *out)
{
    const uint32_t i = rnd_alias_draw(&lights->punctual_alias, u[1], u[0]);
    const struct rnd_punctual *light = &lights->punctual[i];
    out->pdf = lights->punctual_alias.probability[i];
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
        const float c = -rnd_v3_dot(out->direction, light->direction);
        const float span = fmaxf(light->cos_inner - light->cos_outer, 1e-4f);
        const float ramp = fmaxf(0.0f, fminf(1.0f, (c - light->cos_outer) / span));
        falloff *= ramp * ramp;
    }
    out->radiance = rnd_v3_scale(light->intensity, falloff);
    return falloff > 0.0f;
}

bool rnd_light_draw(const struct rnd_scene *scene, int group, struct rnd_v3 point, const float u[4],
                    struct rnd_light_sample *out)
{
    switch (group) {
    case RND_LIGHT_AREA:
        return draw_area(scene, point, u, out);
    case RND_LIGHT_ENV:
        return draw_env(&scene->lights, u, out);
    case RND_LIGHT_SUN:
        return draw_sun(&scene->lights, u, out);
    default:
        return draw_punctual(&scene->lights, point, u, out);
    }
}
