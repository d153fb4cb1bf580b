/* Makes the meshes and instances of the scene from a file's meshes and their places. */
#include "import/import.h"

#include <float.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Largest coordinate, m, and texture coordinate: beyond it floats cannot hold the square of a triangle's
 * area, and tell no texels apart. */
#define MAX_COORDINATE 1e9
/* Within so many metres of the origin floats are fine enough for buildings. */
#define NEAR 64.0

enum { MAX_INSTANCES = 10000000 };

bool rnd_import_fail(struct rnd_import *in, const char *format, ...)
{
    const int used = snprintf(in->error, RND_ERROR_SIZE, "%.200s: ", in->path);
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(in->error + used, RND_ERROR_SIZE - (size_t)used, format, arguments);
    va_end(arguments);
    rnd_make_printable(in->error);
    for (size_t n = strlen(in->error); n > 0 && in->error[n - 1] == ' '; n--) in->error[n - 1] = 0;
    return false;
}

/* --- textures --- */

int rnd_texture_add(struct rnd_scene *scene, const char *path, const void *memory, size_t count,
                    enum rnd_pixels_use use, char out_error[RND_ERROR_SIZE])
{
    for (uint32_t i = 0; i < scene->texture_count; i++)
        if (scene->texture[i].use == use && strcmp(scene->texture[i].path, path) == 0) return (int)i;

    struct rnd_texture *grown = realloc(scene->texture, (scene->texture_count + 1) * sizeof *grown);
    if (grown) scene->texture = grown;
    struct rnd_texture texture = {.use = use, .path = strdup(path)};
    void *file = memory ? malloc(count ? count : 1) : NULL;
    if (file) {
        texture.file = memcpy(file, memory, count);
        texture.file_bytes = count;
    }
    if (!grown || !texture.path || (memory && !file)) {
        snprintf(out_error, RND_ERROR_SIZE, "%.200s: not enough memory", path);
        free(texture.path);
        free(file);
        return -1;
    }
    scene->texture[scene->texture_count] = texture;
    return (int)scene->texture_count++;
}

/* --- shapes --- */

/* Check that there are not too many. */
static bool check_amount(struct rnd_import *in, uint64_t triangles, uint64_t vertices)
{
    const uint64_t most = in->most < RND_MOST_TRIANGLES ? in->most : RND_MOST_TRIANGLES;
    return (triangles <= most && vertices <= most) ||
           rnd_import_fail(in, "more than %llu million triangles or vertices%s",
                           (unsigned long long)(most / 1000000),
                           most < RND_MOST_TRIANGLES ? ", which is too much for the bytes that it has" : "");
}

/* Count a mesh's triangles and vertices. False and a line if they are too many. */
static bool count_mesh(struct rnd_import *in, const struct rnd_mesh *mesh)
{
    in->triangles += mesh->triangles;
    in->vertices += mesh->vertices;
    return check_amount(in, in->triangles, in->vertices);
}

/* Return the list with room for one more element; its room doubles whenever its length is a power of two, or
 * 0. NULL if memory is short. */
static void *grow(void *list, uint32_t count, size_t size)
{
    return count & (count - 1) ? list : realloc(list, (count ? 2 * (size_t)count : 1) * size);
}

/* Mend attributes: texture coordinates that tell no texel become 0, colours are clamped to 0..1, and tangents
 * get a side. */
static void clean_attributes(struct rnd_mesh *mesh)
{
    const size_t n = mesh->vertices;
    for (int set = 0; set < 2; set++)
        for (size_t i = 0; mesh->uv[set] && i < 2 * n; i++)
            if (!(fabsf(mesh->uv[set][i]) <= (float)MAX_COORDINATE)) mesh->uv[set][i] = 0.0f;
    for (size_t i = 0; mesh->colour && i < 4 * n; i++)
        mesh->colour[i] = mesh->colour[i] > 0.0f ? fminf(mesh->colour[i], 1.0f) : 0.0f;
    for (size_t i = 0; mesh->tangent && i < n; i++)
        mesh->tangent[4 * i + 3] = mesh->tangent[4 * i + 3] > 0.0f ? 1.0f : -1.0f;
}

bool rnd_import_shape(struct rnd_import *in, const struct rnd_mesh *mesh, const char *name)
{
    struct rnd_shape shape = {.mesh = *mesh, .name = name ? name : ""};
    struct rnd_shape *grown = grow(in->shape, in->shape_count, sizeof *grown);
    if (!grown) {
        rnd_mesh_finish(&shape.mesh);
        return rnd_import_fail(in, "not enough memory");
    }
    clean_attributes(&shape.mesh);
    in->shape = grown;
    in->shape[in->shape_count++] = shape;
    return count_mesh(in, mesh);
}

void rnd_import_finish(struct rnd_import *in)
{
    for (uint32_t i = 0; i < in->shape_count; i++) rnd_mesh_finish(&in->shape[i].mesh);
    free(in->shape);
}

/* --- into the world --- */

static bool in_range(const double p[3])
{
    return fabs(p[0]) <= MAX_COORDINATE && fabs(p[1]) <= MAX_COORDINATE && fabs(p[2]) <= MAX_COORDINATE;
}

static void extend_bounds(struct rnd_import *in, const double p[3])
{
    for (int k = 0; k < 3; k++) {
        in->scene->info.bounds[0][k] = fmin(in->scene->info.bounds[0][k], p[k]);
        in->scene->info.bounds[1][k] = fmax(in->scene->info.bounds[1][k], p[k]);
    }
}

static void empty_bounds(struct rnd_import *in)
{
    for (int k = 0; k < 3; k++) {
        in->scene->info.bounds[0][k] = INFINITY;
        in->scene->info.bounds[1][k] = -INFINITY;
    }
}

/* The lowest and highest corner of the box around a shape's vertices. */
static void box_of(const struct rnd_mesh *mesh, float low[3], float high[3])
{
    for (int k = 0; k < 3; k++) {
        low[k] = INFINITY;
        high[k] = -INFINITY;
        for (uint32_t i = 0; i < mesh->vertices; i++) {
            low[k] = fminf(low[k], mesh->position[3 * (size_t)i + (size_t)k]);
            high[k] = fmaxf(high[k], mesh->position[3 * (size_t)i + (size_t)k]);
        }
    }
}

/* Extend the bounds by the corners of a mapped box. False if a corner is out of range, which is then left
 * out. */
static bool extend_by_box(struct rnd_import *in, const float low[3], const float high[3],
                          const struct rnd_affine *world)
{
    bool good = true;
    for (int k = 0; k < 8; k++) {
        const float corner[3] = {k & 1 ? high[0] : low[0], k & 2 ? high[1] : low[1],
                                 k & 4 ? high[2] : low[2]};
        double p[3];
        rnd_affine_apply(world, corner, 1.0, p);
        if (in_range(p))
            extend_bounds(in, p);
        else
            good = false;
    }
    return good;
}

/* If a scene is far from its file's origin, relative to its size, move the origin into its middle: where
 * floats have steps of millimetres, rays would leak through walls. The origin is in whole metres, so that
 * positions are not rounded again. */
static void choose_origin(struct rnd_import *in)
{
    const double(*bounds)[3] = (const double(*)[3])in->scene->info.bounds;
    double size = 0.0, away = 0.0;
    for (int k = 0; k < 3; k++) {
        size = fmax(size, bounds[1][k] - bounds[0][k]);
        away = fmax(away, 0.5 * fabs(bounds[0][k] + bounds[1][k]));
    }
    if (!(away > 16.0 * size || (away > size && away > NEAR)))
        return; /* also if no mesh is placed, as both are 0 then */
    for (int k = 0; k < 3; k++) in->scene->origin[k] = rint(0.5 * (bounds[0][k] + bounds[1][k]));
}

/* Map a point from the file's coordinates to the scene's own. */
static void to_own(const struct rnd_import *in, double p[3])
{
    for (int k = 0; k < 3; k++) p[k] -= in->scene->origin[k];
}

/* Normalise a vector; one of length 0 stays 0. */
static void put_unit(const double d[3], float out[3])
{
    const double length = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    const bool good = length > 0.0 && isfinite(length);
    for (int k = 0; k < 3; k++) out[k] = good ? (float)(d[k] / length) : 0.0f;
}

static void move_vectors(const struct rnd_affine *map, float *vector, int stride, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++, vector += stride) {
        double d[3];
        rnd_affine_apply(map, vector, 0.0, d);
        put_unit(d, vector);
    }
}

/* Map a mesh: its vertices, normals and tangents, and the sides of its triangles. */
static bool move_mesh(struct rnd_import *in, struct rnd_mesh *mesh, const char *name,
                      const struct rnd_affine *world)
{
    float normals[9];
    struct rnd_affine turn = rnd_affine_identity(); /* stays the identity if the mesh is flattened */
    if (rnd_affine_normals(world, normals))
        for (int k = 0; k < 9; k++) turn.m[k] = (double)normals[k];
    for (uint32_t i = 0; i < mesh->vertices; i++) {
        float *position = mesh->position + 3 * (size_t)i;
        double p[3];
        rnd_affine_apply(world, position, 1.0, p);
        if (!in_range(p))
            return rnd_import_fail(in, "vertex %u of mesh \"%.60s\" is not finite or beyond %g m", i, name,
                                   MAX_COORDINATE);
        if (!mesh->instanced) {
            extend_bounds(in, p);
            to_own(in, p);
        }
        for (int k = 0; k < 3; k++) position[k] = (float)p[k];
    }
    if (mesh->normal) move_vectors(&turn, mesh->normal, 3, mesh->vertices);
    if (mesh->tangent) move_vectors(world, mesh->tangent, 4, mesh->vertices);
    if (!(rnd_affine_determinant(world) < 0.0)) return true;
    /* A mirroring map reverses the winding, so reverse it back (glTF 2.0, section 3.7.4). */
    for (uint32_t t = 0; t < mesh->triangles; t++) {
        const uint32_t second = mesh->index[t][1];
        mesh->index[t][1] = mesh->index[t][2];
        mesh->index[t][2] = second;
    }
    for (uint32_t i = 0; mesh->tangent && i < mesh->vertices; i++) mesh->tangent[4 * (size_t)i + 3] *= -1.0f;
    return true;
}

/* --- meshes of the scene --- */

/* Copy bytes; NULL for NULL. *ok becomes false if memory is short. */
static void *copy(const void *from, size_t bytes, bool *ok)
{
    void *to = from ? malloc(bytes) : NULL;
    if (to) memcpy(to, from, bytes);
    *ok = *ok && (to || !from);
    return to;
}

static bool copy_mesh(const struct rnd_mesh *from, struct rnd_mesh *to)
{
    const size_t n = from->vertices * sizeof(float);
    bool ok = true;
    *to = *from;
    to->position = copy(from->position, 3 * n + sizeof(float), &ok);
    to->normal = copy(from->normal, 3 * n, &ok);
    to->uv[0] = copy(from->uv[0], 2 * n, &ok);
    to->uv[1] = copy(from->uv[1], 2 * n, &ok);
    to->colour = copy(from->colour, 4 * n, &ok);
    to->tangent = copy(from->tangent, 4 * n, &ok);
    to->index = copy(from->index, from->triangles * sizeof *from->index, &ok);
    return ok;
}

/* Add a mesh to the scene: with the shape's own arrays at its last place, else with copies. */
static struct rnd_mesh *add_mesh(struct rnd_import *in, struct rnd_shape *shape, bool whole)
{
    struct rnd_scene *scene = in->scene;
    struct rnd_mesh *grown = grow(scene->mesh, scene->mesh_count, sizeof *grown), mesh;
    if (!grown) goto fail;
    scene->mesh = grown;
    const struct rnd_mesh *from = shape->stored ? &grown[shape->stored_as] : &shape->mesh;
    if (whole) {
        mesh = shape->mesh;
        shape->mesh = (struct rnd_mesh){.vertices = mesh.vertices, .triangles = mesh.triangles};
    } else {
        if (!count_mesh(in, from)) return NULL;
        if (!copy_mesh(from, &mesh)) {
            rnd_mesh_finish(&mesh);
            goto fail;
        }
    }
    mesh.instanced = false;
    mesh.first_light = UINT32_MAX;
    scene->mesh[scene->mesh_count] = mesh;
    return &scene->mesh[scene->mesh_count++];
fail:
    rnd_import_fail(in, "not enough memory");
    return NULL;
}

/* --- instances --- */

/* Approximate bytes: of a triangle in the world, with attributes and tree; of a mesh or an instance itself,
 * with Embree's part. And how many must be saved before a mesh is instanced: rays are slower in a tree within
 * a tree. */
enum { TRIANGLE_BYTES = 150, OBJECT_BYTES = 1000, WORTH_BYTES = 150000 };

/* Choose which meshes are stored once and instanced: those that save memory. Emissive ones are not, since
 * lights are triangles in the world. */
static bool choose_shared(struct rnd_import *in)
{
    uint64_t triangles = in->triangles, vertices = in->vertices;
    for (uint32_t i = 0; i < in->shape_count; i++) {
        struct rnd_shape *shape = &in->shape[i];
        const struct rnd_material *material = &in->scene->material[shape->mesh.material];
        shape->shared =
            shape->places > 1 && !(rnd_luminance(material->emission.raw) > 0.0f) &&
            (shape->places - 1) * shape->mesh.triangles * TRIANGLE_BYTES > 2 * OBJECT_BYTES + WORTH_BYTES;
        if (shape->shared || shape->places == 0) continue;
        triangles += (shape->places - 1) * shape->mesh.triangles;
        vertices += (shape->places - 1) * shape->mesh.vertices;
    }
    return check_amount(in, triangles, vertices);
}

/* Add a shape to the scene's meshes, in its own coordinates. */
static bool store(struct rnd_import *in, struct rnd_shape *shape)
{
    const struct rnd_affine identity = rnd_affine_identity();
    struct rnd_mesh *mesh = add_mesh(in, shape, true);
    if (!mesh) return false;
    shape->stored = mesh->instanced = true;
    shape->stored_as = (uint32_t)(mesh - in->scene->mesh);
    return move_mesh(in, mesh, shape->name, &identity);
}

static bool add_instance(struct rnd_import *in, struct rnd_shape *shape, const struct rnd_affine *world,
                         const float normals[9])
{
    struct rnd_scene *scene = in->scene;
    if (!extend_by_box(in, shape->low, shape->high, world))
        return rnd_import_fail(in, "an instance of mesh \"%.60s\" is not finite or beyond %g m", shape->name,
                               MAX_COORDINATE);
    struct rnd_instance *grown = grow(scene->instance, scene->instance_count, sizeof *grown);
    if (!grown) return rnd_import_fail(in, "not enough memory");
    scene->instance = grown;
    struct rnd_instance *instance = &scene->instance[scene->instance_count++];
    const double determinant = rnd_affine_determinant(world);
    *instance = (struct rnd_instance){
        .mesh = shape->stored_as, .scale = (float)cbrt(fabs(determinant)), .mirrors = determinant < 0.0};
    for (int k = 0; k < 12; k++)
        instance->to_world[k] = (float)(world->m[k] - (k < 9 ? 0.0 : scene->origin[k - 9]));
    memcpy(instance->normal_to_world, normals, sizeof instance->normal_to_world);
    return true;
}

/* --- places --- */

/* Can floats hold this map of an instance? */
static bool fits_floats(const struct rnd_affine *world, const float normals[9])
{
    for (int k = 0; k < 12; k++)
        if (!isfinite((float)world->m[k]) || (k < 9 && !isfinite(normals[k]))) return false;
    return true;
}

bool rnd_import_place(struct rnd_import *in, uint32_t shape_index, const struct rnd_affine *world)
{
    struct rnd_shape *shape = &in->shape[shape_index];
    float normals[9];
    if (in->counting) {
        if (++in->places > MAX_INSTANCES)
            return rnd_import_fail(in, "meshes are in more than 10 million places");
        if (shape->places++ == 0) box_of(&shape->mesh, shape->low, shape->high);
        extend_by_box(in, shape->low, shape->high, world);
        return true;
    }
    shape->places--;
    in->scene->info.triangles += shape->mesh.triangles;
    if (shape->shared && rnd_affine_normals(world, normals) && fits_floats(world, normals))
        return (shape->stored || store(in, shape)) && add_instance(in, shape, world, normals);
    struct rnd_mesh *mesh = add_mesh(in, shape, !shape->stored && shape->places == 0);
    return mesh && move_mesh(in, mesh, shape->name, world);
}

void rnd_import_camera(struct rnd_import *in, const struct rnd_affine *world, const float position[3])
{
    double p[3];
    if (in->has_camera || in->counting) return;
    rnd_affine_apply(world, position, 1.0, p);
    memcpy(in->scene->info.camera, p, sizeof p);
    in->has_camera = in_range(p);
}

/* Mend a light: an impossible intensity becomes 0, with a warning, and impossible angles become a full
 * circle. */
static void clean_light(struct rnd_import *in, struct rnd_punctual *light)
{
    float *const intensity[3] = {&light->intensity.x, &light->intensity.y, &light->intensity.z},
                 *const drop[2] = {&light->drop_inner, &light->drop_outer};
    for (int c = 0; c < 3; c++) {
        if (*intensity[c] >= 0.0f && *intensity[c] <= FLT_MAX) continue;
        rnd_warn(&in->scene->warnings,
                 "%.200s: the intensity of a light is %g, expected 0 or more; 0 is used", in->path,
                 (double)*intensity[c]);
        *intensity[c] = 0.0f;
    }
    for (int k = 0; k < 2; k++)
        if (!(*drop[k] >= 0.0f && *drop[k] <= 2.0f)) *drop[k] = 2.0f;
}

bool rnd_import_light(struct rnd_import *in, struct rnd_punctual light, const struct rnd_affine *world)
{
    struct rnd_lights *lights = &in->scene->lights;
    const float position[3] = {light.position.x, light.position.y, light.position.z},
                direction[3] = {light.direction.x, light.direction.y, light.direction.z};
    double p[3], d[3];
    float unit[3];
    if (in->counting) return true;
    struct rnd_punctual *grown = grow(lights->punctual, lights->punctual_count, sizeof *grown);
    if (!grown) return rnd_import_fail(in, "not enough memory");
    lights->punctual = grown;
    rnd_affine_apply(world, position, 1.0, p);
    rnd_affine_apply(world, direction, 0.0, d);
    if (!in_range(p)) return rnd_import_fail(in, "a light is not finite or beyond %g m", MAX_COORDINATE);
    put_unit(d, unit);
    to_own(in, p);
    clean_light(in, &light);
    light.position = rnd_v3((float)p[0], (float)p[1], (float)p[2]);
    light.direction = rnd_v3(unit[0], unit[1], unit[2]);
    lights->punctual[lights->punctual_count++] = light;
    return true;
}

bool rnd_import_nodes(struct rnd_import *in, bool (*walk)(struct rnd_import *in, void *file), void *file)
{
    struct rnd_scene_info *info = &in->scene->info;
    empty_bounds(in);
    in->counting = true;
    if (!walk(in, file)) return false;
    choose_origin(in);
    empty_bounds(in);
    in->counting = false;
    if (!choose_shared(in) || !walk(in, file)) return false;
    if (info->triangles == 0) return rnd_import_fail(in, "holds no triangle");
    for (int k = 0; k < 3 && !in->has_camera; k++)
        info->camera[k] = 0.5 * (info->bounds[0][k] + info->bounds[1][k]);
    return true;
}
