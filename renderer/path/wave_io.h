/* What goes into a wave of paths and comes out of it. */
#ifndef FOVEAD_RENDERER_WAVE_IO_H
#define FOVEAD_RENDERER_WAVE_IO_H

#include <stdint.h>

struct rnd_planes;

enum {
    RND_WAVE = 512, /* most paths of a wave */
};

/* Dimension 0 of a path's random numbers is its place within the pixel; the rest are the tracer's. */
enum { RND_DIMENSION_PIXEL, RND_DIMENSION_PATH };

/* What goes into a wave and comes out of it, a path each. */
struct rnd_wave_io {
    uint32_t x[RND_WAVE], y[RND_WAVE]; /* pixel of the film */
    uint32_t number[RND_WAVE];         /* of the pixel's paths, this is which */
    float radiance[3][RND_WAVE];
    const struct rnd_planes *planes; /* what the film keeps of the first surfaces */
    float *plane_values;             /* planes->channels of each path; NULL: it keeps nothing of them */
};

#endif
