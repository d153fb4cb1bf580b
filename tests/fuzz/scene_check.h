/* Check everything in a scene that the renderer relies on. Ends the program if something is wrong. */
#ifndef FOVEAD_TEST_SCENE_CHECK_H
#define FOVEAD_TEST_SCENE_CHECK_H

#include "import/import.h"

#include <stdlib.h>
#include <string.h>

static inline void scene_check_map(const struct rnd_scene *scene, const struct rnd_map *map)
{
    if (map->texture >= (int)scene->texture_count || map->uv_set > 1) abort();
}

/* Check that the paths of a scene that was handed over can be walked through. */
static inline void scene_check_files(const struct rnd_scene_info *info)
{
    const char *at = info->files;
    for (const char *end = at + info->files_bytes; at < end; at += strlen(at) + 1)
        if (!*at) abort();
    if (at != info->files + info->files_bytes) abort();
}

static inline void scene_check(const struct rnd_scene *scene)
{
    if (scene->mesh_count == 0 || scene->info.triangles == 0) abort();
    for (uint32_t m = 0; m < scene->mesh_count; m++) {
        const struct rnd_mesh *mesh = &scene->mesh[m];
        if (mesh->material >= scene->material_count) abort();
        for (size_t i = 0; i < 3 * (size_t)mesh->vertices; i++)
            if (!isfinite(mesh->position[i]) || (mesh->normal && !isfinite(mesh->normal[i]))) abort();
        for (size_t i = 0; mesh->colour && i < 4 * (size_t)mesh->vertices; i++)
            if (!(mesh->colour[i] >= 0.0f && mesh->colour[i] <= 1.0f)) abort();
        for (uint32_t t = 0; t < mesh->triangles; t++)
            for (int k = 0; k < 3; k++)
                if (mesh->index[t][k] >= mesh->vertices) abort();
    }
    for (uint32_t i = 0; i < scene->instance_count; i++)
        if (!scene->mesh[scene->instance[i].mesh].instanced) abort();
    for (uint32_t i = 0; i < scene->material_count; i++) {
        const struct rnd_material *m = &scene->material[i];
        if (!isfinite(m->roughness + m->metallic + m->ior + m->base.x + m->emission.x + m->absorption.x))
            abort();
        for (int use = 0; use < RND_MAPS; use++) scene_check_map(scene, &m->map[use]);
    }
}

#endif
