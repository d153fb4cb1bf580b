/* Loading a scene: the parts in order, and their end. */
#include "scene/scene.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <pthread.h>
#include <time.h>
#include <unistd.h>

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

/* What can be done at the same time: reading textures is one thread's, all that needs triangles alone
 * another's. */
struct building {
    struct rnd_scene *scene;
    bool ok;
    char error[RND_ERROR_SIZE];
};

static void *build_geometry(void *argument)
{
    struct building *b = argument;
    b->ok = rnd_accel_build(b->scene, b->error);
    if (!b->ok || rnd_records_build(b->scene)) return NULL;
    b->ok = false;
    snprintf(b->error, sizeof b->error, "not enough memory for %llu triangles",
             (unsigned long long)b->scene->info.triangles);
    return NULL;
}

static bool has_coverage(const struct rnd_scene *scene)
{
    for (uint32_t i = 0; i < scene->material_count; i++)
        if (scene->material[i].alpha_mode != RND_OPAQUE) return true;
    return false;
}

static bool build(struct rnd_scene *scene, const char *path, char out_error[RND_ERROR_SIZE])
{
    struct building geometry = {.scene = scene};
    pthread_t thread;
    const long processors = sysconf(_SC_NPROCESSORS_ONLN);
    /* Only coverage asks for textures before the tree is built. */
    const bool apart = !has_coverage(scene) && pthread_create(&thread, NULL, build_geometry, &geometry) == 0;
    const bool textures = rnd_textures_load(scene, processors > 0 ? (int)processors : 1, out_error);
    if (apart)
        pthread_join(thread, NULL);
    else if (textures)
        build_geometry(&geometry);
    if (textures && !geometry.ok) memcpy(out_error, geometry.error, RND_ERROR_SIZE);
    return textures && geometry.ok && rnd_lights_build(scene, path, out_error);
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
    if (options->env_path && !rnd_env_load(scene, options->env_path, options->env_azimuth, out_error))
        goto fail;
    if (options->has_sun) {
        if (!(scene->lights.sun = calloc(1, sizeof *scene->lights.sun))) {
            snprintf(out_error, RND_ERROR_SIZE, "%.200s: not enough memory", options->path);
            goto fail;
        }
        rnd_sun_init(scene->lights.sun, options->sun);
    }
    if (options->has_eye) memcpy(scene->info.eye, options->eye, sizeof options->eye);
    const double read = seconds();
    if (!build(scene, options->path, out_error)) goto fail;

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
    for (uint32_t i = 0; i < scene->texture_count; i++) rnd_texture_finish(&scene->texture[i]);
    free(scene->texture);
    free(scene->record);
    free(scene);
}

const struct rnd_scene_info *rnd_scene_info(const struct rnd_scene *scene)
{
    return &scene->info;
}
