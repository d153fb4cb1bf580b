/* Channels: what files and viewers are given of each pixel of a film: its radiance, what is known of that,
 * and the planes that the film keeps. */
#ifndef FOVEAD_RENDERER_CHANNELS_H
#define FOVEAD_RENDERER_CHANNELS_H

#include "film/tile.h"

int rnd_film_channels(const struct rnd_film *film); /* their number */

/* The name of a channel; *out_floats: halves would not hold its values, whatever these are. */
const char *rnd_film_channel(const struct rnd_film *film, int index, bool *out_floats);

/* All channels of each pixel of a tile whose lock is held: RND_TILE_PIXELS x channels floats; 0 where no path
 * is. See rnd_render_read_channels(). */
void rnd_film_read_channels(const struct rnd_film *film, struct rnd_film_tile *tile, float *out);

#endif
