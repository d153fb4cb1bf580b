/* What readers of scene files share: they hand over meshes in coordinates of their own, and say where these,
 * lights and the camera are. What is in many places becomes instances; all else is put into the world. */
#ifndef FOVEAD_RENDERER_IMPORT_H
#define FOVEAD_RENDERER_IMPORT_H

#include "renderer.h"
#include "math/affine.h"
#include "scene/scene.h"

enum { RND_NODE_DEPTH = 256 }; /* nodes are no more deeply nested */

/* Most triangles of a scene, and most vertices. A glTF file may name the same bytes many times: it may have
 * RND_LEAST_TRIANGLES, and RND_TRIANGLES_A_BYTE more per byte of its buffers. */
#define RND_MOST_TRIANGLES 500000000ull
enum { RND_LEAST_TRIANGLES = 50000000, RND_TRIANGLES_A_BYTE = 16 };

/* A mesh of the file. */
struct rnd_shape {
    struct rnd_mesh mesh; /* owns its arrays, until the scene takes them */
    const char *name;     /* the file's */
    uint64_t places;      /* that are left to put it */
    bool shared;          /* it is stored once, and instances stand for it */
    bool stored;          /* that has been done: as stored_as of the scene's meshes */
    uint32_t stored_as;
    float low[3], high[3]; /* corners of its box, once a place was counted */
};

struct rnd_import {
    struct rnd_scene *scene;
    const char *path;
    char directory[2048]; /* with its slash, or "" */
    char *error;          /* RND_ERROR_SIZE bytes of the caller's, for one line of what is wrong */
    uint32_t shape_count;
    struct rnd_shape *shape;
    uint64_t most;                /* RND_MOST_TRIANGLES, or less */
    uint64_t triangles, vertices; /* that are in memory */
    uint64_t places;              /* of shapes */
    bool counting;                /* the first of two rounds: places are only counted */
    bool has_camera;
};

/* Put "path: what" on one line into in->error. Returns false. */
bool rnd_import_fail(struct rnd_import *in, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Add a shape, whose arrays it takes in any case; the name must outlive the import. Its material must be one
 * of the scene's. False and a line in in->error if that is too much. */
bool rnd_import_shape(struct rnd_import *in, const struct rnd_mesh *mesh, const char *name);

/* Walk the file's nodes twice, in the same order: walk calls what follows for what it meets. First places are
 * counted, then the scene is filled. False and a line in in->error. */
bool rnd_import_nodes(struct rnd_import *in, bool (*walk)(struct rnd_import *in, void *file), void *file);

/* A shape is there. */
bool rnd_import_place(struct rnd_import *in, uint32_t shape, const struct rnd_affine *world);
/* The camera is there, if this is the first place that it has. */
void rnd_import_camera(struct rnd_import *in, const struct rnd_affine *world, const float position[3]);
/* A light is there; its own position and direction are in its node's coordinates. */
bool rnd_import_light(struct rnd_import *in, struct rnd_punctual light, const struct rnd_affine *world);

void rnd_import_finish(struct rnd_import *in);

/* Index of the scene's texture of this path (or of bytes in memory, named by path), which is read later
 * and once. -1 and a line in out_error if memory is short. */
int rnd_texture_add(struct rnd_scene *scene, const char *path, const void *memory, size_t count,
                    enum rnd_pixels_use use, char out_error[RND_ERROR_SIZE]);

#endif
