/* Scenes of one square with a material, for tests of what a material holds and how it looks. */
#ifndef FOVEAD_TESTS_RENDERER_MATERIALS_H
#define FOVEAD_TESTS_RENDERER_MATERIALS_H

#include "renderer_parts.h"

static const char node[] = "{\"mesh\":0}";

static inline const struct rnd_material *only(const struct rnd_scene *scene)
{
    return &scene->material[scene->mesh[0].material];
}

/* A scene of one square with this material, lit by a constant environment. */
static inline struct rnd_scene *with_material(const char *material, const char *more)
{
    return files_load(files_gltf("m.gltf", 1, node, material, more), files_env("env.exr", 1), NULL, NULL);
}

/* Write a grey image whose left half has one alpha and whose right half another. */
static inline const char *write_halves(const char *name, float left, float right)
{
    enum { SIDE = 16 };
    static const struct rnd_channel rgba[4] = {
        {"R", RND_BYTE}, {"G", RND_BYTE}, {"B", RND_BYTE}, {"A", RND_BYTE}};
    float data[SIDE * SIDE * 4];
    const char *path = files_path(name);
    for (int i = 0; i < SIDE * SIDE; i++) {
        data[4 * i] = data[4 * i + 1] = data[4 * i + 2] = 0.5f;
        data[4 * i + 3] = i % SIDE < SIDE / 2 ? left : right;
    }
    files_pixels(path, "png", SIDE, SIDE, 4, rgba, data);
    return path;
}

#define IMAGE                                                                                                \
    ",\"textures\":[{\"source\":0,\"sampler\":0}],\"images\":[{\"uri\":\"halves.png\"}],"                    \
    "\"samplers\":[{\"wrapS\":33648,\"wrapT\":33071}]"

static inline void have(const char *folder)
{
    if (access(folder, R_OK) == 0) return;
    print_message("skipped: no %s\n", folder);
    skip();
}

#endif
