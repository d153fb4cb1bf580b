/* fade: how slowly a client should show a tile, so that the change is not seen as flicker. Pure functions. */
#ifndef FOVEAD_DAEMON_FADE_H
#define FOVEAD_DAEMON_FADE_H

#include "pyramid.h"

/* The longest fade, ms. */
enum { DMN_LONGEST_FADE_MS = 1000 };

/* The relative standard deviation of what changes when a tile is shown with now paths in place of before (0:
 * a coarser tile was shown). error is the tile's relative standard error now, which may be infinite: unknown.
 * A mean of n paths whose standard deviation is s changes by s sqrt(1 / before - 1 / now). */
float dmn_change(float error, uint64_t before, uint64_t now);

/* Milliseconds in which to go over to the tile; 0: at once. In the fovea it is 0. Elsewhere it is so long
 * that a tenth of a second changes no more than rnd_visible_flicker(), or DMN_LONGEST_FADE_MS if that is
 * less. */
uint32_t dmn_fade_ms(float eccentricity_deg, float pixels_per_degree, float error, uint64_t before,
                     uint64_t now);

/* The same of a tile (level, x, y) of a pyramid, for a client that has the tiles in sent (see next.h). now
 * are the paths and the error that the tile is sent with. 0 if the client shows nothing there yet. */
uint32_t dmn_fade_of(const struct dmn_pyramid *pyramid, const struct dmn_tile *sent, const float gaze[3],
                     int level, int x, int y, const struct dmn_tile *now);

#endif
