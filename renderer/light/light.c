/* All kinds of light: their tables, how often each is drawn, and drawing. */
#include "light/light.h"
#include "light/area.h"
#include "light/area_build.h"
#include "light/env.h"
#include "light/punctual.h"
#include "light/sun.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static const struct rnd_light_kind kind_of[RND_LIGHT_GROUPS] = {
    [RND_LIGHT_AREA] = {rnd_areas_build, rnd_area_light},
    [RND_LIGHT_ENV] = {rnd_env_build, rnd_env_light},
    [RND_LIGHT_SUN] = {rnd_sun_build, rnd_sun_light},
    [RND_LIGHT_PUNCTUAL] = {rnd_punctual_build, rnd_punctual_light},
};

/* Is there a surface that shows without any light: an unlit one, or one that emits? */
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
    for (int g = 0; g < RND_LIGHT_GROUPS; g++) {
        double power;
        if (!kind_of[g].build(scene, &power)) {
            snprintf(out_error, RND_ERROR_SIZE, "%.200s: not enough memory for its lights", path);
            return false;
        }
        if (!isfinite(power)) {
            snprintf(out_error, RND_ERROR_SIZE,
                     "%.200s: its lights are too bright: their power is not finite", path);
            return false;
        }
        lights->has[g] = power > 0.0;
        lights->any |= lights->has[g];
    }
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
        rnd_alias_finish(&lights->emitters[g].by_power);
        free(lights->emitters[g].part);
    }
}

void rnd_light_choose_evenly(const struct rnd_lights *lights, struct rnd_light_choice *choice)
{
    float groups = 0.0f;
    for (int g = 0; g < RND_LIGHT_GROUPS; g++) groups += lights->has[g];
    for (int g = 0; g < RND_LIGHT_GROUPS; g++) {
        choice->group[g] = lights->has[g] ? 1.0f / groups : 0.0f;
        choice->emitters[g] = &lights->emitters[g].by_power;
    }
    if (lights->env) choice->env = lights->env->by_weight;
}

void rnd_light_choice_finish(struct rnd_light_choice *choice)
{
    for (int g = 0; g < RND_LIGHT_GROUPS; g++) rnd_alias_finish(&choice->own[g]);
}

bool rnd_light_draw(const struct rnd_scene *scene, const struct rnd_light_choice *choice, int group,
                    struct rnd_v3 point, const float u[4], struct rnd_light_sample *out)
{
    return kind_of[group].draw(scene, choice, point, u, out);
}
