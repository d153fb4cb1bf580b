/* Means of a texture's brightness or coverage, and of their squares, over squares of 1, 2, 4, ... texels. No
 * texel is left out, and small values are kept, which mipmaps round to 0. */
#ifndef FOVEAD_RENDERER_PYRAMID_H
#define FOVEAD_RENDERER_PYRAMID_H

#include "scene/texture.h"

/* Which value of a texel is taken. */
struct rnd_pyramid_of {
    const struct rnd_texture *texture;
    enum { RND_PYRAMID_LUMINANCE, RND_PYRAMID_RED, RND_PYRAMID_ALPHA } channel;
    float cutoff; /* if above 0, the value is 1 where the channel is at least cutoff, else 0 */
};

struct rnd_pyramid_mean {
    float value, square; /* mean of the value, and of its square */
};

struct rnd_pyramid;

/* NULL if memory is short. The caller frees; the texture is kept. */
struct rnd_pyramid *rnd_pyramid_create(const struct rnd_pyramid_of *of);
void rnd_pyramid_destroy(struct rnd_pyramid *pyramid); /* accepts NULL */
/* Width and height of the texture. */
void rnd_pyramid_size(const struct rnd_pyramid *pyramid, int out_size[2]);
bool rnd_pyramid_is(const struct rnd_pyramid *pyramid, const struct rnd_pyramid_of *of);

/* Mean around texture coordinates (u, v): bilinear between the means of squares at least least_side texels
 * wide. */
struct rnd_pyramid_mean rnd_pyramid_mean(const struct rnd_pyramid *pyramid, const uint8_t wrap[2], float u,
                                         float v, float least_side);

#endif
