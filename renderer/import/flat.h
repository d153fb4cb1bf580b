/* A scene as its file has it, in one piece of memory without pointers: how fovead-reader hands it over.
 *
 * Places are bytes from the beginning; 0: there is none. Numbers are as this machine has them: both programs
 * are of the same build, which the head says. The reader may have been taken over by a hostile file and may
 * have written anything: every part is checked before it is used. */
#ifndef FOVEAD_RENDERER_FLAT_H
#define FOVEAD_RENDERER_FLAT_H

#include "scene/scene.h"

#define RND_FLAT_MAGIC "fovead " FOVEAD_VERSION

struct rnd_flat_list {
    uint64_t at, count;
};

struct rnd_flat_mesh {
    uint32_t vertices, triangles, material, instanced;
    uint64_t position, normal, uv[2], colour, tangent, index; /* as struct rnd_mesh has them */
};

struct rnd_flat_texture {
    uint64_t use;
    uint64_t path;             /* place of a text */
    struct rnd_flat_list file; /* bytes of an image in memory; 0: none */
};

struct rnd_flat_head {
    char magic[24];
    uint64_t layout;                /* rnd_flat_layout() */
    struct rnd_flat_list mesh;      /* struct rnd_flat_mesh */
    struct rnd_flat_list material;  /* struct rnd_material, without its glass */
    struct rnd_flat_list texture;   /* struct rnd_flat_texture */
    struct rnd_flat_list instance;  /* struct rnd_instance */
    struct rnd_flat_list punctual;  /* struct rnd_punctual */
    struct rnd_flat_list files;     /* bytes of paths, as struct rnd_files has them */
    uint64_t warnings, unsupported; /* places of texts */
    double camera[3], bounds[2][3], origin[3];
};

/* A number that differs between builds whose structures have other sizes. */
static inline uint64_t rnd_flat_layout(void)
{
    return sizeof(struct rnd_material) << 40 | sizeof(struct rnd_instance) << 20 |
           sizeof(struct rnd_punctual);
}

#endif
