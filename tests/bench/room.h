/* A small room for measurements, as glTF: a bumpy floor, walls, 16 balls around the camera and a panel above
 * them, under an even sky. The same room can have one more feature. */
#ifndef FOVEAD_BENCH_ROOM_H
#define FOVEAD_BENCH_ROOM_H

#include <stdbool.h>

#include "renderer.h"

/* A material, and what it needs of its meshes. */
struct room_surface {
    const char *material; /* glTF JSON with ' instead of "; room.c has its images */
    bool colours;         /* the vertices have colours */
};

enum room_parts {
    ROOM_NOTHING,
    ROOM_ALL,          /* floor, walls, balls, panel */
    ROOM_BALLS,        /* only the balls, which are closed */
    ROOM_PANEL,        /* only the panel, as 12 triangles */
    ROOM_MESHED_PANEL, /* only the panel, as 10000 triangles */
    ROOM_HIDDEN,       /* a ball under the floor, where no ray comes */
    ROOM_UNUSED,       /* a ball that is in the file but not in the scene */
};

struct room {
    const char *plain; /* material of the parts without the surface */
    struct room_surface surface;
    enum room_parts parts; /* which parts have the surface */
    enum room_parts
        punctual;   /* three punctual lights: ROOM_ALL, ROOM_UNUSED (in the file only), ROOM_NOTHING */
    bool instances; /* the balls are one mesh in 16 places, not 16 meshes */
};

/* Write the buffer, images and sky that all rooms share into the directory. False and a line in out_error if
 * that fails. */
bool room_prepare(const char *directory, char out_error[RND_ERROR_SIZE]);
/* Write the room over the former one, and load it. NULL and a line in out_error if that fails. The caller
 * destroys the scene. */
struct rnd_scene *room_load(const char *directory, const struct room *room, bool sun,
                            char out_error[RND_ERROR_SIZE]);
/* Remove the directory and all files that these functions have written into it. */
void room_remove(const char *directory);

#endif
