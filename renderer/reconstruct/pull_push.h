/* What is shown of a tile's paths so far. */
#ifndef FOVEAD_RENDERER_PULL_PUSH_H
#define FOVEAD_RENDERER_PULL_PUSH_H

#include "film/sums.h"

/* Fill RND_TILE x RND_TILE x RGB floats. Every square of 2^n x 2^n pixels that has a path shows the mean over
 * those of its four parts that have one, unless a larger one lends it light or borrows some. False if there
 * is no path at all. */
bool rnd_pull_push(const struct rnd_sums *sums, float *out_rgb);

#endif
