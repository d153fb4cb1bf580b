/* The equirectangular map for the hot loops: sphere.h's, by polynomials and without branches. */
#ifndef FOVEAD_RENDERER_UV_H
#define FOVEAD_RENDERER_UV_H

#include "math/v3.h"

/* Angle of (x, y) from the x axis as a fraction of a turn, -1/2 to 1/2: minimax polynomial of an eighth of a
 * turn; error below 2e-7 rad. (0, 0) has angle 0. */
RND_INLINE float rnd_turn_of(float y, float x)
{
    const float ax = fabsf(x), ay = fabsf(y), low = rnd_smaller(ax, ay),
                high = rnd_larger(rnd_larger(ax, ay), 1e-37f);
    const float t = low / high, t2 = t * t;
    float a = -0.00405395625f;
    a = a * t2 + 0.0218606142f;
    a = a * t2 - 0.0559087264f;
    a = a * t2 + 0.09641916f;
    a = a * t2 - 0.139085128f;
    a = a * t2 + 0.199465416f;
    a = a * t2 - 0.333298589f;
    a = (a * t2 + 0.999999336f) * t * 0.15915494309f;
    a = ay > ax ? 0.25f - a : a;
    a = x < 0.0f ? 0.5f - a : a;
    return y < 0.0f ? -a : a;
}

/* Image coordinates of a unit direction: u in [0, 1), v in [0, 1]. */
RND_INLINE void rnd_v3_to_uv(struct rnd_v3 d, float *out_u, float *out_v)
{
    const float u = 0.5f + rnd_turn_of(d.x, -d.z);
    *out_u = u >= 1.0f ? 0.0f : u;
    *out_v = 0.5f - 2.0f * rnd_turn_of(d.y, sqrtf(d.x * d.x + d.z * d.z));
}

/* Direction at image coordinates in [0, 1]. */
RND_INLINE struct rnd_v3 rnd_v3_from_uv(float u, float v)
{
    float sa, ca, se, ce; /* of half a turn more than the azimuth; of the angle from up */
    rnd_turn(u, &sa, &ca);
    rnd_turn(0.5f * v, &se, &ce);
    return rnd_v3(-se * sa, ce, se * ca);
}

#endif
