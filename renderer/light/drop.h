/* Small angles: 1 - cosine instead of the cosine. */
#ifndef FOVEAD_RENDERER_DROP_H
#define FOVEAD_RENDERER_DROP_H

#include "math/v3.h"

#include <math.h>

/* 1 - cosine of the angle between two unit vectors: half the squared distance between their ends. To subtract
 * the cosine from 1 would round all angles below 0.02 degrees to 0. */
RND_INLINE float rnd_drop(struct rnd_v3 a, struct rnd_v3 b)
{
    const struct rnd_v3 chord = rnd_v3_sub(a, b);
    return 0.5f * rnd_v3_dot(chord, chord);
}

/* The same for an angle, rad. */
static inline float rnd_drop_of(double angle)
{
    const double s = sin(0.5 * angle);
    return (float)(2.0 * s * s);
}

#endif
