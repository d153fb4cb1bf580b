/* A glTF file beside assimp: its JSON, the bytes behind it, and where its nodes are at the first frame.
 *
 * assimp reads the geometry; what it drops or garbles is read here.
 */
#ifndef FOVEAD_RENDERER_GLTF_H
#define FOVEAD_RENDERER_GLTF_H

#include "renderer.h"
#include "scene/light.h"

#include <assimp/scene.h>
#include <jansson.h>

enum { RND_NODE_DEPTH = 256 };

/* A node's translation, rotation (x, y, z, w) and scale. */
struct rnd_pose {
    float translation[3], rotation[4], scale[3];
};

struct rnd_gltf {
    const char *path;     /* the caller's */
    char *error;          /* RND_ERROR_SIZE bytes of the caller's, for one line of what is wrong */
    char directory[2048]; /* with its slash, or "" */
    json_t *root;
    size_t json_end, file_size; /* of a GLB: where its first chunk ends; 0 for JSON alone */
    struct rnd_pose *pose;      /* of nodes, at the first frame of the first animation */
    bool *moved;                /* is that pose to be used? */
    bool morphs;                /* weights of morph targets that are not 0 are asked for */
};

/* --- gltf.c --- */

/* Read the JSON, and see that its nodes are trees of at most RND_NODE_DEPTH, as glTF 2.0 section 3.5.2 wants
 * them: assimp would follow what is not to the end of memory. False and a line in out_error. */
bool rnd_gltf_open(struct rnd_gltf *gltf, const char *path, char out_error[RND_ERROR_SIZE]);
void rnd_gltf_close(struct rnd_gltf *gltf);

/* Put "path: what" on one line into gltf->error. Returns false. */
bool rnd_gltf_fail(struct rnd_gltf *gltf, const char *what);
/* list[index] of the root, or NULL if the index is no integer or there is none such. */
const json_t *rnd_gltf_at(const struct rnd_gltf *gltf, const char *list, const json_t *index);
const json_t *rnd_gltf_extension(const json_t *object, const char *name);

/* --- gltf_assimp.c --- */

/* The file as assimp imports it, without cameras and lights, and with materials that are only names. Names of
 * materials and nodes are their indices in the file. NULL with the cause in aiGetErrorString(). The caller
 * frees with aiReleaseImport(). */
const struct aiScene *rnd_gltf_import(struct rnd_gltf *gltf, unsigned flags);

/* --- gltf_bytes.c --- */

/* Undo %20 and the like, in place. */
void rnd_gltf_decode_percent(char *text);
/* The bytes of a data URI. NULL if it is not one of base64, or memory is short. The caller frees. */
uint8_t *rnd_gltf_data_uri(const char *uri, size_t *out_count);
/* The bytes of a buffer view. NULL and a line in gltf->error if they are not there. The caller frees. */
uint8_t *rnd_gltf_view(struct rnd_gltf *gltf, const json_t *index, size_t *out_count);
/* How many elements an accessor says it has. */
size_t rnd_gltf_count(const struct rnd_gltf *gltf, const json_t *accessor);
/* Elements first .. first + count of an accessor, n numbers each (its type must have as many), normalised
 * integers as floats, into out. False and a line in gltf->error if they are not there or not finite. */
bool rnd_gltf_floats(struct rnd_gltf *gltf, const json_t *accessor, size_t first, size_t count, int n,
                     float *out);

/* --- gltf_node.c --- */

/* Find the poses of the first frame, and whether it is morphed. False and a line in gltf->error. */
bool rnd_gltf_first_frame(struct rnd_gltf *gltf);
/* Poses of EXT_mesh_gpu_instancing within a node; *out_count is 0 if it does not ask for any. The caller
 * frees. False and a line in gltf->error. */
bool rnd_gltf_node_instances(struct rnd_gltf *gltf, const json_t *node, struct rnd_pose **out_pose,
                             size_t *out_count);
/* The light of KHR_lights_punctual at a node, all but where it is and shines; *out_any: is there one? False
 * and a line in gltf->error. */
bool rnd_gltf_node_light(struct rnd_gltf *gltf, const json_t *node, struct rnd_punctual *out, bool *out_any);

#endif
