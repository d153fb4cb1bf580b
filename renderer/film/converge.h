/* Judging tiles: how wrong a tile still is, and whether an eye would see it. */
#ifndef FOVEAD_RENDERER_CONVERGE_H
#define FOVEAD_RENDERER_CONVERGE_H

#include "film/tile.h"

/* The tile's error by its half-buffers, and whether it is converged. Call with the lock held, when its paths
 * are in its pixels. */
void rnd_judge(const struct rnd_film *film, struct rnd_film_tile *tile);

/* Take the brightness of the picture, and its grain, from the tiles that have been judged. Call between
 * batches.
 */
void rnd_film_survey(struct rnd_film *film);

/* Cosine of the angle between a direction and the nearest point of a tile. */
float rnd_tile_cosine(const struct rnd_film *film, int x, int y, const float direction[3]);
/* See rnd_tile_settled(). */
bool rnd_film_settled(const struct rnd_film *film, const struct rnd_tile *tile, int x, int y,
                      const float gaze[3]);

#endif
