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

/* How long the fade to the new tile takes, ms; 0: no fade. In the fovea there is no fade. Elsewhere it is so
 * long that no 100 ms of it change more than rnd_visible_flicker(), but never longer than
 * DMN_LONGEST_FADE_MS. A change of at most rnd_visible_flicker() needs no fade. */
uint32_t dmn_fade_ms(float eccentricity_deg, float pixels_per_degree, float error, uint64_t before,
                     uint64_t now);

/* Like dmn_fade_ms(), for the tile (level, x, y) of a pyramid. sent has the tiles that the client was sent
 * (see next.h); now has the paths and the error of the tile that is about to be sent. 0 if the client shows
 * nothing there yet. */
uint32_t dmn_fade_of(const struct dmn_pyramid *pyramid, const struct dmn_tile *sent, const float gaze[3],
                     int level, int x, int y, const struct dmn_tile *now);

#endif
