/* Primitives of KHR_draco_mesh_compression, decoded by assimp: it is given a GLB of one primitive, and of its
 * geometry alone.
 *
 * assimp 5.2.5 loses indices of 32 bits, so that they are asked for with 16 wherever that is enough.
 */
#include "import/gltf_draco.h"
#include "import/assimp.h"
#include "import/gltf_accessor.h"
#include "import/gltf_bytes.h"
#include "import/gltf_json.h"

#include <assimp/cimport.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <assimp/version.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char extension[] = "KHR_draco_mesh_compression";

/* An accessor of what is decoded: what the file's says, but for its view. NULL and a line if it is not there,
 * or if assimp would not read what it means. */
static json_t *copy_accessor(struct rnd_gltf *gltf, const char *name, const json_t *index, const char *where)
{
    static const char *const keys[] = {"type", "count", "componentType", "normalized"};
    char inside[RND_WHERE_SIZE + 64];
    snprintf(inside, sizeof inside, "%s.%s", where, name);
    const json_t *from = rnd_gltf_at(gltf, "accessors", index, inside, NULL);
    if (!from) return NULL;
    if (json_integer_value(json_object_get(from, "componentType")) != RND_GLTF_FLOAT &&
        strcmp(name, "indices") != 0 && strcmp(name, "COLOR_0") != 0) {
        rnd_import_fail(gltf->in, "%s: integers of %s cannot be read: export the file without compression",
                        inside, extension);
        return NULL;
    }
    json_t *to = json_object();
    for (size_t i = 0; i < sizeof keys / sizeof *keys; i++) {
        json_t *value = json_object_get(from, keys[i]);
        if (value) json_object_set(to, keys[i], value);
    }
    return to;
}

/* The primitive as assimp gets it, its accessors appended. NULL and a line. */
static json_t *copy_primitive(struct rnd_gltf *gltf, const json_t *primitive, const char *where,
                              json_t *accessors)
{
    static const char *const names[] = {"POSITION", "NORMAL", "TEXCOORD_0", "TEXCOORD_1", "COLOR_0"};
    const json_t *attributes = json_object_get(primitive, "attributes"),
                 *ids = json_object_get(rnd_gltf_extension(primitive, extension), "attributes");
    json_t *own = json_object(), *own_ids = json_object(), *accessor;
    json_t *to = json_pack("{s:o, s:{s:{s:i, s:o}}}", "attributes", own, "extensions", extension,
                           "bufferView", 0, "attributes", own_ids);
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        json_t *id = json_object_get(ids, names[i]);
        const json_t *index = json_object_get(attributes, names[i]);
        if (!json_is_integer(id) || !index) continue;
        if (!(accessor = copy_accessor(gltf, names[i], index, where))) goto fail;
        json_object_set_new(own, names[i], json_integer((json_int_t)json_array_size(accessors)));
        json_object_set(own_ids, names[i], id);
        json_array_append_new(accessors, accessor);
    }
    if (!(accessor = copy_accessor(gltf, "indices", json_object_get(primitive, "indices"), where))) goto fail;
    /* the vertices are as many as the first attribute's */
    const json_int_t vertices = json_integer_value(json_object_get(json_array_get(accessors, 0), "count"));
    json_object_set_new(accessor, "componentType",
                        json_integer(vertices <= 65536 ? RND_GLTF_UNSIGNED_SHORT : RND_GLTF_UNSIGNED_INT));
    json_object_set_new(to, "indices", json_integer((json_int_t)json_array_size(accessors)));
    json_array_append_new(accessors, accessor);
    return to;
fail:
    json_decref(to);
    return NULL;
}

static void put_little_endian(uint8_t *to, size_t value)
{
    for (int i = 0; i < 4; i++) to[i] = (uint8_t)(value >> 8 * i & 255);
}

/* A GLB of that JSON and those bytes. NULL if memory is short. The caller frees. */
static char *make_glb(const json_t *root, const uint8_t *bytes, size_t size, size_t *out_size)
{
    char *text = json_dumps(root, JSON_COMPACT);
    const size_t length = text ? strlen(text) : 0, json = (length + 3) & ~(size_t)3,
                 bin = (size + 3) & ~(size_t)3;
    uint8_t *glb = text ? calloc(1, 28 + json + bin) : NULL;
    *out_size = 28 + json + bin;
    if (glb) {
        memcpy(glb, "glTF\2", 5);
        put_little_endian(glb + 8, *out_size);
        put_little_endian(glb + 12, json);
        memcpy(glb + 16, "JSON", 4);
        memset(glb + 20, ' ', json);
        memcpy(glb + 20, text, length);
        put_little_endian(glb + 20 + json, bin);
        memcpy(glb + 24 + json, "BIN", 4);
        memcpy(glb + 28 + json, bytes, size);
    }
    free(text);
    return (char *)glb;
}

/* The file around a primitive: one node, one mesh, one buffer. */
static json_t *wrap(json_t *primitive, json_t *accessors, size_t size)
{
    return json_pack(
        "{s:{s:s}, s:i, s:[{s:[i]}], s:[{s:i}], s:[{s:[o]}], s:O, s:[{s:i, s:I}], s:[{s:I}], s:[s]}", "asset",
        "version", "2.0", "scene", 0, "scenes", "nodes", 0, "nodes", "mesh", 0, "meshes", "primitives",
        primitive, "accessors", accessors, "bufferViews", "buffer", 0, "byteLength", (json_int_t)size,
        "buffers", "byteLength", (json_int_t)size, "extensionsUsed", extension);
}

bool rnd_gltf_is_draco(const struct rnd_gltf *gltf, const json_t *primitive)
{
    const json_t *index = json_object_get(json_object_get(primitive, "attributes"), "POSITION"),
                 *accessor = rnd_gltf_element(json_object_get(gltf->root, "accessors"), index);
    return rnd_gltf_extension(primitive, extension) && !json_object_get(accessor, "bufferView");
}

bool rnd_gltf_draco(struct rnd_gltf *gltf, const json_t *primitive, const char *where, uint32_t material,
                    const char *name)
{
    char inside[RND_WHERE_SIZE + 64];
    size_t size, stride, glb_size = 0;
    snprintf(inside, sizeof inside, "%s.extensions.%s.bufferView", where, extension);
    const uint8_t *bytes =
        rnd_gltf_view(gltf, json_object_get(rnd_gltf_extension(primitive, extension), "bufferView"), inside,
                      &size, &stride);
    json_t *accessors = json_array(),
           *copy = bytes ? copy_primitive(gltf, primitive, where, accessors) : NULL,
           *root = copy ? wrap(copy, accessors, size) : NULL;
    char *glb = root ? make_glb(root, bytes, size, &glb_size) : NULL;
    const json_int_t corners = json_integer_value(
        json_object_get(json_array_get(accessors, json_array_size(accessors) - 1), "count"));
    json_decref(accessors);
    json_decref(root);
    if (!copy) return false;
    if (!glb) return rnd_import_fail(gltf->in, "not enough memory");
    const struct aiScene *file = aiImportFileFromMemory(glb, (unsigned)glb_size, aiProcess_FlipUVs, "glb");
    free(glb);
    const struct aiMesh *mesh = file && file->mNumMeshes == 1 ? file->mMeshes[0] : NULL;
    const bool whole = mesh && (json_int_t)mesh->mNumFaces == corners / 3 && mesh->mNumVertices > 0;
    const bool ok = whole
                        ? rnd_assimp_mesh(gltf->in, mesh, material, name)
                        : rnd_import_fail(gltf->in,
                                          "%s: %s cannot be decoded by assimp %u.%u: export the file without "
                                          "compression",
                                          where, extension, aiGetVersionMajor(), aiGetVersionMinor());
    if (file) aiReleaseImport(file);
    return ok;
}
