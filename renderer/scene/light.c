/* Lights: emissive triangles, environment, sun, punctual lights; drawn one at a time for next-event
 * estimation.
 *
 * A shading point chooses a group, then a light within the group by power.
 */
#include "scene/scene.h"

#include <stdio.h>
#include <stdlib.h>

/* --- environment --- */

static vec3s env_texel(const struct rnd_env *env, int x, int y)
{
    const int w = env->pixels.width, h = env->pixels.height, n = env->pixels.channels;
    x = (x % w + w) % w;
    y = y < 0 ? 0 : y >= h ? h - 1 : y;
    const float *p = env->pixels.floats + ((size_t)y * w + x) * n;
    return n >= 3 ? rnd_vec(p) : (vec3s){{p[0], p[0], p[0]}};
}

vec3s rnd_env_radiance(const struct rnd_env *env, vec3s direction)
{
    float u, v;
    rnd_to_uv(direction, &u, &v);
    const float x = u * env->pixels.width - 0.5f, y = v * env->pixels.height - 0.5f;
    const int x0 = (int)floorf(x), y0 = (int)floorf(y);
    const vec3s upper = glms_vec3_lerp(env_texel(env, x0, y0), env_texel(env, x0 + 1, y0), x - x0);
    const vec3s lower = glms_vec3_lerp(env_texel(env, x0, y0 + 1), env_texel(env, x0 + 1, y0 + 1), x - x0);
    return glms_vec3_lerp(upper, lower, y - y0);
}

/* A texel's weight: mean luminance of the texels that its bilinear footprint touches, so that nothing that
 * can shine has no density, times the solid angle. */
static float env_weight(const struct rnd_env *env, int x, int y)
{
    float sum = 0.0f;
    for (int dy = -1; dy <= 1; dy++)
        for (int dx = -1; dx <= 1; dx++) sum += rnd_luminance(env_texel(env, x + dx, y + dy).raw);
    return sum * sinf((float)M_PI * (y + 0.5f) / env->pixels.height);
}

bool rnd_env_load(struct rnd_scene *scene, const char *path, char out_error[RND_ERROR_SIZE])
{
    struct rnd_env *env = calloc(1, sizeof *env);
    float *weight = NULL;
    char text[RND_ERROR_SIZE / 2];
    if (!env) goto no_memory;
    scene->lights.env = env;
    if (!rnd_pixels_read(path, NULL, 0, false, &env->pixels, text, sizeof text)) {
        snprintf(out_error, RND_ERROR_SIZE, "%.200s: not a readable environment map: %s", path, text);
        return false;
    }
    const size_t count = (size_t)env->pixels.width * env->pixels.height;
    for (size_t i = 0; i < count * env->pixels.channels; i++) {
        const float value = env->pixels.floats[i];
        if (value >= 0.0f && isfinite(value)) continue;
        snprintf(out_error, RND_ERROR_SIZE, "%.200s: pixel %zu is negative or not finite: expected radiance",
                 path, i / env->pixels.channels);
        return false;
    }
    if (!(weight = malloc(count * sizeof *weight))) goto no_memory;
    float any = 0.0f;
    for (size_t i = 0; i < count; i++)
        any += weight[i] = env_weight(env, (int)(i % env->pixels.width), (int)(i / env->pixels.width));
    if (!(any > 0.0f)) {
        snprintf(out_error, RND_ERROR_SIZE, "%.200s: the environment map is black", path);
        free(weight);
        return false;
    }
    const bool ok = rnd_alias_init(&env->alias, weight, (uint32_t)count);
    free(weight);
    if (ok) return true;
no_memory:
    snprintf(out_error, RND_ERROR_SIZE, "%.200s: not enough memory", path);
    return false;
}

float rnd_env_pdf(const struct rnd_env *env, vec3s direction)
{
    const int w = env->pixels.width, h = env->pixels.height;
    float u, v;
    rnd_to_uv(direction, &u, &v);
    const int x = (int)fminf(u * w, w - 1), y = (int)fminf(v * h, h - 1);
    const float c = fmaxf(cosf((0.5f - v) * (float)M_PI), 1e-6f);
    return env->alias.probability[(size_t)y * w + x] * w * h / (float)(2.0 * M_PI * M_PI) / c;
}

/* --- sun --- */

/* 1 - cos of the radius: exact, since the cosine is above one half. */
static float sun_cap(const struct rnd_sun *sun)
{
    return 1.0f - sun->cos_radius;
}

void rnd_sun_init(struct rnd_sun *sun, const float options[4])
{
    rnd_direction(glm_rad(options[0]), glm_rad(options[1]), sun->direction.raw);
    sun->cos_radius = cosf(glm_rad(options[3]) * 0.5f);
    /* The cosine of so small a radius is rounded, to 1 below 0.03 degrees: the radiance is that of the disc
     * as it then is, so that the irradiance is as asked for. */
    const float cap = sun_cap(sun), sin2 = cap * (2.0f - cap);
    const float value = cap > 0.0f ? options[2] / ((float)M_PI * sin2) : options[2];
    sun->radiance = (vec3s){{value, value, value}};
}

float rnd_sun_pdf(const struct rnd_sun *sun)
{
    return 1.0f / (2.0f * (float)M_PI * sun_cap(sun));
}

/* --- tables --- */

static float triangle_area(const struct rnd_mesh *mesh, uint32_t triangle)
{
    const uint32_t *index = mesh->index[triangle];
    const vec3s a = rnd_vertex(mesh, index[0]), b = rnd_vertex(mesh, index[1]),
                c = rnd_vertex(mesh, index[2]);
    return 0.5f * glms_vec3_norm(glms_vec3_cross(glms_vec3_sub(b, a), glms_vec3_sub(c, a)));
}

/* Power of an emissive triangle; its texture is looked at in seven places, which a drawn point need not be.
 */
static float triangle_power(const struct rnd_scene *scene, const struct rnd_mesh *mesh, uint32_t triangle)
{
    static const float place[7][2] = {{1 / 3.f, 1 / 3.f}, {0.05f, 0.05f}, {0.9f, 0.05f}, {0.05f, 0.9f},
                                      {0.45f, 0.05f},     {0.05f, 0.45f}, {0.45f, 0.45f}};
    const struct rnd_material *material = &scene->material[mesh->material];
    float sum = 0.0f;
    for (int i = 0; i < 7; i++) {
        const vec3s e = rnd_emission(scene, material, mesh, mesh->index[triangle], place[i][0], place[i][1]);
        sum += rnd_luminance(e.raw);
    }
    /* A textured light may be dark in all seven places and bright between: it keeps some chance. */
    const float floor =
        material->map[RND_MAP_EMISSION].texture >= 0 ? 0.01f * rnd_luminance(material->emission.raw) : 0.0f;
    return (sum / 7.0f + floor) * triangle_area(mesh, triangle) * (float)M_PI *
           (material->double_sided ? 2 : 1);
}

static bool build_area(struct rnd_scene *scene, double *out_power)
{
    struct rnd_lights *lights = &scene->lights;
    uint64_t count = 0;
    double sum = 0.0;
    for (uint32_t m = 0; m < scene->mesh_count; m++)
        if (rnd_luminance(scene->material[scene->mesh[m].material].emission.raw) > 0.0f)
            count += scene->mesh[m].triangles;
    scene->info.emissive_triangles = count;
    if (count == 0) return true;

    lights->area = malloc(count * sizeof *lights->area);
    float *power = malloc(count * sizeof *power);
    bool ok = lights->area && power;
    for (uint32_t m = 0; ok && m < scene->mesh_count; m++) {
        struct rnd_mesh *mesh = &scene->mesh[m];
        if (!(rnd_luminance(scene->material[mesh->material].emission.raw) > 0.0f)) continue;
        mesh->first_light = lights->area_count;
        for (uint32_t t = 0; t < mesh->triangles; t++) {
            power[lights->area_count] = triangle_power(scene, mesh, t);
            sum += power[lights->area_count];
            lights->area[lights->area_count++] = (struct rnd_triangle_ref){m, t};
        }
    }
    lights->choose[RND_LIGHT_AREA] = sum > 0.0;
    *out_power = sum;
    if (ok && sum > 0.0) ok = rnd_alias_init(&lights->area_alias, power, lights->area_count);
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
        sum += power[i] = rnd_luminance(light->intensity.raw) * reach * (float)M_PI;
    }
    lights->choose[RND_LIGHT_PUNCTUAL] = sum > 0.0f;
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
    lights->choose[RND_LIGHT_ENV] = lights->env != NULL;
    lights->choose[RND_LIGHT_SUN] = lights->sun && rnd_luminance(lights->sun->radiance.raw) > 0.0f;
    for (int i = 0; i < RND_LIGHT_GROUPS; i++)
        if (lights->choose[i] > 0.0f) return true;
    snprintf(
        out_error, RND_ERROR_SIZE,
        "%.200s: nothing in the scene gives light: expected an emissive material, a light, --env or --sun",
        path);
    return false;
}

void rnd_lights_finish(struct rnd_lights *lights)
{
    if (lights->env) {
        rnd_pixels_finish(&lights->env->pixels);
        rnd_alias_finish(&lights->env->alias);
    }
    free(lights->env);
    free(lights->sun);
    free(lights->area);
    rnd_alias_finish(&lights->area_alias);
    free(lights->punctual);
    rnd_alias_finish(&lights->punctual_alias);
}

/* --- drawing --- */

static bool draw_area(const struct rnd_scene *scene, vec3s point, const float u[4],
                      struct rnd_light_sample *out)
{
    const struct rnd_triangle_ref ref =
        scene->lights.area[rnd_alias_draw(&scene->lights.area_alias, u[1], u[0])];
    const struct rnd_mesh *mesh = &scene->mesh[ref.mesh];
    const struct rnd_material *material = &scene->material[mesh->material];
    const uint32_t *index = mesh->index[ref.triangle];
    const vec3s a = rnd_vertex(mesh, index[0]), b = rnd_vertex(mesh, index[1]),
                c = rnd_vertex(mesh, index[2]);

    const float root = sqrtf(u[2]), s = 1.0f - root,
                t = u[3] * root; /* uniform: barycentric weights of a and b */
    vec3s p = glms_vec3_scale(a, s);
    p = glms_vec3_muladds(b, t, p);
    p = glms_vec3_muladds(c, 1.0f - s - t, p);
    const vec3s to = glms_vec3_sub(p, point);
    out->distance = glms_vec3_norm(to);
    if (!(out->distance > 0.0f)) return false;
    out->direction = glms_vec3_scale(to, 1.0f / out->distance);
    const vec3s normal = glms_vec3_cross(glms_vec3_sub(b, a), glms_vec3_sub(c, a));
    if (glms_vec3_dot(normal, out->direction) >= 0.0f && !material->double_sided) return false;
    out->radiance = rnd_emission(scene, material, mesh, index, t, 1.0f - s - t);
    out->pdf = rnd_area_pdf(scene, ref.mesh, ref.triangle, out->direction, out->distance);
    out->delta = false;
    return isfinite(out->pdf) && out->pdf > 0.0f;
}

float rnd_area_pdf(const struct rnd_scene *scene, uint32_t m, uint32_t triangle, vec3s direction,
                   float distance)
{
    const struct rnd_mesh *mesh = &scene->mesh[m];
    if (mesh->first_light == UINT32_MAX) return 0.0f;
    const uint32_t *index = mesh->index[triangle];
    const vec3s a = rnd_vertex(mesh, index[0]), b = rnd_vertex(mesh, index[1]),
                c = rnd_vertex(mesh, index[2]);
    const vec3s twice = glms_vec3_cross(glms_vec3_sub(b, a), glms_vec3_sub(c, a));
    const float projected = 0.5f * fabsf(glms_vec3_dot(twice, direction)); /* area times cosine */
    return scene->lights.choose[RND_LIGHT_AREA] *
           scene->lights.area_alias.probability[mesh->first_light + triangle] * distance * distance /
           projected;
}

static bool draw_env(const struct rnd_lights *lights, const float u[4], struct rnd_light_sample *out)
{
    const struct rnd_env *env = lights->env;
    const uint32_t i = rnd_alias_draw(&env->alias, u[1], u[0]);
    const uint32_t w = env->pixels.width, h = env->pixels.height;
    const float v = (i / w + u[3]) / h;
    out->direction = rnd_from_uv((i % w + u[2]) / w, v);
    out->distance = INFINITY;
    out->radiance = rnd_env_radiance(env, out->direction);
    const float c = fmaxf(cosf((0.5f - v) * (float)M_PI), 1e-6f);
    out->pdf =
        lights->choose[RND_LIGHT_ENV] * env->alias.probability[i] * w * h / (float)(2.0 * M_PI * M_PI) / c;
    out->delta = false;
    return true;
}

static bool draw_sun(const struct rnd_lights *lights, const float u[4], struct rnd_light_sample *out)
{
    const struct rnd_sun *sun = lights->sun;
    out->distance = INFINITY;
    out->radiance = sun->radiance;
    out->delta = !(sun->cos_radius < 1.0f);
    out->direction = sun->direction;
    out->pdf = lights->choose[RND_LIGHT_SUN];
    if (out->delta) return true;

    const float drop = u[2] * sun_cap(sun), c = 1.0f - drop, s = sqrtf(fmaxf(drop * (2.0f - drop), 0.0f));
    const float phi = 2.0f * (float)M_PI * u[3];
    vec3s x, y;
    rnd_frame(sun->direction, &x, &y);
    out->direction = glms_vec3_scale(sun->direction, c);
    out->direction = glms_vec3_muladds(x, s * cosf(phi), out->direction);
    out->direction = glms_vec3_muladds(y, s * sinf(phi), out->direction);
    out->pdf *= rnd_sun_pdf(sun);
    return true;
}

static bool draw_punctual(const struct rnd_lights *lights, vec3s point, const float u[4],
                          struct rnd_light_sample *out)
{
    const uint32_t i = rnd_alias_draw(&lights->punctual_alias, u[1], u[0]);
    const struct rnd_punctual *light = &lights->punctual[i];
    out->pdf = lights->choose[RND_LIGHT_PUNCTUAL] * lights->punctual_alias.probability[i];
    out->delta = true;
    out->radiance = light->intensity;
    if (light->kind == RND_DIRECTIONAL) {
        out->direction = glms_vec3_negate(light->direction);
        out->distance = INFINITY;
        return true;
    }
    const vec3s to = glms_vec3_sub(light->position, point);
    out->distance = glms_vec3_norm(to);
    if (!(out->distance > 0.0f)) return false;
    out->direction = glms_vec3_scale(to, 1.0f / out->distance);
    float falloff = 1.0f / (out->distance * out->distance);
    if (light->kind ==
        RND_SPOT) { /* KHR_lights_punctual: squared linear ramp of the cosine between the cones */
        const float c = -glms_vec3_dot(out->direction, light->direction);
        const float span = fmaxf(light->cos_inner - light->cos_outer, 1e-4f);
        const float ramp = fmaxf(0.0f, fminf(1.0f, (c - light->cos_outer) / span));
        falloff *= ramp * ramp;
    }
    out->radiance = glms_vec3_scale(light->intensity, falloff);
    return falloff > 0.0f;
}

bool rnd_light_draw_from(const struct rnd_scene *scene, int group, vec3s point, const float u[4],
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

bool rnd_light_draw(const struct rnd_scene *scene, vec3s point, const float u[4],
                    struct rnd_light_sample *out)
{
    const struct rnd_lights *lights = &scene->lights;
    float v[4] = {u[0], u[1], u[2], u[3]};
    int group = 0, last = 0;
    for (int i = 0; i < RND_LIGHT_GROUPS; i++)
        if (lights->choose[i] > 0.0f) last = i;
    for (; group < last && v[0] >= lights->choose[group]; group++) v[0] -= lights->choose[group];
    v[0] = fminf(v[0] / lights->choose[group], 0x1.fffffep-1f); /* what is left of it chooses again */
    return rnd_light_draw_from(scene, group, point, v, out);
}
