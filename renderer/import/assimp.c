/* Scene files that assimp reads: OBJ and other formats, but not glTF. */
#include "import/assimp.h"
#include "import/assimp_file.h"
#include "import/mtl_file.h"
#include "import/mtl_material.h"
#include "light/drop.h"

#include <assimp/cfileio.h>
#include <assimp/cimport.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <stdlib.h>
#include <string.h>

/* --- meshes --- */

static uint32_t count_triangles(const struct aiMesh *mesh)
{
    uint32_t triangles = 0;
    for (uint32_t f = 0; f < mesh->mNumFaces; f++) triangles += mesh->mFaces[f].mNumIndices == 3;
    return triangles;
}

static bool read_vectors(const struct aiVector3D *from, uint32_t count, float **out)
{
    if (!from) return true;
    if (!(*out = malloc((3 * (size_t)count + 1) * sizeof **out))) return false;
    for (size_t i = 0; i < count; i++) {
        (*out)[3 * i] = from[i].x;
        (*out)[3 * i + 1] = from[i].y;
        (*out)[3 * i + 2] = from[i].z;
    }
    (*out)[3 * (size_t)count] = 0.0f;
    return true;
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
            to->uv[set][2 * i] = uv[i].x;
            to->uv[set][2 * i + 1] = uv[i].y;
        }
    }
    const struct aiColor4D *colour = from->mColors[0];
    if (!colour) return true;
    if (!(to->colour = malloc(4 * n * sizeof *to->colour))) return false;
    bool opaque = true; /* assimp leaves alpha 0 if the file has none */
    for (size_t i = 0; i < n && opaque; i++) opaque = colour[i].a == 0.0f;
    for (size_t i = 0; i < n; i++) {
        const float rgba[4] = {colour[i].r, colour[i].g, colour[i].b, opaque ? 1.0f : colour[i].a};
        memcpy(to->colour + 4 * i, rgba, sizeof rgba);
    }
    return true;
}

static bool read_triangles(struct rnd_import *in, const struct aiMesh *from, struct rnd_mesh *to)
{
    uint32_t t = 0;
    if (!(to->index = malloc((to->triangles + 1) * sizeof *to->index)))
        return rnd_import_fail(in, "not enough memory");
    for (uint32_t f = 0; f < from->mNumFaces; f++) {
        const unsigned *i = from->mFaces[f].mIndices;
        if (from->mFaces[f].mNumIndices != 3) continue;
        if (i[0] >= to->vertices || i[1] >= to->vertices || i[2] >= to->vertices)
            return rnd_import_fail(in, "mesh \"%.60s\": a triangle names a vertex that is not there",
                                   from->mName.data);
        memcpy(to->index[t++], i, sizeof *to->index);
    }
    return true;
}

bool rnd_assimp_mesh(struct rnd_import *in, const struct aiMesh *from, uint32_t material, const char *name)
{
    struct rnd_mesh to = {
        .vertices = from->mNumVertices, .triangles = count_triangles(from), .material = material};
    if (material >= in->scene->material_count)
        return rnd_import_fail(in, "mesh \"%.60s\": names a material that is not there", from->mName.data);
    if (!read_triangles(in, from, &to)) {
        rnd_mesh_finish(&to);
        return false;
    }
    if (read_vectors(from->mVertices, to.vertices, &to.position) &&
        read_vectors(from->mNormals, to.vertices, &to.normal) && read_attributes(from, &to))
        return rnd_import_shape(in, &to, name);
    rnd_mesh_finish(&to);
    return rnd_import_fail(in, "not enough memory");
}

/* --- nodes --- */

static struct rnd_affine affine_of(const struct aiMatrix4x4 *m)
{
    const float rows[12] = {m->a1, m->b1, m->c1, m->a2, m->b2, m->c2,
                            m->a3, m->b3, m->c3, m->a4, m->b4, m->c4};
    struct rnd_affine out;
    for (int k = 0; k < 12; k++) out.m[k] = (double)rows[k];
    return out;
}

static struct rnd_v3 v3_of(struct aiVector3D v)
{
    return rnd_v3(v.x, v.y, v.z);
}

/* Cameras and lights that have the node's name. */
static bool read_named(struct rnd_import *in, const struct aiScene *file, const struct aiNode *node,
                       const struct rnd_affine *world)
{
    for (unsigned i = 0; i < file->mNumCameras; i++) {
        const struct aiVector3D at = file->mCameras[i]->mPosition;
        if (strcmp(file->mCameras[i]->mName.data, node->mName.data) == 0)
            rnd_import_camera(in, world, (const float[]){at.x, at.y, at.z});
    }
    for (unsigned i = 0; i < file->mNumLights; i++) {
        const struct aiLight *from = file->mLights[i];
        if (strcmp(from->mName.data, node->mName.data) != 0) continue;
        const bool spot = from->mType == aiLightSource_SPOT, sun = from->mType == aiLightSource_DIRECTIONAL;
        if (!spot && !sun && from->mType != aiLightSource_POINT) continue;
        const struct rnd_punctual light = {
            .position = v3_of(from->mPosition),
            .direction = v3_of(from->mDirection),
            .kind = sun    ? RND_DIRECTIONAL
                    : spot ? RND_SPOT
                           : RND_POINT,
            .intensity = rnd_v3(from->mColorDiffuse.r, from->mColorDiffuse.g, from->mColorDiffuse.b),
            .drop_inner = rnd_drop_of(from->mAngleInnerCone),
            .drop_outer = rnd_drop_of(from->mAngleOuterCone)};
        if (!rnd_import_light(in, light, world)) return false;
    }
    return true;
}

/* A node and those below it. */
static bool walk_node(struct rnd_import *in, const struct aiScene *file, const struct aiNode *node,
                      const struct rnd_affine *parent, int depth)
{
    const struct rnd_affine local = affine_of(&node->mTransformation),
                            world = rnd_affine_multiply(parent, &local);
    if (depth > RND_NODE_DEPTH)
        return rnd_import_fail(in, "nodes are nested more than %d deep", RND_NODE_DEPTH);
    for (unsigned i = 0; i < node->mNumMeshes; i++)
        if (in->shape[node->mMeshes[i]].mesh.triangles > 0 && !rnd_import_place(in, node->mMeshes[i], &world))
            return false;
    if (!read_named(in, file, node, &world)) return false;
    for (unsigned i = 0; i < node->mNumChildren; i++)
        if (!walk_node(in, file, node->mChildren[i], &world, depth + 1)) return false;
    return true;
}

/* The file's unit in metres: an FBX file says how many centimetres it is, which assimp ignores. */
static double unit_of(const struct aiScene *file)
{
    const struct aiMetadata *data = file->mMetaData;
    for (unsigned i = 0; data && i < data->mNumProperties; i++) {
        const struct aiMetadataEntry *value = &data->mValues[i];
        if (strcmp(data->mKeys[i].data, "UnitScaleFactor") != 0) continue;
        const double centimetres = value->mType == AI_FLOAT    ? (double)*(const float *)value->mData
                                   : value->mType == AI_DOUBLE ? *(const double *)value->mData
                                                               : 0.0;
        if (centimetres > 0.0 && isfinite(centimetres)) return 0.01 * centimetres;
    }
    return 1.0;
}

static bool walk(struct rnd_import *in, void *file)
{
    const struct aiScene *scene = file;
    struct rnd_affine metres = rnd_affine_identity();
    const double unit = unit_of(scene);
    for (int k = 0; k < 9; k++) metres.m[k] *= unit;
    return walk_node(in, scene, scene->mRootNode, &metres, 0);
}

/* --- the file --- */

/* Most corners of a face: the time for cutting it into triangles grows with their square. */
enum { MOST_CORNERS = 10000 };

/* Check what the next steps of assimp assume of faces. False and a line. */
static bool check_faces(struct rnd_import *in, const struct aiMesh *mesh)
{
    for (unsigned f = 0; f < mesh->mNumFaces; f++) {
        const struct aiFace *face = &mesh->mFaces[f];
        if (face->mNumIndices == 0 || face->mNumIndices > MOST_CORNERS)
            return rnd_import_fail(in, "mesh \"%.60s\": face %u has %u corners, expected 1 to %d",
                                   mesh->mName.data, f, face->mNumIndices, MOST_CORNERS);
        for (unsigned k = 0; k < face->mNumIndices; k++)
            if (face->mIndices[k] >= mesh->mNumVertices)
                return rnd_import_fail(in, "mesh \"%.60s\": face %u names vertex %u of %u", mesh->mName.data,
                                       f, face->mIndices[k], mesh->mNumVertices);
    }
    return true;
}

/* The file as assimp reads it, cut into triangles. NULL and a line. */
static const struct aiScene *open_file(struct rnd_import *in)
{
    const unsigned flags = aiProcess_Triangulate | aiProcess_SortByPType | aiProcess_FlipUVs;
    struct aiFileIO files = rnd_assimp_files(in);
    const struct aiScene *file = aiImportFileEx(in->path, 0, &files), *cut;
    if (!file || !file->mRootNode) goto fail;
    for (unsigned i = 0; i < file->mNumMeshes; i++)
        if (!check_faces(in, file->mMeshes[i])) {
            aiReleaseImport(file);
            return NULL;
        }
    if ((cut = aiApplyPostProcessing(file, flags))) return cut;
    file = NULL; /* the failure has freed it */
fail:;
    const char *why = aiGetErrorString();
    rnd_import_fail(in, "%s", why && *why ? why : "holds no scene that can be read");
    if (file) aiReleaseImport(file);
    return NULL;
}

static bool read_materials(struct rnd_import *in, const struct aiScene *file)
{
    struct rnd_scene *scene = in->scene;
    scene->material_count = file->mNumMaterials;
    scene->material = calloc(scene->material_count + 1, sizeof *scene->material);
    if (!scene->material) return rnd_import_fail(in, "not enough memory");
    struct rnd_mtl_file mtl;
    bool ok =
        rnd_mtl_file_read(&mtl, in->path, in->directory, scene) || rnd_import_fail(in, "not enough memory");
    for (uint32_t i = 0; ok && i < scene->material_count; i++)
        ok = rnd_mtl_material(in, file, file->mMaterials[i], &mtl, &scene->material[i]);
    rnd_mtl_file_finish(&mtl);
    return ok;
}

bool rnd_import_assimp(struct rnd_import *in)
{
    const struct aiScene *file = open_file(in);
    if (!file) return false;
    in->most = RND_MOST_TRIANGLES;
    bool ok = read_materials(in, file);
    for (unsigned i = 0; ok && i < file->mNumMeshes; i++) { /* shapes are meshes, in their order */
        const struct aiMesh *mesh = file->mMeshes[i];
        ok = rnd_assimp_mesh(in, mesh, mesh->mMaterialIndex, mesh->mName.data);
        if (mesh->mPrimitiveTypes & (aiPrimitiveType_POINT | aiPrimitiveType_LINE))
            rnd_scene_unsupported(in->scene, "points and lines");
    }
    ok = ok && rnd_import_nodes(in, walk, (void *)(uintptr_t)file);
    if (ok && file->mNumAnimations > 0)
        rnd_scene_unsupported(in->scene, "animation (its first frame is shown)");
    aiReleaseImport(file);
    return ok;
}
