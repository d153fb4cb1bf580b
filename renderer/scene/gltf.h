/* A glTF 2.0 file: its JSON, the bytes behind it, the numbers that accessors find in them, and its nodes.
 *
 * Errors name the place in the JSON, as meshes[0].primitives[1].indices, and what was expected there.
 */
#ifndef FOVEAD_RENDERER_GLTF_H
#define FOVEAD_RENDERER_GLTF_H

#include "scene/import.h"

#include <jansson.h>

/* A node's translation, rotation (x, y, z, w) and scale. */
struct rnd_pose {
    float translation[3], rotation[4], scale[3];
};

enum { RND_WHERE_SIZE = 160 }; /* of a place in the JSON */

struct rnd_gltf {
    struct rnd_import *in;
    json_t *root;
    size_t bin_start, bin_size; /* of a GLB: its second chunk's bytes in the file; 0: it has none */
    struct rnd_gltf_buffer {
        uint8_t *bytes; /* NULL: not read yet */
        size_t size;
    } * buffer;
    size_t root_count, *node_root; /* nodes where the scene begins */
    struct rnd_pose *pose;         /* of nodes, at the first frame of the first animation */
    bool *moved;                   /* is that pose to be used? */
    bool *visited;                 /* nodes that a round has met */
    struct rnd_gltf_mesh {
        bool read;
        uint32_t first, count; /* of the import's shapes */
    } * mesh;
    struct rnd_gltf_image {
        bool read;
        int texture;       /* the scene's, or -1 after a warning */
    } (*image)[2];         /* of the file's images: as numbers, and as colours */
    uint64_t bytes, asked; /* of buffers that were read; numbers that were asked for */
    bool morphs;           /* weights of morph targets that are not 0 are asked for */
};

/* --- gltf_json.c --- */

/* Read the JSON and check what is asked for. False and a line in gltf->in->error. */
bool rnd_gltf_open(struct rnd_gltf *gltf, struct rnd_import *in);
void rnd_gltf_close(struct rnd_gltf *gltf);

const json_t *rnd_gltf_extension(const json_t *object, const char *name);
/* How many elements a list of the root has. */
size_t rnd_gltf_length(const struct rnd_gltf *gltf, const char *list);
/* Read object[key] as a whole number from 0 to most. A missing key gives otherwise; if otherwise is SIZE_MAX,
 * it is an error. where is the object's place. False and a line in the import's error. */
bool rnd_gltf_size(struct rnd_gltf *gltf, const json_t *object, const char *key, size_t otherwise,
                   size_t most, const char *where, size_t *out);
/* The element that index names; NULL, without a line, if it names none. */
static inline const json_t *rnd_gltf_element(const json_t *list, const json_t *index)
{
    return json_is_integer(index) ? json_array_get(list, (size_t)json_integer_value(index)) : NULL;
}
/* The element of a list of the root that value, at that place, is the index of. NULL and a line. */
const json_t *rnd_gltf_at(struct rnd_gltf *gltf, const char *list, const json_t *value, const char *where,
                          size_t *out_index);
/* Name what the file asks for and is left out. */
void rnd_gltf_name_unsupported(struct rnd_gltf *gltf);

/* --- gltf_bytes.c --- */

/* Count numbers before memory is allocated for them. A file may refer to the same bytes many times, but only
 * up to a limit. False and a line. */
bool rnd_gltf_ask(struct rnd_gltf *gltf, size_t numbers, const char *where);
/* The bytes of a data URI. NULL if it is not one of base64, or memory is short. The caller frees. */
uint8_t *rnd_gltf_data_uri(const char *uri, size_t *out_count);
/* The bytes of a buffer view, the file's until it is closed, and the distance of elements that it asks for,
 * or 0. NULL and a line. */
const uint8_t *rnd_gltf_view(struct rnd_gltf *gltf, const json_t *index, const char *where, size_t *out_size,
                             size_t *out_stride);

/* --- gltf_accessor.c --- */

enum {
    RND_GLTF_BYTE = 5120,
    RND_GLTF_UNSIGNED_BYTE,
    RND_GLTF_SHORT,
    RND_GLTF_UNSIGNED_SHORT,
    RND_GLTF_UNSIGNED_INT = 5125,
    RND_GLTF_FLOAT
};

struct rnd_gltf_accessor {
    size_t count;      /* elements */
    size_t n;          /* numbers of an element, 1 to 4 */
    size_t component;  /* RND_GLTF_... */
    bool normalised;   /* integers stand for -1 to 1, or 0 to 1 */
    size_t stride;     /* bytes from element to element */
    const uint8_t *at; /* the first, or NULL: all are 0 */
    size_t sparse;     /* elements that are elsewhere, at rising indices */
    size_t sparse_component;
    const uint8_t *sparse_index, *sparse_value;
};

/* Find an accessor; all that it says is there is there. False and a line. */
bool rnd_gltf_accessor(struct rnd_gltf *gltf, const json_t *index, const char *where,
                       struct rnd_gltf_accessor *out);
/* Elements first .. first + count as floats, integers normalised as glTF 2.0 section 3.6.2.2 says. */
void rnd_gltf_floats(const struct rnd_gltf_accessor *accessor, size_t first, size_t count, float *out);
/* All elements of an accessor of unsigned integers. */
void rnd_gltf_integers(const struct rnd_gltf_accessor *accessor, uint32_t *out);

/* --- gltf_draco.c --- */

/* Is a primitive's geometry there in Draco's form alone? */
bool rnd_gltf_is_draco(const struct rnd_gltf *gltf, const json_t *primitive);
/* Make a shape of such a primitive. False and a line. */
bool rnd_gltf_draco(struct rnd_gltf *gltf, const json_t *primitive, const char *where, uint32_t material,
                    const char *name);

/* --- gltf_material.c --- */

/* All of the file's materials, in its order, and after them glTF's default. Values out of their range are
 * clamped, with a warning. False and a line. */
bool rnd_gltf_materials(struct rnd_gltf *gltf);

/* --- gltf_mesh.c --- */

/* Make shapes of a mesh's primitives, once. False and a line. */
bool rnd_gltf_read_mesh(struct rnd_gltf *gltf, size_t mesh);

/* --- gltf_node.c --- */

/* See that nodes are trees, and find where the scene begins. False and a line. */
bool rnd_gltf_check_nodes(struct rnd_gltf *gltf);
/* Find the poses of the first frame, and whether it is morphed. False and a line. */
bool rnd_gltf_first_frame(struct rnd_gltf *gltf);
/* Hand all nodes of the scene over: rnd_import_nodes() calls it. */
bool rnd_gltf_walk(struct rnd_import *in, void *gltf);

#endif
