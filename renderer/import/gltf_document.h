/* A glTF 2.0 file while it is read.
 *
 * Errors name the place in the JSON, as meshes[0].primitives[1].indices, and what was expected there.
 */
#ifndef FOVEAD_RENDERER_GLTF_DOCUMENT_H
#define FOVEAD_RENDERER_GLTF_DOCUMENT_H

#include "import/import.h"

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
    bool *visited;                 /* nodes that the present walk has met */
    struct rnd_gltf_mesh {
        bool read;
        uint32_t first, count; /* of the import's shapes */
    } * mesh;
    struct rnd_gltf_image {
        bool read;
        int texture;       /* index in the scene, or -1 after a warning */
    } (*image)[2];         /* of the file's images, read as numbers and as colours */
    uint64_t bytes, asked; /* of buffers that were read; numbers that were asked for */
    bool morphs;           /* the file uses weights of morph targets that are not 0 */
};

#endif
