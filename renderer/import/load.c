/* Loading a scene: the order of its parts, and freeing it. */
#include "import/environment.h"
#include "import/read_scene.h"
#include "import/reader.h"
#include "import/corners.h"
#include "import/image_program.h"
#include "import/textures.h"
#include "import/tree.h"
#include "light/light.h"
#include "light/sun.h"
#include "material/material.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <pthread.h>
#include <time.h>

static double seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* The three parts of loading that run at the same time, each in a thread: textures, all that needs only
 * triangles, and the environment map. */
struct building {
    struct rnd_scene *scene;
    const struct rnd_scene_options *options;
    bool (*part)(struct building *b);
    bool ok;
    char warning[RND_ERROR_SIZE]; /* of the environment map; "": none */
    char error[RND_ERROR_SIZE];
};

static bool build_geometry(struct building *b)
{
    if (rnd_materials_build(b->scene)) {
        if (!rnd_accel_build(b->scene, b->error)) return false;
        if (rnd_corners_build(b->scene)) return true;
    }
    snprintf(b->error, sizeof b->error, "not enough memory for %llu triangles",
             (unsigned long long)b->scene->info.triangles);
    return false;
}

static bool build_env(struct building *b)
{
    return !b->options->env_path || rnd_environment_read(b->scene, b->options->env_path,
                                                         b->options->env_azimuth, b->warning, b->error);
}

static void *run(void *argument)
{
    struct building *b = argument;
    b->ok = b->part(b);
    return NULL;
}

/* Begin a part in a thread of its own; if no thread can be started, do all of it now. */
static bool begin(struct building *b, pthread_t *out_thread)
{
    if (pthread_create(out_thread, NULL, run, b) == 0) return true;
    run(b);
    return false;
}

/* Mark the textures that are needed first: coverage for the trees, emission for the lights, roughness for the
 * tables of rough glass. */
static void mark_first_textures(struct rnd_scene *scene)
{
    for (uint32_t i = 0; i < scene->material_count; i++) {
        const struct rnd_material *m = &scene->material[i];
        const bool covers = m->alpha_mode != RND_OPAQUE, emits = rnd_luminance(m->emission.raw) > 0.0f;
        const int map[4] = {covers ? m->map[RND_MAP_BASE].texture : -1,
                            covers ? m->map[RND_MAP_COVERAGE].texture : -1,
                            emits ? m->map[RND_MAP_EMISSION].texture : -1,
                            m->glossiness_mapped ? m->map[RND_MAP_SPECULAR_COLOUR].texture : -1};
        for (int k = 0; k < 4; k++)
            if (map[k] >= 0) scene->texture[map[k]].first = true;
    }
}

/* Only the mean of a glossiness map is used: the texel of its coarsest mipmap. */
static void take_glossiness(struct rnd_scene *scene)
{
    for (uint32_t i = 0; i < scene->material_count; i++) {
        struct rnd_material *m = &scene->material[i];
        const int map = m->glossiness_mapped ? m->map[RND_MAP_SPECULAR_COLOUR].texture : -1;
        m->glossiness_mapped = false;
        if (map < 0 || scene->texture[map].levels == 0) continue;
        const struct rnd_texture *t = &scene->texture[map];
        const float alpha = rnd_texture_texel(t, t->level[t->levels - 1].first).a,
                    mean = fmaxf(0.0f, fminf(alpha, 1.0f)); /* 1 if alpha is not a number */
        m->roughness = 1.0f - (1.0f - m->roughness) * mean;
        rnd_scene_unsupported(scene, "glossiness maps (their mean is taken)");
    }
}

static bool build(struct rnd_scene *scene, const struct rnd_scene_options *options,
                  char out_error[RND_ERROR_SIZE])
{
    struct building geometry = {.scene = scene, .part = build_geometry},
                    env = {.scene = scene, .options = options, .part = build_env};
    pthread_t thread, env_thread;
    const bool env_apart = options->env_path ? begin(&env, &env_thread) : (run(&env), false);
    mark_first_textures(scene);
    rnd_textures_load(scene, true);
    take_glossiness(scene);
    rnd_textures_drop_unread(scene, &scene->warnings);
    if (options->textures_later) {
        run(&geometry);
    } else {
        const bool apart = begin(&geometry, &thread);
        rnd_textures_load(scene, false);
        if (apart) pthread_join(thread, NULL);
        rnd_textures_drop_unread(scene, &scene->warnings);
        rnd_textures_sum(scene);
    }
    if (env_apart) pthread_join(env_thread, NULL);
    if (*env.warning) rnd_warn(&scene->warnings, "%s", env.warning);
    const struct building *failed = !geometry.ok ? &geometry : !env.ok ? &env : NULL;
    if (failed) memcpy(out_error, failed->error, RND_ERROR_SIZE);
    return !failed && rnd_lights_build(scene, options->path, out_error);
}

/* --- textures that come later --- */

static void *read_textures(void *argument)
{
    struct rnd_scene *scene = argument;
    rnd_textures_load(scene, false);
    atomic_store(&scene->read, true);
    return NULL;
}

/* The material without the maps that are not read yet: grey if its colour is unknown; diffuse if its
 * metalness is unknown, as most textured surfaces are. */
static struct rnd_material without_textures(const struct rnd_scene *scene, struct rnd_material m)
{
    for (int k = 0; k < RND_MAPS; k++) {
        if (m.map[k].texture < 0 || scene->texture[m.map[k].texture].levels > 0) continue;
        m.map[k].texture = -1;
        if (k == RND_MAP_BASE) m.base = glms_vec3_scale(m.base, 0.5f);
        if (k == RND_MAP_METAL_ROUGH) m.metallic = 0.0f;
    }
    return m;
}

static bool read_later(struct rnd_scene *scene, char out_error[RND_ERROR_SIZE])
{
    bool any = false;
    for (uint32_t i = 0; i < scene->texture_count; i++)
        any |= scene->texture[i].levels == 0 && !scene->texture[i].error;
    if (!any) {
        rnd_textures_sum(scene);
        return true;
    }
    struct rnd_material *plain = malloc(scene->material_count * sizeof *plain);
    for (uint32_t i = 0; plain && i < scene->material_count; i++)
        plain[i] = without_textures(scene, scene->material[i]);
    scene->reading = plain && pthread_create(&scene->reader, NULL, read_textures, scene) == 0;
    if (scene->reading) {
        scene->textured = scene->material;
        scene->material = plain;
        return true;
    }
    free(plain);
    snprintf(out_error, RND_ERROR_SIZE, "not enough memory or threads for textures");
    return false;
}

enum rnd_textures rnd_scene_take_textures(struct rnd_scene *scene, const char **out_warnings)
{
    *out_warnings = "";
    if (!scene->reading) return RND_TEXTURES_IN_USE;
    if (!atomic_load(&scene->read)) return RND_TEXTURES_READING;
    pthread_join(scene->reader, NULL);
    scene->reading = false;
    rnd_textures_sum(scene);
    free(scene->material);
    scene->material = scene->textured;
    scene->textured = NULL;
    rnd_textures_drop_unread(scene, &scene->late_warnings);
    if (scene->late_warnings.text) *out_warnings = scene->late_warnings.text;
    return RND_TEXTURES_CAME;
}

/* --- all --- */

/* With clear glass, shadow rays are weighted per colour. So a tinted pane is treated as clear glass: as a
 * pane it would pass only what all colours share. */
static void clear_glass(struct rnd_scene *scene)
{
    scene->clear_glass = true;
    for (uint32_t i = 0; i < scene->material_count; i++) {
        struct rnd_material *m = &scene->material[i];
        if (glms_vec3_max(m->base) > glms_vec3_min(m->base)) m->pane = false;
    }
}

/* Set what a scene has of the options. */
static bool begin_scene(struct rnd_scene *scene, const struct rnd_scene_options *options)
{
    scene->image_program =
        options->image_program ? rnd_image_program_share(options->image_program) : rnd_image_program_create();
    scene->reader_mib = rnd_reader_limits(options, options->path).mib;
    scene->reader_seconds = options->reader_seconds;
    scene->cancel = options->cancel;
    return scene->image_program;
}

struct rnd_scene *rnd_scene_load(const struct rnd_scene_options *options, char out_error[RND_ERROR_SIZE])
{
    const double start = seconds();
    struct rnd_scene *scene = calloc(1, sizeof *scene);
    if (!scene || !begin_scene(scene, options)) {
        snprintf(out_error, RND_ERROR_SIZE, "not enough memory");
        free(scene);
        return NULL;
    }
    /* Starting the program may take as long as reading the scene. */
    if (options->env_path && !rnd_image_program_start(scene->image_program, out_error)) goto fail;
    if (!rnd_scene_read(scene, options, out_error)) goto fail;
    if (scene->texture_count > 0 && !rnd_image_program_start(scene->image_program, out_error)) goto fail;
    if (options->clear_glass) clear_glass(scene);
    if (options->has_sun) {
        if (!(scene->lights.sun = calloc(1, sizeof *scene->lights.sun))) {
            snprintf(out_error, RND_ERROR_SIZE, "%.200s: not enough memory", options->path);
            goto fail;
        }
        rnd_sun_init(scene->lights.sun, options->sun);
    }
    if (options->has_camera) memcpy(scene->info.camera, options->camera, sizeof options->camera);
    const double read = seconds();
    if (!build(scene, options, out_error)) goto fail;
    scene->cancel = NULL; /* late textures have a flag of their own, scene->cancelled */
    if (options->textures_later && !read_later(scene, out_error)) goto fail;

    scene->info.meshes = scene->mesh_count;
    scene->info.materials = scene->material_count;
    scene->info.textures = scene->texture_count;
    scene->info.punctual_lights = scene->lights.punctual_count;
    scene->info.has_env = scene->lights.env != NULL;
    scene->info.has_sun = scene->lights.sun != NULL;
    scene->info.unsupported = scene->unsupported;
    scene->info.warnings = scene->warnings.text ? scene->warnings.text : "";
    scene->info.read_seconds = read - start;
    scene->info.build_seconds = seconds() - read;
    return scene;
fail:
    rnd_make_printable(out_error);
    rnd_scene_destroy(scene);
    return NULL;
}

void rnd_scene_destroy(struct rnd_scene *scene)
{
    if (!scene) return;
    if (scene->reading) {
        atomic_store(&scene->cancelled, true);
        pthread_join(scene->reader, NULL);
    }
    if (scene->tree) rtcReleaseScene(scene->tree);
    if (scene->clear_tree) rtcReleaseScene(scene->clear_tree);
    if (scene->border_tree) rtcReleaseScene(scene->border_tree);
    if (scene->device) rtcReleaseDevice(scene->device);
    rnd_lights_finish(&scene->lights);
    for (uint32_t i = 0; i < scene->mesh_count && !scene->flat; i++) rnd_mesh_finish(&scene->mesh[i]);
    free(scene->mesh);
    free(scene->instance);
    free(scene->alpha);
    free(scene->material);
    free(scene->textured);
    for (uint32_t i = 0; i < scene->glass_count; i++) free(scene->glass[i]);
    free(scene->glass);
    free(scene->medium);
    for (uint32_t i = 0; i < scene->texture_count; i++) {
        if (!scene->flat) free((void *)(uintptr_t)scene->texture[i].file);
        rnd_texture_finish(&scene->texture[i]);
    }
    free(scene->texture);
    free(scene->corners);
    rnd_files_finish(&scene->files);
    free(scene->warnings.text);
    free(scene->late_warnings.text);
    if (scene->flat) munmap(scene->flat, scene->flat_bytes);
    rnd_image_program_destroy(scene->image_program);
    free(scene);
}

const struct rnd_scene_info *rnd_scene_info(const struct rnd_scene *scene)
{
    return &scene->info;
}
