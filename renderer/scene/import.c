/* Scene files by assimp: its nodes are flattened into meshes in the world, but for those that instances of
 * one mesh stand for.
 */
#include "scene/gltf.h"
#include "scene/material.h"
#include "scene/scene.h"

#include <assimp/cimport.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAX_TRIANGLES 500000000ull /* and as many vertices */
/* Beyond this, m, the square of a triangle's area leaves float; and texture coordinates their texel. */
#define MAX_COORDINATE 1e9f

enum { MAX_INSTANCES = 10000000 };

/* What becomes of a mesh of the file. */
struct use {
    uint64_t count; /* in how many places it is */
    bool shared;    /* it is stored once, and instances stand for it */
    bool stored;    /* that has been done: as this mesh of the scene, between these corners */
    uint32_t mesh;
    struct aiVector3D low, high;
};

struct import {
    struct rnd_scene *scene;
    const struct aiScene *file;
    const char *path;
    char directory[2048];         /* with its slash, or "" */
    struct rnd_gltf gltf;         /* without a root for OBJ and the like */
    struct use *use;              /* of the file's meshes */
    uint64_t triangles, vertices; /* that are stored */
    bool has_eye;
    uint32_t most_lights; /* that there is room for */
    char *error;
};

static bool fail(struct import *in, const char *what)
{
    snprintf(in->error, RND_ERROR_SIZE, "%.200s: %.200s", in->path, what);
    for (char *c = in->error; *c; c++)
        if (*c == '\n' || *c == '\r') *c = ' ';
    for (size_t n = strlen(in->error); n > 0 && in->error[n - 1] == ' '; n--) in->error[n - 1] = 0;
    return false;
}

void rnd_scene_unsupported(struct rnd_scene *scene, const char *name)
{
    const size_t used = strlen(scene->unsupported);
    if (strstr(scene->unsupported, name)) return;
    if (used + strlen(name) + 3 > sizeof scene->unsupported) return;
    snprintf(scene->unsupported + used, sizeof scene->unsupported - used, "%s%s", used ? ", " : "", name);
}

static bool read_materials(struct import *in)
{
    struct rnd_scene *scene = in->scene;
    scene->material_count = in->file->mNumMaterials;
    scene->material = calloc(scene->material_count ? scene->material_count : 1, sizeof *scene->material);
    if (!scene->material) return fail(in, "not enough memory");
    if (in->gltf.root) return rnd_gltf_materials(&in->gltf, scene, in->file);
    for (uint32_t i = 0; i < scene->material_count; i++)
        if (!rnd_mtl_material(scene, in->file, in->file->mMaterials[i], in->path, in->directory,
                              &scene->material[i], in->error))
            return false;
    return true;
}

/* --- geometry --- */

static vec3s transform(const struct aiMatrix4x4 *m, const struct aiVector3D *p, float w)
{
    return (vec3s){{m->a1 * p->x + m->a2 * p->y + m->a3 * p->z + m->a4 * w,
                    m->b1 * p->x + m->b2 * p->y + m->b3 * p->z + m->b4 * w,
                    m->c1 * p->x + m->c2 * p->y + m->c3 * p->z + m->c4 * w}};
}

static struct rnd_v3 v3_of(vec3s v)
{
    return rnd_v3(v.x, v.y, v.z);
}

static bool in_range(vec3s p)
{
    return fabsf(p.x) <= MAX_COORDINATE && fabsf(p.y) <= MAX_COORDINATE && fabsf(p.z) <= MAX_COORDINATE;
}

static void extend_bounds(struct import *in, vec3s p)
{
    for (int k = 0; k < 3; k++) {
        in->scene->info.bounds[0][k] = fmin(in->scene->info.bounds[0][k], (double)p.raw[k]);
        in->scene->info.bounds[1][k] = fmax(in->scene->info.bounds[1][k], (double)p.raw[k]);
    }
}

/* How normals go when points go by m, keeping their side. False if m has no inverse. */
static bool normal_matrix(const struct aiMatrix4x4 *m, struct aiMatrix4x4 *out)
{
    const float determinant = aiMatrix4Determinant(m);
    *out = *m;
    aiMatrix4Inverse(out);
    aiTransposeMatrix4(out);
    return isfinite(determinant) && determinant != 0.0f && isfinite(out->a1 + out->a2 + out->a3) &&
           isfinite(out->b1 + out->b2 + out->b3) && isfinite(out->c1 + out->c2 + out->c3);
}

static bool read_vertices(struct import *in, const struct aiMesh *from, const struct aiMatrix4x4 *world,
                          struct rnd_mesh *to)
{
    struct aiMatrix4x4 normals;
    if (!normal_matrix(world, &normals)) aiIdentityMatrix4(&normals); /* flattened to nothing, or nearly */
    for (uint32_t i = 0; i < to->vertices; i++) {
        const vec3s p = transform(world, &from->mVertices[i], 1.0f);
        if (!in_range(p)) {
            char what[160];
            snprintf(what, sizeof what, "vertex %u of mesh \"%.60s\" is not finite or beyond %g m", i,
                     from->mName.data, (double)MAX_COORDINATE);
            return fail(in, what);
        }
        memcpy(to->position + 3 * (size_t)i, p.raw, sizeof p);
        if (!to->instanced) extend_bounds(in, p);
        if (!to->normal) continue;
        const vec3s n = glms_vec3_normalize(transform(&normals, &from->mNormals[i], 0.0f));
        memcpy(to->normal + 3 * (size_t)i, (isfinite(glms_vec3_norm2(n)) ? n : glms_vec3_zero()).raw,
               sizeof n);
    }
    return true;
}

static float unit(float value)
{
    return value > 0.0f ? fminf(value, 1.0f) : 0.0f;
}

/* Texture coordinates and colours, if there are any. */
static bool read_attributes(const struct aiMesh *from, struct rnd_mesh *to)
{
    const size_t n = to->vertices;
    for (int set = 0; set < 2; set++) {
        const struct aiVector3D *uv = from->mTextureCoords[set];
        if (!uv) continue;
        if (!(to->uv[set] = malloc(2 * n * sizeof *to->uv[set]))) return false;
        for (size_t i = 0; i < n; i++) {
            to->uv[set][2 * i] = fabsf(uv[i].x) <= MAX_COORDINATE ? uv[i].x : 0.0f;
            to->uv[set][2 * i + 1] = fabsf(uv[i].y) <= MAX_COORDINATE ? uv[i].y : 0.0f;
        }
    }
    const struct aiColor4D *colour = from->mColors[0];
    if (!colour) return true;
    if (!(to->colour = malloc(4 * n * sizeof *to->colour))) return false;
    bool opaque = true; /* of colours without alpha, assimp leaves it 0 */
    for (size_t i = 0; i < n && opaque; i++) opaque = colour[i].a == 0.0f;
    for (size_t i = 0; i < n; i++) {
        const float rgba[4] = {unit(colour[i].r), unit(colour[i].g), unit(colour[i].b),
                               opaque ? 1.0f : unit(colour[i].a)};
        memcpy(to->colour + 4 * i, rgba, sizeof rgba);
    }
    return true;
}

static uint32_t count_triangles(const struct aiMesh *mesh)
{
    uint32_t triangles = 0;
    for (uint32_t f = 0; f < mesh->mNumFaces; f++) triangles += mesh->mFaces[f].mNumIndices == 3;
    return triangles;
}

/* A mesh that goes by world into the scene, or stays in its own coordinates for instances. */
static bool read_mesh(struct import *in, const struct aiMesh *from, const struct aiMatrix4x4 *world,
                      bool instanced)
{
    struct rnd_scene *scene = in->scene;
    const uint32_t triangles = count_triangles(from);
    const size_t n = from->mNumVertices;
    if (triangles == 0) return true;
    in->triangles += triangles;
    in->vertices += n;
    if (in->triangles > MAX_TRIANGLES || in->vertices > MAX_TRIANGLES)
        return fail(in, "more than 500 million triangles or vertices");
    if (from->mMaterialIndex >= scene->material_count)
        return fail(in, "a mesh names a material that is not there");

    struct rnd_mesh *grown = realloc(scene->mesh, (scene->mesh_count + 1) * sizeof *grown);
    if (!grown) return fail(in, "not enough memory");
    scene->mesh = grown;
    struct rnd_mesh *to = &scene->mesh[scene->mesh_count++];
    *to = (struct rnd_mesh){.vertices = from->mNumVertices,
                            .triangles = triangles,
                            .material = from->mMaterialIndex,
                            .first_light = UINT32_MAX,
                            .instanced = instanced};
    to->position = malloc((3 * n + 1) * sizeof *to->position);
    to->index = malloc(triangles * sizeof *to->index);
    if (from->mNormals) to->normal = malloc(3 * n * sizeof *to->normal);
    if (!to->position || !to->index || (from->mNormals && !to->normal) || !read_attributes(from, to))
        return fail(in, "not enough memory");
    to->position[3 * n] = 0.0f;
    if (!read_vertices(in, from, world, to)) return false;

    /* A mirrored node turns the winding round; glTF 2.0 section 3.7.4 wants it turned back. */
    const bool mirrored = aiMatrix4Determinant(world) < 0.0f;
    uint32_t t = 0;
    for (uint32_t f = 0; f < from->mNumFaces; f++) {
        const unsigned *i = from->mFaces[f].mIndices;
        if (from->mFaces[f].mNumIndices != 3) continue;
        if (i[0] >= n || i[1] >= n || i[2] >= n)
            return fail(in, "a triangle names a vertex that is not there");
        to->index[t][0] = i[0];
        to->index[t][1] = i[mirrored ? 2 : 1];
        to->index[t++][2] = i[mirrored ? 1 : 2];
    }
    return true;
}

/* --- instances --- */

/* Bytes, about: of a triangle in the world, attributes and tree; of what a mesh or an instance has besides,
 * Embree's part included. What is to be saved before rays are sent through a tree within the tree, which is
 * slower. */
enum { TRIANGLE_BYTES = 150, OBJECT_BYTES = 1000, WORTH_BYTES = 150000 };

static bool shines(const struct rnd_material *material)
{
    return rnd_luminance(material->emission.raw) > 0.0f;
}

/* Which meshes are stored once: those that save memory. What shines is a list of triangles in the world. */
static void choose_shared(struct import *in)
{
    for (unsigned i = 0; i < in->file->mNumMeshes; i++) {
        const struct aiMesh *mesh = in->file->mMeshes[i];
        const uint64_t uses = in->use[i].count, triangles = count_triangles(mesh);
        if (uses < 2 || mesh->mMaterialIndex >= in->scene->material_count) continue;
        in->use[i].shared = !shines(&in->scene->material[mesh->mMaterialIndex]) &&
                            (uses - 1) * triangles * TRIANGLE_BYTES > 2 * OBJECT_BYTES + WORTH_BYTES;
    }
}

static bool add_instance(struct import *in, uint32_t mesh, const struct aiMatrix4x4 *m,
                         const struct aiMatrix4x4 *n)
{
    struct rnd_scene *scene = in->scene;
    if (scene->instance_count == MAX_INSTANCES) return fail(in, "more than 10 million instances");
    if ((scene->instance_count & (scene->instance_count - 1)) == 0) { /* full: a power of two */
        const size_t room = scene->instance_count ? 2 * (size_t)scene->instance_count : 1;
        struct rnd_instance *grown = realloc(scene->instance, room * sizeof *grown);
        if (!grown) return fail(in, "not enough memory");
        scene->instance = grown;
    }
    scene->instance[scene->instance_count++] = (struct rnd_instance){
        .mesh = mesh,
        .to_world = {m->a1, m->b1, m->c1, m->a2, m->b2, m->c2, m->a3, m->b3, m->c3, m->a4, m->b4, m->c4},
        .scale = cbrtf(fabsf(aiMatrix4Determinant(m))),
        .mirrors = aiMatrix4Determinant(m) < 0.0f,
        .normal_to_world = {n->a1, n->b1, n->c1, n->a2, n->b2, n->c2, n->a3, n->b3, n->c3}};
    return true;
}

/* Put the file's i-th mesh where world says. */
static bool place_mesh(struct import *in, unsigned i, const struct aiMatrix4x4 *world)
{
    const struct aiMesh *from = in->file->mMeshes[i];
    struct use *use = &in->use[i];
    struct aiMatrix4x4 normals, identity;
    in->scene->info.triangles += count_triangles(from);
    if (!use->shared || !normal_matrix(world, &normals)) return read_mesh(in, from, world, false);
    if (!use->stored) {
        aiIdentityMatrix4(&identity);
        use->mesh = in->scene->mesh_count;
        use->stored = true;
        if (!read_mesh(in, from, &identity, true)) return false;
        use->low = use->high = from->mVertices[0];
        for (unsigned k = 1; k < from->mNumVertices; k++) {
            const struct aiVector3D p = from->mVertices[k];
            use->low =
                (struct aiVector3D){fminf(use->low.x, p.x), fminf(use->low.y, p.y), fminf(use->low.z, p.z)};
            use->high = (struct aiVector3D){fmaxf(use->high.x, p.x), fmaxf(use->high.y, p.y),
                                            fmaxf(use->high.z, p.z)};
        }
    }
    for (int k = 0; k < 8; k++) { /* corners of its box bound it */
        const struct aiVector3D corner = {k & 1 ? use->high.x : use->low.x, k & 2 ? use->high.y : use->low.y,
                                          k & 4 ? use->high.z : use->low.z};
        const vec3s p = transform(world, &corner, 1.0f);
        if (!in_range(p)) return fail(in, "an instance of a mesh is not finite or beyond 1e9 m");
        extend_bounds(in, p);
    }
    return add_instance(in, use->mesh, world, &normals);
}

/* --- nodes --- */

static struct aiMatrix4x4 pose_matrix(const struct rnd_pose *pose)
{
    const float *t = pose->translation, *r = pose->rotation, *s = pose->scale;
    const float l = r[0] * r[0] + r[1] * r[1] + r[2] * r[2] + r[3] * r[3], k = l > 0.0f ? 2.0f / l : 0.0f;
    const float x = r[0], y = r[1], z = r[2], w = r[3];
    return (struct aiMatrix4x4){(1 - k * (y * y + z * z)) * s[0],
                                k * (x * y - z * w) * s[1],
                                k * (x * z + y * w) * s[2],
                                t[0],
                                k * (x * y + z * w) * s[0],
                                (1 - k * (x * x + z * z)) * s[1],
                                k * (y * z - x * w) * s[2],
                                t[1],
                                k * (x * z - y * w) * s[0],
                                k * (y * z + x * w) * s[1],
                                (1 - k * (x * x + y * y)) * s[2],
                                t[2],
                                0,
                                0,
                                0,
                                1};
}

/* A node's meshes, each as often as it is instanced; in the first round they are only counted. */
static bool read_node_meshes(struct import *in, const struct aiNode *node, const struct aiMatrix4x4 *world,
                             const json_t *json, bool counting)
{
    struct rnd_pose *pose = NULL;
    size_t poses = 0;
    bool ok = true;
    if (node->mNumMeshes == 0) return true;
    if (json && !rnd_gltf_node_instances(&in->gltf, json, &pose, &poses)) return false;
    for (unsigned i = 0; ok && i < node->mNumMeshes; i++) {
        const unsigned mesh = node->mMeshes[i];
        if (counting) in->use[mesh].count += poses ? poses : 1;
        if (!counting && !poses) ok = place_mesh(in, mesh, world);
        for (size_t k = 0; ok && !counting && k < poses; k++) {
            struct aiMatrix4x4 at = *world;
            const struct aiMatrix4x4 within = pose_matrix(&pose[k]);
            aiMultiplyMatrix4(&at, &within);
            ok = place_mesh(in, mesh, &at);
        }
    }
    free(pose);
    return ok;
}

/* The eye is at the first camera. */
static void see_from(struct import *in, const struct aiMatrix4x4 *world, struct aiVector3D position)
{
    const vec3s p = transform(world, &position, 1.0f);
    for (int k = 0; k < 3; k++) in->scene->info.eye[k] = (double)p.raw[k];
    in->has_eye = isfinite(p.x) && isfinite(p.y) && isfinite(p.z);
}

static bool add_light(struct import *in, struct rnd_punctual light, const struct aiMatrix4x4 *world,
                      struct aiVector3D position, struct aiVector3D direction)
{
    struct rnd_lights *lights = &in->scene->lights;
    if (lights->punctual_count == in->most_lights) return fail(in, "two nodes share a light");
    light.position = v3_of(transform(world, &position, 1.0f));
    light.direction = v3_of(glms_vec3_normalize(transform(world, &direction, 0.0f)));
    lights->punctual[lights->punctual_count++] = light;
    return true;
}

/* Cameras and lights that assimp found at the node. */
static bool read_named(struct import *in, const struct aiNode *node, const struct aiMatrix4x4 *world)
{
    for (unsigned i = 0; !in->has_eye && i < in->file->mNumCameras; i++)
        if (strcmp(in->file->mCameras[i]->mName.data, node->mName.data) == 0)
            see_from(in, world, in->file->mCameras[i]->mPosition);
    for (unsigned i = 0; i < in->file->mNumLights; i++) {
        const struct aiLight *from = in->file->mLights[i];
        if (strcmp(from->mName.data, node->mName.data) != 0) continue;
        const bool spot = from->mType == aiLightSource_SPOT, sun = from->mType == aiLightSource_DIRECTIONAL;
        if (!spot && !sun && from->mType != aiLightSource_POINT) continue;
        const struct rnd_punctual light = {
            .kind = sun    ? RND_DIRECTIONAL
                    : spot ? RND_SPOT
                           : RND_POINT,
            .intensity = rnd_v3(from->mColorDiffuse.r, from->mColorDiffuse.g, from->mColorDiffuse.b),
            .drop_inner = rnd_drop_of(from->mAngleInnerCone),
            .drop_outer = rnd_drop_of(from->mAngleOuterCone)};
        if (!add_light(in, light, world, from->mPosition, from->mDirection)) return false;
    }
    return true;
}

/* Those of a glTF node: both look along its -Z. */
static bool read_gltf(struct import *in, const json_t *json, const struct aiMatrix4x4 *world)
{
    const struct aiVector3D origin = {0, 0, 0}, ahead = {0, 0, -1};
    struct rnd_punctual light;
    bool any;
    if (!in->has_eye && rnd_gltf_at(&in->gltf, "cameras", json_object_get(json, "camera")))
        see_from(in, world, origin);
    if (!rnd_gltf_node_light(&in->gltf, json, &light, &any)) return false;
    return !any || add_light(in, light, world, origin, ahead);
}

/* The node in the JSON, whose index its name is. NULL for the root that assimp puts above several. */
static const json_t *json_node(const struct import *in, const struct aiNode *node, size_t *out_index)
{
    char *end;
    if (!in->gltf.root) return NULL;
    *out_index = strtoul(node->mName.data, &end, 10);
    return *end || end == node->mName.data
               ? NULL
               : json_array_get(json_object_get(in->gltf.root, "nodes"), *out_index);
}

/* A node and those below it. */
static bool read_node(struct import *in, const struct aiNode *node, const struct aiMatrix4x4 *parent,
                      int depth, bool counting)
{
    struct aiMatrix4x4 world = *parent;
    size_t index;
    const json_t *json = json_node(in, node, &index);
    if (depth > RND_NODE_DEPTH) return fail(in, "nodes are nested more than 256 deep");
    const struct aiMatrix4x4 local =
        json && in->gltf.moved[index] ? pose_matrix(&in->gltf.pose[index]) : node->mTransformation;
    aiMultiplyMatrix4(&world, &local);
    if (!read_node_meshes(in, node, &world, json, counting)) return false;
    if (!counting && !(json ? read_gltf(in, json, &world) : read_named(in, node, &world))) return false;
    for (unsigned i = 0; i < node->mNumChildren; i++)
        if (!read_node(in, node->mChildren[i], &world, depth + 1, counting)) return false;
    return true;
}

static bool read_nodes(struct import *in, bool counting)
{
    struct aiMatrix4x4 identity;
    aiIdentityMatrix4(&identity);
    return read_node(in, in->file->mRootNode, &identity, 0, counting);
}

/* --- the file --- */

static void name_unsupported(struct import *in)
{
    static const char *const extensions[][2] = {
        {"KHR_materials_variants", "variants (the default is shown)"},
        {"KHR_texture_basisu", "Basis textures"},
        {"KHR_animation_pointer", "animated properties"},
    };
    const json_t *root = in->gltf.root, *used = json_object_get(root, "extensionsUsed");
    if (in->file->mNumAnimations > 0 || json_array_size(json_object_get(root, "animations")) > 0)
        rnd_scene_unsupported(in->scene, "animation (its first frame is shown)");
    if (json_array_size(json_object_get(root, "skins")) > 0) rnd_scene_unsupported(in->scene, "skins");
    if (in->gltf.morphs) rnd_scene_unsupported(in->scene, "morph targets");
    for (size_t i = 0; i < json_array_size(used); i++) {
        const char *name = json_string_value(json_array_get(used, i));
        for (size_t k = 0; name && k < sizeof extensions / sizeof *extensions; k++)
            if (strcmp(name, extensions[k][0]) == 0) rnd_scene_unsupported(in->scene, extensions[k][1]);
    }
}

static bool read_scene(struct import *in)
{
    struct rnd_scene *scene = in->scene;
    for (int k = 0; k < 3; k++) {
        scene->info.bounds[0][k] = INFINITY;
        scene->info.bounds[1][k] = -INFINITY;
    }
    in->most_lights =
        (uint32_t)json_array_size(json_object_get(in->gltf.root, "nodes")) + in->file->mNumLights;
    scene->lights.punctual = calloc(in->most_lights + 1, sizeof *scene->lights.punctual);
    in->use = calloc(in->file->mNumMeshes + 1, sizeof *in->use);
    if (!scene->lights.punctual || !in->use) return fail(in, "not enough memory");
    if (!read_materials(in) || !read_nodes(in, true)) return false;
    choose_shared(in);
    if (!read_nodes(in, false)) return false;
    if (scene->info.triangles == 0) return fail(in, "holds no triangle");
    name_unsupported(in);
    for (int k = 0; k < 3 && !in->has_eye; k++)
        scene->info.eye[k] = 0.5 * (scene->info.bounds[0][k] + scene->info.bounds[1][k]);
    return true;
}

bool rnd_import(struct rnd_scene *scene, const char *path, char out_error[RND_ERROR_SIZE])
{
    struct import in = {.scene = scene, .path = path, .error = out_error};
    bool ok = false;
    const char *slash = strrchr(path, '/'), *dot = strrchr(path, '.');
    if (slash && snprintf(in.directory, sizeof in.directory, "%.*s", (int)(slash - path + 1), path) >=
                     (int)sizeof in.directory)
        return fail(&in, "the path is too long");
    const bool gltf = dot && (strcasecmp(dot, ".gltf") == 0 || strcasecmp(dot, ".glb") == 0);

    FILE *file = fopen(path, "rb"); /* assimp does not say why it cannot open a file */
    if (!file) return fail(&in, strerror(errno));
    errno = 0;
    const int first = fgetc(file); /* of a directory, this is what fails */
    const int cause = errno;
    fclose(file);
    if (first == EOF) return fail(&in, cause ? strerror(cause) : "is empty");
    if (gltf && !rnd_gltf_open(&in.gltf, path, out_error)) return false;
    const unsigned flags = aiProcess_Triangulate | aiProcess_SortByPType | aiProcess_FlipUVs;
    in.file = gltf ? rnd_gltf_import(&in.gltf, flags) : aiImportFile(path, flags);
    if (!in.file || !in.file->mRootNode) {
        const char *why = aiGetErrorString();
        fail(&in, why && *why ? why : "holds no scene that can be read");
        goto end;
    }
    ok = read_scene(&in);
end:
    if (in.file) aiReleaseImport(in.file);
    rnd_gltf_close(&in.gltf);
    free(in.use);
    return ok;
}
