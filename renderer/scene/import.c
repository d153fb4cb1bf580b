/* Scene files by assimp: its nodes are flattened into meshes in the world, its materials mapped to ours. */
#include "scene/scene.h"

#include <assimp/cimport.h>
#include <assimp/config.h>
#include <assimp/material.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <assimp/GltfMaterial.h>
#include <assimp/ObjMaterial.h>

#include <ctype.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define MAX_TRIANGLES 500000000ull /* and as many vertices */
/* Beyond this, m, the square of a triangle's area leaves float; and texture coordinates their texel. */
#define MAX_COORDINATE 1e9f

struct import {
    struct rnd_scene *scene;
    const struct aiScene *file;
    const char *path;
    char directory[2048]; /* with its slash, or "" */
    bool gltf;            /* else OBJ and the like, whose materials are Phong's and have no sides */
    uint64_t vertices;
    bool has_eye;
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

/* --- materials --- */

/* A glTF names files by URI; assimp leaves its %20 and the like as they are. In place. */
static void decode_percent(char *text)
{
    char *to = text;
    for (const char *from = text; *from; to++) {
        unsigned byte;
        if (*from == '%' && isxdigit((unsigned char)from[1]) && isxdigit((unsigned char)from[2]) &&
            sscanf(from + 1, "%2x", &byte) == 1 && byte != 0) {
            *to = (char)byte;
            from += 3;
        } else {
            *to = *from++;
        }
    }
    *to = 0;
}

/* Index of a material's texture, or -1 if it has none. False if it names one that cannot be read. */
static bool read_texture(struct import *in, const struct aiMaterial *from, enum aiTextureType type, bool srgb,
                         int *out_index)
{
    struct aiString name;
    unsigned channel = 0;
    *out_index = -1;
    if (aiGetMaterialTexture(from, type, 0, &name, NULL, &channel, NULL, NULL, NULL, NULL) !=
        aiReturn_SUCCESS)
        return true;
    if (channel > 0) rnd_scene_unsupported(in->scene, "second texture coordinates");

    if (name.data[0] == '*') { /* embedded */
        const unsigned long i = strtoul(name.data + 1, NULL, 10);
        if (i >= in->file->mNumTextures || in->file->mTextures[i]->mHeight != 0)
            return fail(in, "an embedded texture is not a compressed image");
        const struct aiTexture *texture = in->file->mTextures[i];
        char label[300]; /* OpenImageIO goes by the ending */
        snprintf(label, sizeof label, "%.200s: texture %lu.%s", in->path, i,
                 strcmp(texture->achFormatHint, "jpeg") == 0 ? "jpg" : texture->achFormatHint);
        *out_index = rnd_texture_add(in->scene, label, texture->pcData, texture->mWidth, srgb, in->error);
        return *out_index >= 0;
    }
    char path[4096];
    if (snprintf(path, sizeof path, "%s%s", name.data[0] == '/' ? "" : in->directory, name.data) >=
        (int)sizeof path)
        return fail(in, "a texture's path is too long");
    for (char *c = path; *c; c++)
        if (*c == '\\') *c = '/';
    if (in->gltf && access(path, F_OK) != 0) decode_percent(path + strlen(path) - name.length);
    *out_index = rnd_texture_add(in->scene, path, NULL, 0, srgb, in->error);
    return *out_index >= 0;
}

static vec3s read_colour(const struct aiMaterial *from, const char *key, vec3s otherwise)
{
    struct aiColor4D c;
    if (aiGetMaterialColor(from, key, 0, 0, &c) != aiReturn_SUCCESS) return otherwise;
    return (vec3s){{c.r, c.g, c.b}};
}

static float read_float(const struct aiMaterial *from, const char *key, float otherwise)
{
    ai_real value;
    return aiGetMaterialFloatArray(from, key, 0, 0, &value, NULL) == aiReturn_SUCCESS ? value : otherwise;
}

/* Keys as text: assimp's macros expand to (key, type, index). */
#define KEY(macro)             KEY_(macro)
#define KEY_(key, type, index) key

static bool read_gltf_material(struct import *in, const struct aiMaterial *from, struct rnd_material *to)
{
    int sides = 0;
    to->base = read_colour(from, KEY(AI_MATKEY_BASE_COLOR), to->base);
    to->metallic = read_float(from, KEY(AI_MATKEY_METALLIC_FACTOR), 1.0f);
    to->roughness = read_float(from, KEY(AI_MATKEY_ROUGHNESS_FACTOR), 1.0f);
    to->ior = read_float(from, KEY(AI_MATKEY_REFRACTI), 1.5f);
    to->emission = read_colour(from, KEY(AI_MATKEY_COLOR_EMISSIVE), glms_vec3_zero());
    aiGetMaterialIntegerArray(from, AI_MATKEY_TWOSIDED, &sides, NULL);
    to->double_sided = sides != 0;
    if (!read_texture(in, from, aiTextureType_BASE_COLOR, true, &to->map[RND_MAP_BASE].texture) ||
        !read_texture(in, from, aiTextureType_METALNESS, false, &to->map[RND_MAP_METAL_ROUGH].texture) ||
        !read_texture(in, from, aiTextureType_EMISSIVE, true, &to->map[RND_MAP_EMISSION].texture))
        return false;
    const float transmission = read_float(from, KEY(AI_MATKEY_TRANSMISSION_FACTOR), 0.0f);
    if (transmission >= 0.5f) to->kind = RND_RICH;
    if (transmission > 0.0f && transmission < 1.0f) rnd_scene_unsupported(in->scene, "partial transmission");
    if (transmission > 0.0f && to->roughness > 0.0f) rnd_scene_unsupported(in->scene, "rough transmission");
    return true;
}

/* Wavefront MTL: illum 3 and 5 are mirrors, 4, 6, 7 and 9 glass, 2 a glossy coat when Ks is not black. */
static bool read_mtl_material(struct import *in, const struct aiMaterial *from, struct rnd_material *to)
{
    int illum = 1;
    aiGetMaterialIntegerArray(from, AI_MATKEY_OBJ_ILLUM, &illum, NULL);
    const vec3s ks = read_colour(from, KEY(AI_MATKEY_COLOR_SPECULAR), glms_vec3_zero());
    const float ns = read_float(from, KEY(AI_MATKEY_SHININESS), 0.0f);
    to->base = read_colour(from, KEY(AI_MATKEY_COLOR_DIFFUSE), to->base);
    to->emission = read_colour(from, KEY(AI_MATKEY_COLOR_EMISSIVE), glms_vec3_zero());
    to->ior = read_float(from, KEY(AI_MATKEY_REFRACTI), 1.5f);
    to->double_sided = true;
    to->metallic = 0.0f;
    to->specular = 0.0f;
    if (!read_texture(in, from, aiTextureType_DIFFUSE, true, &to->map[RND_MAP_BASE].texture) ||
        !read_texture(in, from, aiTextureType_EMISSIVE, true, &to->map[RND_MAP_EMISSION].texture))
        return false;
    const bool shiny = rnd_luminance(ks.raw) > 0.0f;
    if ((illum == 4 || illum == 6 || illum == 7 || illum == 9) && to->ior > 1.0f) {
        to->kind = RND_RICH;
        to->base = glms_vec3_one();
    } else if ((illum == 3 || illum == 5) && shiny) {
        to->base = ks;
        to->metallic = 1.0f;
        to->roughness = 0.0f;
        to->map[RND_MAP_BASE].texture = -1;
    } else if (illum == 2 && shiny && ns > 1.0f) {
        to->specular = 1.0f;
        to->roughness =
            sqrtf(sqrtf(2.0f / (ns + 2.0f))); /* Phong's exponent to GGX alpha, then to roughness */
    }
    return true;
}

static const char *material_name(const void *context, uint32_t index)
{
    const struct import *in = context;
    const struct aiMaterialProperty *name;
    if (aiGetMaterialProperty(in->file->mMaterials[index], AI_MATKEY_NAME, &name) != aiReturn_SUCCESS)
        return "";
    return name->mDataLength > 4 ? name->mData + 4 : ""; /* a length of four bytes, then text and its end */
}

static bool read_materials(struct import *in)
{
    struct rnd_scene *scene = in->scene;
    scene->material_count = in->file->mNumMaterials;
    scene->material = calloc(scene->material_count ? scene->material_count : 1, sizeof *scene->material);
    if (!scene->material) return fail(in, "not enough memory");
    for (uint32_t i = 0; i < scene->material_count; i++) {
        struct rnd_material *to = &scene->material[i];
        *to = (struct rnd_material){.kind = RND_METAL_ROUGH,
                                    .base = {{0.8f, 0.8f, 0.8f}},
                                    .alpha = 1.0f,
                                    .alpha_cutoff = 0.5f,
                                    .roughness = 1.0f,
                                    .specular = 1.0f,
                                    .specular_colour = {{1.0f, 1.0f, 1.0f}},
                                    .ior = 1.5f,
                                    .thin = true,
                                    .normal_scale = 1.0f,
                                    .clearcoat_normal_scale = 1.0f};
        for (int use = 0; use < RND_MAPS; use++) to->map[use].texture = -1;
        if (!(in->gltf ? read_gltf_material : read_mtl_material)(in, in->file->mMaterials[i], to))
            return false;
    }
    if (!rnd_import_gltf_extras(scene, in->path, material_name, in, in->error)) return false;
    for (uint32_t i = 0; i < scene->material_count; i++) {
        struct rnd_material *m = &scene->material[i];
        m->f0 = powf((m->ior - 1.0f) / (m->ior + 1.0f), 2.0f) * m->specular;
        const bool lambert =
            m->specular == 0.0f && m->metallic == 0.0f && m->map[RND_MAP_METAL_ROUGH].texture < 0;
        if (m->kind == RND_METAL_ROUGH && lambert) m->kind = RND_DIFFUSE;
        if (!isfinite(rnd_luminance(m->base.raw)) || !isfinite(rnd_luminance(m->emission.raw)) ||
            !isfinite(m->roughness) || !isfinite(m->metallic) || !(m->ior >= 1.0f) ||
            rnd_luminance(m->emission.raw) < 0.0f)
            return fail(in, "a material has a value that is not finite or out of range");
    }
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

static bool read_vertices(struct import *in, const struct aiMesh *from, const struct aiMatrix4x4 *world,
                          struct rnd_mesh *to)
{
    /* Normals go by the inverse transpose, that is by the cofactors. */
    struct aiMatrix4x4 inverse = *world;
    aiMatrix4Inverse(&inverse);
    aiTransposeMatrix4(&inverse);
    for (uint32_t i = 0; i < to->vertices; i++) {
        const vec3s p = transform(world, &from->mVertices[i], 1.0f);
        if (!(fabsf(p.x) <= MAX_COORDINATE && fabsf(p.y) <= MAX_COORDINATE && fabsf(p.z) <= MAX_COORDINATE)) {
            char what[160];
            snprintf(what, sizeof what, "vertex %u of mesh \"%.60s\" is not finite or beyond %g m", i,
                     from->mName.data, (double)MAX_COORDINATE);
            return fail(in, what);
        }
        memcpy(to->position + 3 * (size_t)i, p.raw, sizeof p);
        for (int k = 0; k < 3; k++) {
            in->scene->info.bounds[0][k] = fminf(in->scene->info.bounds[0][k], p.raw[k]);
            in->scene->info.bounds[1][k] = fmaxf(in->scene->info.bounds[1][k], p.raw[k]);
        }
        if (to->normal) {
            const vec3s n = glms_vec3_normalize(transform(&inverse, &from->mNormals[i], 0.0f));
            memcpy(to->normal + 3 * (size_t)i, n.raw, sizeof n);
        }
        if (to->uv[0]) {
            const struct aiVector3D *t = &from->mTextureCoords[0][i];
            to->uv[0][2 * (size_t)i] = fabsf(t->x) <= MAX_COORDINATE ? t->x : 0.0f;
            to->uv[0][2 * (size_t)i + 1] = fabsf(t->y) <= MAX_COORDINATE ? t->y : 0.0f;
        }
    }
    return true;
}

static bool read_mesh(struct import *in, const struct aiMesh *from, const struct aiMatrix4x4 *world)
{
    struct rnd_scene *scene = in->scene;
    uint32_t triangles = 0;
    for (uint32_t f = 0; f < from->mNumFaces; f++) triangles += from->mFaces[f].mNumIndices == 3;
    if (triangles == 0) return true;
    scene->info.triangles += triangles;
    in->vertices += from->mNumVertices;
    if (scene->info.triangles > MAX_TRIANGLES || in->vertices > MAX_TRIANGLES)
        return fail(in, "more than 500 million triangles or vertices");

    struct rnd_mesh *grown = realloc(scene->mesh, (scene->mesh_count + 1) * sizeof *grown);
    if (!grown) return fail(in, "not enough memory");
    scene->mesh = grown;
    struct rnd_mesh *to = &scene->mesh[scene->mesh_count++];
    *to = (struct rnd_mesh){.vertices = from->mNumVertices,
                            .triangles = triangles,
                            .material = from->mMaterialIndex,
                            .first_light = UINT32_MAX};
    const size_t n = from->mNumVertices;
    to->position = malloc((3 * n + 1) * sizeof *to->position);
    to->index = malloc(triangles * sizeof *to->index);
    if (from->mNormals) to->normal = malloc(3 * n * sizeof *to->normal);
    if (from->mTextureCoords[0]) to->uv[0] = malloc(2 * n * sizeof *to->uv[0]);
    if (!to->position || !to->index || (from->mNormals && !to->normal) ||
        (from->mTextureCoords[0] && !to->uv[0]))
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

static bool read_node(struct import *in, const struct aiNode *node, const struct aiMatrix4x4 *parent,
                      int depth)
{
    struct aiMatrix4x4 world = *parent;
    if (depth > RND_NODE_DEPTH) return fail(in, "nodes are nested more than 256 deep");
    aiMultiplyMatrix4(&world, &node->mTransformation);
    for (unsigned i = 0; i < node->mNumMeshes; i++)
        if (!read_mesh(in, in->file->mMeshes[node->mMeshes[i]], &world)) return false;

    for (unsigned i = 0; !in->has_eye && i < in->file->mNumCameras; i++) {
        const struct aiCamera *camera = in->file->mCameras[i];
        if (strcmp(camera->mName.data, node->mName.data) != 0) continue;
        /* assimp repeats a glTF node's translation in its camera, which has no position of its own. */
        const struct aiVector3D origin = {0, 0, 0};
        const vec3s p = transform(&world, in->gltf ? &origin : &camera->mPosition, 1.0f);
        memcpy(in->scene->info.eye, p.raw, sizeof p);
        in->has_eye = isfinite(p.x) && isfinite(p.y) && isfinite(p.z);
    }
    for (unsigned i = 0; i < in->file->mNumLights; i++) {
        const struct aiLight *light = in->file->mLights[i];
        if (strcmp(light->mName.data, node->mName.data) != 0) continue;
        struct rnd_punctual *to = &in->scene->lights.punctual[in->scene->lights.punctual_count];
        const bool spot = light->mType == aiLightSource_SPOT, sun = light->mType == aiLightSource_DIRECTIONAL;
        if (!spot && !sun && light->mType != aiLightSource_POINT) continue;
        if (in->scene->lights.punctual_count == in->file->mNumLights)
            return fail(in, "two nodes share a light");
        *to = (struct rnd_punctual){.kind = sun    ? RND_DIRECTIONAL
                                            : spot ? RND_SPOT
                                                   : RND_POINT,
                                    .position = v3_of(transform(&world, &light->mPosition, 1.0f)),
                                    .direction = v3_of(
                                        glms_vec3_normalize(transform(&world, &light->mDirection, 0.0f))),
                                    .cos_inner = cosf(light->mAngleInnerCone),
                                    .cos_outer = cosf(light->mAngleOuterCone)};
        to->intensity = rnd_v3(light->mColorDiffuse.r, light->mColorDiffuse.g, light->mColorDiffuse.b);
        in->scene->lights.punctual_count++;
    }
    for (unsigned i = 0; i < node->mNumChildren; i++)
        if (!read_node(in, node->mChildren[i], &world, depth + 1)) return false;
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
    in.gltf = dot && (strcasecmp(dot, ".gltf") == 0 || strcasecmp(dot, ".glb") == 0);

    FILE *file = fopen(path, "rb"); /* assimp does not say why it cannot open a file */
    if (!file) return fail(&in, strerror(errno));
    errno = 0;
    const int first = fgetc(file); /* of a directory, this is what fails */
    const int cause = errno;
    fclose(file);
    if (first == EOF) return fail(&in, cause ? strerror(cause) : "is empty");
    if (in.gltf && !rnd_gltf_check(path, out_error)) return false;
    in.file = aiImportFile(path, aiProcess_Triangulate | aiProcess_SortByPType | aiProcess_FlipUVs);
    if (!in.file || !in.file->mRootNode) {
        const char *why = aiGetErrorString();
        fail(&in, why && *why ? why : "holds no scene that can be read");
        goto end;
    }
    for (int k = 0; k < 3; k++) {
        scene->info.bounds[0][k] = INFINITY;
        scene->info.bounds[1][k] = -INFINITY;
    }
    scene->lights.punctual = calloc(in.file->mNumLights + 1, sizeof *scene->lights.punctual);
    struct aiMatrix4x4 identity;
    aiIdentityMatrix4(&identity);
    if (!scene->lights.punctual) {
        fail(&in, "not enough memory");
    } else if (read_node(&in, in.file->mRootNode, &identity, 0) && read_materials(&in)) {
        ok = scene->info.triangles > 0 || fail(&in, "holds no triangle");
    }
    for (uint32_t i = 0; ok && i < scene->mesh_count; i++)
        if (scene->mesh[i].material >= scene->material_count)
            ok = fail(&in, "a mesh names a material that is not there");
    if (ok && !in.has_eye)
        for (int k = 0; k < 3; k++)
            scene->info.eye[k] = 0.5f * (scene->info.bounds[0][k] + scene->info.bounds[1][k]);
end:
    if (in.file) aiReleaseImport(in.file);
    return ok;
}
