/* What readers of scene files share. A reader hands over meshes in their own coordinates, and tells where
 * they, lights and cameras are. A mesh with many places becomes instances; all others are moved into the
 * world. */
#ifndef FOVEAD_RENDERER_IMPORT_H
#define FOVEAD_RENDERER_IMPORT_H

#include "renderer.h"
#include "math/affine.h"
#include "scene/scene.h"

enum { RND_NODE_DEPTH = 256 }; /* nodes may be nested no deeper */

/* Most triangles of a scene, and most vertices. A glTF file may name the same bytes many times: it may have
 * RND_LEAST_TRIANGLES, and RND_TRIANGLES_A_BYTE more per byte of its buffers. */
#define RND_MOST_TRIANGLES 500000000ull
enum { RND_LEAST_TRIANGLES = 50000000, RND_TRIANGLES_A_BYTE = 16 };

/* A mesh of the file. */
struct rnd_shape {
    struct rnd_mesh mesh; /* owns its arrays, until the scene takes them */
    const char *name;     /* in the file */
    uint64_t places;      /* where it is still to be put */
    bool shared;          /* it is stored once, and shown by instances */
    bool stored;          /* it is stored, as mesh stored_as of the scene */
    uint32_t stored_as;
    float low[3], high[3]; /* corners of its box, once a place is counted */
};

struct rnd_import {
    struct rnd_scene *scene;
    const char *path;
    char directory[2048]; /* with its slash, or "" */
    char *error;          /* the caller's RND_ERROR_SIZE bytes, for one line */
    uint32_t shape_count;
    struct rnd_shape *shape;
    uint64_t most;                /* RND_MOST_TRIANGLES, or less */
    uint64_t triangles, vertices; /* in memory */
    uint64_t places;              /* of shapes */
    bool counting;                /* in the first of two walks places are only counted */
    bool has_camera;
};

/* Put "path: what" on one line into in->error. Returns false. */
bool rnd_import_fail(struct rnd_import *in, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Add a shape, and own its arrays, also on failure. The name must outlive the import; the material must be
 * one of the scene's. False and a line in in->error if there are too many triangles, or memory is short. */
bool rnd_import_shape(struct rnd_import *in, const struct rnd_mesh *mesh, const char *name);

/* Walk the file's nodes twice, in the same order. walk() calls the functions below for what it meets: in the
 * first walk places are counted, in the second the scene is filled. False and a line in in->error. */
bool rnd_import_nodes(struct rnd_import *in, bool (*walk)(struct rnd_import *in, void *file), void *file);

/* A shape is at that place. */
bool rnd_import_place(struct rnd_import *in, uint32_t shape, const struct rnd_affine *world);
/* A camera is at that place. Only the first one counts. */
void rnd_import_camera(struct rnd_import *in, const struct rnd_affine *world, const float position[3]);
/* A light is at that place; its position and direction are in its node's coordinates. */
bool rnd_import_light(struct rnd_import *in, struct rnd_punctual light, const struct rnd_affine *world);

void rnd_import_finish(struct rnd_import *in);

/* Add a texture to the scene, if it is not there, to be read later: of a path, or of bytes in memory with
 * path as their name. Returns its index; -1 and a line in out_error if memory is short. */
int rnd_texture_add(struct rnd_scene *scene, const char *path, const void *memory, size_t count,
                    enum rnd_pixels_use use, char out_error[RND_ERROR_SIZE]);

#endif
