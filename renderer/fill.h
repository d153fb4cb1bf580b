/* What is shown of a tile's paths so far. */
#ifndef FOVEAD_RENDERER_FILL_H
#define FOVEAD_RENDERER_FILL_H

#include "renderer.h"

/* What has reached a pixel of a tile at any level. */
struct rnd_sum {
    float light[3]; /* mean radiance, summed over the parts of the pixel's area that have paths */
    float area;     /* how many such parts there are */
    float paths;
    float hits; /* of the paths, about how many found light */
};

struct rnd_sums {
    struct rnd_sum pixel[RND_TILE * RND_TILE];
};

/* Fill RND_TILE x RND_TILE x RGB floats. Every square of 2^n x 2^n pixels that has a path shows the mean over
 * those of its four parts that have one, unless a larger one lends it light or borrows some. False if there
 * is no path at all. */
bool rnd_fill(const struct rnd_sums *sums, float *out_rgb);

#endif
