/* Point, spot and directional lights: their table, and drawing one. */
#include "light/punctual.h"
#include "light/drop.h"
#include "light/emitters.h"

#include <float.h>
#include <stdlib.h>

bool rnd_punctual_build(struct rnd_scene *scene, double *out_power)
{
    struct rnd_lights *lights = &scene->lights;
    *out_power = 0.0;
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
    *out_power = sum;
    if (ok && sum > 0.0f && isfinite(sum))
        ok = rnd_emitters_build(&lights->emitters[RND_LIGHT_PUNCTUAL], position, power,
                                lights->punctual_count);
    free(power);
    free(position);
    return ok;
}

bool rnd_punctual_light(const struct rnd_scene *scene, const struct rnd_light_choice *choice,
                        struct rnd_v3 point, const float u[4], struct rnd_light_sample *out)
{
    const struct rnd_lights *lights = &scene->lights;
    const struct rnd_alias *alias = choice->emitters[RND_LIGHT_PUNCTUAL];
    const uint32_t i = rnd_alias_draw(alias, u[1], u[0]);
    const struct rnd_punctual *light = &lights->punctual[i];
    out->part = lights->emitters[RND_LIGHT_PUNCTUAL].part[i];
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
