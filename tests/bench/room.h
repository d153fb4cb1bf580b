/* A small room for measurements, as glTF: a bumpy floor, walls, 16 balls around the camera and a panel above
 * them, under an even sky; and the same room with one feature more. */
#ifndef FOVEAD_BENCH_ROOM_H
#define FOVEAD_BENCH_ROOM_H

#include <stdbool.h>

#include "renderer.h"

/* A material and what goes with it. */
struct room_surface {
    const char *material; /* glTF's JSON, with ' for "; see the images in room.c */
    bool colours;         /* the vertices have colours */
};

enum room_parts {
    ROOM_NOTHING,
    ROOM_ALL,          /* floor, walls, balls, panel */
    ROOM_BALLS,        /* these alone, which are closed */
    ROOM_PANEL,        /* of 12 triangles */
    ROOM_MESHED_PANEL, /* the same of 10000 */
    ROOM_HIDDEN,       /* a ball under the floor, where no ray comes */
    ROOM_UNUSED,       /* a ball that is in the file and not in the scene */
};

struct room {
    const char *plain; /* material of the parts that do not have the look */
    struct room_surface surface;
    enum room_parts parts; /* that have it */
    enum room_parts
        punctual;   /* three punctual lights: ROOM_ALL, ROOM_UNUSED (in the file only), ROOM_NOTHING */
    bool instances; /* the balls are one mesh in 16 places, not 16 meshes */
};

/* Write what all rooms share, the buffer, images and sky, into the directory; false and a line in out_error
 * if that fails. */
bool room_prepare(const char *directory, char out_error[RND_ERROR_SIZE]);
/* Write the room, over the former one, and load it; NULL and a line in out_error if that fails. The caller
 * destroys. */
struct rnd_scene *room_load(const char *directory, const struct room *room, bool sun,
                            char out_error[RND_ERROR_SIZE]);
/* Remove the directory and what the above have put there. */
void room_remove(const char *directory);

#endif
