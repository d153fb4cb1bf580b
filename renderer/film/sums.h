/* Sums of the film over the pixels of a tile at any level. */
#ifndef FOVEAD_RENDERER_SUMS_H
#define FOVEAD_RENDERER_SUMS_H

#include "film/film.h"

/* What has reached a pixel of a tile at any level. */
struct rnd_sum {
    float light[3]; /* mean radiance, summed over the parts of the pixel's area that have paths */
    float area;     /* how many such parts there are */
    float paths;
    float hits; /* of the paths, about how many found light */
};

struct rnd_sums {
    struct rnd_sum pixel[RND_TILE * RND_TILE];
    struct rnd_camera camera; /* of the paths */
};

/* The sums of the tile (x, y) of a level, and its state: of the level-0 tiles below it together.
 * out_planes (may be NULL, as it must be if the film has none) has room for film->planes.channels floats
 * per pixel: means over the parts of the pixel's area that have paths, 0 where none has. False if a tile
 * was just being emptied, or could not be read since a thread that adds to it was put aside. */
bool rnd_film_sums(const struct rnd_film *film, int level, int x, int y, struct rnd_sums *out_sums,
                   float *out_planes, struct rnd_tile *out_state);

#endif
