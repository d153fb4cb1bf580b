/* Taking a scene from memory: checks everything that the renderer assumes of a scene. */
#include "import/flat_take.h"
#include "material/material.h"

#include <float.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct take {
    struct rnd_scene *scene;
    const uint8_t *bytes;
    size_t size;
    size_t left; /* bytes that no part has taken: parts share no bytes, so that they cannot be larger than
                    the memory */
    char *why;
    size_t why_size;
};

static bool fail(struct take *take, const char *format, ...) __attribute__((format(printf, 2, 3)));

static bool fail(struct take *take, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(take->why, take->why_size, format, arguments);
    va_end(arguments);
    return false;
}

/* --- places --- */

/* Find count elements of that size, and room more bytes, at a place. NULL if they are not all within the
 * memory, or if all parts together are larger than it. */
static const void *part(struct take *take, uint64_t at, uint64_t count, size_t size, size_t room)
{
    enum { ALIGN = 16 };
    if (at == 0 || at % ALIGN != 0 || at > take->size || take->size - at < room) return NULL;
    if (count > (take->size - at - room) / size || count * size > take->left) return NULL;
    take->left -= count * size;
    return take->bytes + at;
}

static const char *text_at(struct take *take, uint64_t at)
{
    const char *text = part(take, at, 1, 1, 0), *end = text ? memchr(text, 0, take->size - at) : NULL;
    if (!end || (size_t)(end - text) > take->left) return NULL;
    take->left -= (size_t)(end - text);
    return text;
}

/* Copy a list, with room for at least one element. NULL and why if it is not within the memory, or memory is
 * short. The caller frees. */
static void *copy_list(struct take *take, const struct rnd_flat_list *list, size_t size, const char *name,
                       uint32_t *out_count)
{
    const void *from =
        list->count > 0 && list->count < UINT32_MAX ? part(take, list->at, list->count, size, 0) : NULL;
    if (list->count > 0 && !from) return fail(take, "%s that are not there", name), NULL;
    void *to = calloc((size_t)list->count + 1, size);
    if (!to) return fail(take, "more than memory can hold"), NULL;
    if (from) memcpy(to, from, (size_t)list->count * size);
    *out_count = (uint32_t)list->count;
    return to;
}

/* --- numbers --- */

/* Is each value a number from low to high? */
static bool within(const float *value, size_t count, float low, float high)
{
    bool good = true;
    for (size_t i = 0; i < count; i++) good &= (value[i] >= low) & (value[i] <= high);
    return good;
}

static bool all_within(const double *value, size_t count, double most)
{
    for (size_t i = 0; i < count; i++)
        if (!(fabs(value[i]) <= most)) return false;
    return true;
}

/* Is this byte a bool? To be asked before it is read as one. */
static bool is_bool(const bool *value)
{
    return *(const unsigned char *)value <= 1;
}

/* --- materials --- */

#define MOST_COORDINATE                                                                                      \
    4e9f                    /* of vertices, m, away from an origin that may be as far away; and of textures */
#define MOST_TRANSFORM 1e7f /* of texture coordinates */

static const struct {
    size_t at, count;
    float low, high;
} numbers[] = {
#define NUMBER(name, count, low, high)                                                                       \
    {                                                                                                        \
        offsetof(struct rnd_material, name), count, low, high                                                \
    }
    NUMBER(base, 3, 0, 1),
    NUMBER(alpha, 1, 0, 1),
    NUMBER(alpha_cutoff, 1, 0, FLT_MAX),
    NUMBER(metallic, 1, 0, 1),
    NUMBER(roughness, 1, 0, 1),
    NUMBER(ior, 1, 1, 1e4f),
    NUMBER(specular, 1, 0, 1),
    NUMBER(specular_colour, 3, 0, FLT_MAX),
    NUMBER(transmission, 1, 0, 1),
    NUMBER(absorption, 3, 0, FLT_MAX),
    NUMBER(clearcoat, 1, 0, 1),
    NUMBER(clearcoat_roughness, 1, 0, 1),
    NUMBER(sheen_colour, 3, 0, 1),
    NUMBER(sheen_roughness, 1, 0, 1),
    NUMBER(normal_scale, 1, -1e6f, 1e6f),
    NUMBER(clearcoat_normal_scale, 1, -1e6f, 1e6f),
    NUMBER(emission, 3, 0, FLT_MAX),
#undef NUMBER
};

static bool is_map(const struct rnd_map *map, uint32_t textures)
{
    return map->texture >= -1 && map->texture < (int64_t)textures && map->uv_set <= 1 &&
           map->wrap[0] <= RND_CLAMP && map->wrap[1] <= RND_CLAMP && is_bool(&map->nearest) &&
           is_bool(&map->has_transform) && within(map->transform, 6, -MOST_TRANSFORM, MOST_TRANSFORM);
}

static bool is_material(const struct rnd_material *m, uint32_t textures)
{
    bool good = (unsigned)m->alpha_mode <= RND_BLEND && is_bool(&m->thin) && is_bool(&m->unlit) &&
                is_bool(&m->double_sided) && is_bool(&m->one_sided) && is_bool(&m->glossiness_mapped);
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++)
        good = good && within((const float *)(const void *)((const char *)m + numbers[i].at),
                              numbers[i].count, numbers[i].low, numbers[i].high);
    for (int use = 0; use < RND_MAPS; use++) good = good && is_map(&m->map[use], textures);
    return good;
}

static bool take_materials(struct take *take, const struct rnd_flat_head *head)
{
    struct rnd_scene *scene = take->scene;
    scene->material =
        copy_list(take, &head->material, sizeof *scene->material, "materials", &scene->material_count);
    for (uint32_t i = 0; scene->material && i < scene->material_count; i++) {
        struct rnd_material *m = &scene->material[i];
        memset(m->glass, 0, sizeof m->glass);
        m->medium = 0;
        m->pane = false;
        if (!is_material(m, scene->texture_count)) return fail(take, "material %u with impossible values", i);
        rnd_material_set_kind(m);
    }
    return scene->material != NULL;
}

/* --- textures --- */

static bool take_texture(struct take *take, const struct rnd_flat_texture *from, struct rnd_texture *to)
{
    const char *path = text_at(take, from->path);
    const void *file = from->file.at ? part(take, from->file.at, from->file.count, 1, 0) : NULL;
    if (!path || from->use > RND_PIXELS_COLOUR || (from->file.at && !file))
        return fail(take, "an impossible texture");
    *to = (struct rnd_texture){.path = strdup(path),
                               .use = (enum rnd_pixels_use)from->use,
                               .file = file,
                               .file_bytes = file ? from->file.count : 0};
    return to->path || fail(take, "more than memory can hold");
}

static bool take_textures(struct take *take, const struct rnd_flat_head *head)
{
    struct rnd_scene *scene = take->scene;
    uint32_t count = 0;
    struct rnd_flat_texture *from = copy_list(take, &head->texture, sizeof *from, "textures", &count);
    bool ok = from && ((scene->texture = calloc(count + 1, sizeof *scene->texture)) ||
                       fail(take, "more than memory can hold"));
    for (uint32_t i = 0; ok && i < count; i++) {
        ok = take_texture(take, &from[i], &scene->texture[i]);
        scene->texture_count += ok;
    }
    free(from);
    return ok;
}

/* --- meshes and their places --- */

/* Take n numbers per vertex within a range, if there are any. The array is only read. */
static bool take_attribute(struct take *take, uint64_t at, const struct rnd_mesh *mesh, size_t n, float low,
                           float high, float **out)
{
    if (at == 0) return true;
    const float *from = part(take, at, mesh->vertices, n * sizeof *from, sizeof *from);
    *out = (float *)(uintptr_t)from;
    return from && within(from, n * mesh->vertices, low, high);
}

static bool take_indices(struct take *take, uint64_t at, struct rnd_mesh *mesh)
{
    const uint32_t *index = part(take, at, mesh->triangles, sizeof *mesh->index, 0);
    uint32_t most = 0;
    if (!index) return false;
    for (size_t i = 0; i < 3 * (size_t)mesh->triangles; i++) most = index[i] > most ? index[i] : most;
    mesh->index = (uint32_t(*)[3])(uintptr_t)index;
    return most < mesh->vertices;
}

static bool take_mesh(struct take *take, const struct rnd_flat_mesh *from, struct rnd_mesh *to)
{
    const float most = MOST_COORDINATE;
    *to = (struct rnd_mesh){.vertices = from->vertices,
                            .triangles = from->triangles,
                            .material = from->material,
                            .instanced = from->instanced == 1,
                            .first_light = UINT32_MAX};
    return from->instanced <= 1 && to->triangles > 0 && to->material < take->scene->material_count &&
           from->position && take_indices(take, from->index, to) &&
           take_attribute(take, from->position, to, 3, -most, most, &to->position) &&
           take_attribute(take, from->normal, to, 3, -2, 2, &to->normal) &&
           take_attribute(take, from->uv[0], to, 2, -most, most, &to->uv[0]) &&
           take_attribute(take, from->uv[1], to, 2, -most, most, &to->uv[1]) &&
           take_attribute(take, from->colour, to, 4, 0, 1, &to->colour) &&
           take_attribute(take, from->tangent, to, 4, -2, 2, &to->tangent);
}

static bool take_meshes(struct take *take, const struct rnd_flat_head *head)
{
    struct rnd_scene *scene = take->scene;
    uint32_t count = 0;
    struct rnd_flat_mesh *from = copy_list(take, &head->mesh, sizeof *from, "meshes", &count);
    bool ok = from && ((scene->mesh = calloc(count + 1, sizeof *scene->mesh)) ||
                       fail(take, "more than memory can hold"));
    for (uint32_t i = 0; ok && i < count; i++) {
        ok = take_mesh(take, &from[i], &scene->mesh[i]) || fail(take, "mesh %u with impossible parts", i);
        if (ok && !scene->mesh[i].instanced) scene->info.triangles += scene->mesh[i].triangles;
        scene->mesh_count += ok;
    }
    free(from);
    return ok;
}

static bool take_instances(struct take *take, const struct rnd_flat_head *head)
{
    struct rnd_scene *scene = take->scene;
    const float most = FLT_MAX;
    scene->instance =
        copy_list(take, &head->instance, sizeof *scene->instance, "instances", &scene->instance_count);
    for (uint32_t i = 0; scene->instance && i < scene->instance_count; i++) {
        const struct rnd_instance *instance = &scene->instance[i];
        if (instance->mesh >= scene->mesh_count || !scene->mesh[instance->mesh].instanced ||
            !is_bool(&instance->mirrors) || !within(&instance->scale, 1, 0, most) ||
            !within(instance->to_world, 12, -most, most) ||
            !within(instance->normal_to_world, 9, -most, most))
            return fail(take, "instance %u with impossible values", i);
        scene->info.triangles += scene->mesh[instance->mesh].triangles;
    }
    return scene->instance != NULL;
}

/* --- lights and the rest --- */

static bool take_lights(struct take *take, const struct rnd_flat_head *head)
{
    struct rnd_lights *lights = &take->scene->lights;
    lights->punctual =
        copy_list(take, &head->punctual, sizeof *lights->punctual, "lights", &lights->punctual_count);
    for (uint32_t i = 0; lights->punctual && i < lights->punctual_count; i++) {
        const struct rnd_punctual *light = &lights->punctual[i];
        const float angle[2] = {light->drop_inner, light->drop_outer};
        if ((unsigned)light->kind > RND_DIRECTIONAL ||
            !within(&light->position.x, 3, -MOST_COORDINATE, MOST_COORDINATE) ||
            !within(&light->direction.x, 3, -2, 2) || !within(&light->intensity.x, 3, 0, FLT_MAX) ||
            !within(angle, 2, 0, 2))
            return fail(take, "light %u with impossible values", i);
    }
    return lights->punctual != NULL;
}

static bool take_rest(struct take *take, const struct rnd_flat_head *head)
{
    struct rnd_scene *scene = take->scene;
    const char *warnings = text_at(take, head->warnings), *unsupported = text_at(take, head->unsupported);
    if (!warnings || !unsupported || !all_within(head->camera, 3, (double)MOST_COORDINATE) ||
        !all_within(head->bounds[0], 6, (double)MOST_COORDINATE) ||
        !all_within(head->origin, 3, (double)MOST_COORDINATE))
        return fail(take, "no place for the camera");
    for (size_t length; *warnings; warnings += length + (warnings[length] != 0)) {
        length = strcspn(warnings, "\n");
        rnd_warn(&scene->warnings, "%.*s", length < 4096 ? (int)length : 4096, warnings);
    }
    snprintf(scene->unsupported, sizeof scene->unsupported, "%s", unsupported);
    rnd_make_printable(scene->unsupported);
    memcpy(scene->info.camera, head->camera, sizeof head->camera);
    memcpy(scene->info.bounds, head->bounds, sizeof head->bounds);
    memcpy(scene->origin, head->origin, sizeof head->origin);
    return scene->info.triangles > 0 || fail(take, "no triangle");
}

static bool take_files(struct take *take, const struct rnd_flat_head *head)
{
    struct rnd_scene_info *info = &take->scene->info;
    const char *files = head->files.count > 0 ? part(take, head->files.at, head->files.count, 1, 0) : "";
    if (!files || !rnd_files_are_whole(files, head->files.count)) return fail(take, "broken names of files");
    info->files = files;
    info->files_bytes = head->files.count;
    return true;
}

bool rnd_flat_take(struct rnd_scene *scene, char *out_why, size_t size)
{
    struct take take = {scene, scene->flat, scene->flat_bytes, scene->flat_bytes, out_why, size};
    struct rnd_flat_head head;
    if (take.size < sizeof head) return fail(&take, "less than a scene");
    memcpy(&head, take.bytes, sizeof head);
    if (memcmp(head.magic, RND_FLAT_MAGIC, sizeof RND_FLAT_MAGIC) != 0 || head.layout != rnd_flat_layout())
        return fail(&take, "a scene for another version of this program");
    return take_textures(&take, &head) && take_materials(&take, &head) && take_meshes(&take, &head) &&
           take_instances(&take, &head) && take_lights(&take, &head) && take_files(&take, &head) &&
           take_rest(&take, &head);
}
