/* Loading a scene: the parts in order, and their end. */
#include "scene/scene.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

void rnd_direction(float azimuth, float elevation, float out_direction[3])
{
    const float c = cosf(elevation);
    out_direction[0] = c * sinf(azimuth);
    out_direction[1] = sinf(elevation);
    out_direction[2] = -c * cosf(azimuth);
}

static double seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

struct rnd_scene *rnd_scene_load(const struct rnd_scene_options *options, char out_error[RND_ERROR_SIZE])
{
    const double start = seconds();
    struct rnd_scene *scene = calloc(1, sizeof *scene);
    if (!scene) {
        snprintf(out_error, RND_ERROR_SIZE, "%.200s: not enough memory", options->path);
        return NULL;
    }
    if (!rnd_import(scene, options->path, out_error)) goto fail;
    if (options->env_path && !rnd_env_load(scene, options->env_path, out_error)) goto fail;
    if (options->has_sun) {
        if (!(scene->lights.sun = calloc(1, sizeof *scene->lights.sun))) {
            snprintf(out_error, RND_ERROR_SIZE, "%.200s: not enough memory", options->path);
            goto fail;
        }
        rnd_sun_init(scene->lights.sun, options->sun);
    }
    if (options->has_eye) memcpy(scene->info.eye, options->eye, sizeof options->eye);
    const double read = seconds();
    if (!rnd_lights_build(scene, options->path, out_error) || !rnd_accel_build(scene, out_error)) goto fail;
    rnd_survey_lights(scene);

    scene->info.meshes = scene->mesh_count;
    scene->info.materials = scene->material_count;
    scene->info.textures = scene->texture_count;
    scene->info.punctual_lights = scene->lights.punctual_count;
    scene->info.has_env = scene->lights.env != NULL;
    scene->info.has_sun = scene->lights.sun != NULL;
    scene->info.unsupported = scene->unsupported;
    scene->info.read_seconds = read - start;
    scene->info.build_seconds = seconds() - read;
    return scene;
fail:
    rnd_scene_destroy(scene);
    return NULL;
}

void rnd_scene_destroy(struct rnd_scene *scene)
{
    if (!scene) return;
    if (scene->tree) rtcReleaseScene(scene->tree);
    if (scene->device) rtcReleaseDevice(scene->device);
    rnd_lights_finish(&scene->lights);
    for (uint32_t i = 0; i < scene->mesh_count; i++) {
        free(scene->mesh[i].position);
        free(scene->mesh[i].normal);
        free(scene->mesh[i].uv[0]);
        free(scene->mesh[i].uv[1]);
        free(scene->mesh[i].colour);
        free(scene->mesh[i].index);
    }
    free(scene->mesh);
    free(scene->instance);
    free(scene->alpha);
    free(scene->material);
    for (uint32_t i = 0; i < scene->texture_count; i++) {
        free(scene->texture[i].path);
        rnd_pixels_finish(&scene->texture[i].pixels);
    }
    free(scene->texture);
    free(scene);
}

const struct rnd_scene_info *rnd_scene_info(const struct rnd_scene *scene)
{
    return &scene->info;
}
