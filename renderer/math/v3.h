/* Three floats for the hot loops: plain, inlined, with nothing that keeps a compiler from doing many at once.
 * Everywhere else vectors are cglm's. */
#ifndef FOVEAD_RENDERER_V3_H
#define FOVEAD_RENDERER_V3_H

#include <math.h>

/* Functions that must become part of the loop that calls them, or it stays scalar. */
#define RND_INLINE static inline __attribute__((always_inline, unused))

/* As fmaxf and fminf, which are calls where NaN matters; here a NaN in a gives b. */
RND_INLINE float rnd_larger(float a, float b)
{
    return a > b ? a : b;
}

RND_INLINE float rnd_smaller(float a, float b)
{
    return a < b ? a : b;
}

struct rnd_v3 {
    float x, y, z;
};

RND_INLINE struct rnd_v3 rnd_v3(float x, float y, float z)
{
    return (struct rnd_v3){x, y, z};
}

RND_INLINE struct rnd_v3 rnd_v3_add(struct rnd_v3 a, struct rnd_v3 b)
{
    return rnd_v3(a.x + b.x, a.y + b.y, a.z + b.z);
}

RND_INLINE struct rnd_v3 rnd_v3_mul(struct rnd_v3 a, struct rnd_v3 b)
{
    return rnd_v3(a.x * b.x, a.y * b.y, a.z * b.z);
}

RND_INLINE struct rnd_v3 rnd_v3_scale(struct rnd_v3 a, float s)
{
    return rnd_v3(a.x * s, a.y * s, a.z * s);
}

/* a s + b */
RND_INLINE struct rnd_v3 rnd_v3_muladd(struct rnd_v3 a, float s, struct rnd_v3 b)
{
    return rnd_v3(a.x * s + b.x, a.y * s + b.y, a.z * s + b.z);
}

RND_INLINE float rnd_v3_dot(struct rnd_v3 a, struct rnd_v3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

RND_INLINE struct rnd_v3 rnd_v3_sub(struct rnd_v3 a, struct rnd_v3 b)
{
    return rnd_v3(a.x - b.x, a.y - b.y, a.z - b.z);
}

RND_INLINE struct rnd_v3 rnd_v3_cross(struct rnd_v3 a, struct rnd_v3 b)
{
    return rnd_v3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

RND_INLINE struct rnd_v3 rnd_v3_select(int condition, struct rnd_v3 a, struct rnd_v3 b)
{
    return rnd_v3(condition ? a.x : b.x, condition ? a.y : b.y, condition ? a.z : b.z);
}

RND_INLINE float rnd_v3_luminance(struct rnd_v3 a)
{
    return 0.2126f * a.x + 0.7152f * a.y + 0.0722f * a.z;
}

RND_INLINE float rnd_v3_sum(struct rnd_v3 a)
{
    return a.x + a.y + a.z;
}

RND_INLINE float rnd_v3_max(struct rnd_v3 a)
{
    return rnd_larger(a.x, rnd_larger(a.y, a.z));
}

/* a is not zero. */
RND_INLINE struct rnd_v3 rnd_v3_normalize(struct rnd_v3 a)
{
    return rnd_v3_scale(a, 1.0f / sqrtf(rnd_v3_dot(a, a)));
}

/* Three unit vectors, right-handed, the last of them given (Duff et al. 2017). */
struct rnd_v3_frame {
    struct rnd_v3 x, y, z;
};

RND_INLINE struct rnd_v3_frame rnd_v3_frame(struct rnd_v3 n)
{
    const float sign = n.z < 0.0f ? -1.0f : 1.0f, a = -1.0f / (sign + n.z), b = n.x * n.y * a;
    return (struct rnd_v3_frame){.x = {1.0f + sign * n.x * n.x * a, sign * b, -sign * n.x},
                                 .y = {b, sign + n.y * n.y * a, -n.y},
                                 .z = n};
}

RND_INLINE struct rnd_v3 rnd_v3_to_local(const struct rnd_v3_frame *f, struct rnd_v3 w)
{
    return rnd_v3(rnd_v3_dot(w, f->x), rnd_v3_dot(w, f->y), rnd_v3_dot(w, f->z));
}

RND_INLINE struct rnd_v3 rnd_v3_to_world(const struct rnd_v3_frame *f, struct rnd_v3 w)
{
    return rnd_v3_muladd(f->x, w.x, rnd_v3_muladd(f->y, w.y, rnd_v3_scale(f->z, w.z)));
}

/* Sine and cosine of a fraction of a turn in [0,1]: polynomials, off by less than 3e-7. */
RND_INLINE void rnd_turn(float turn, float *out_sin, float *out_cos)
{
    const float t = turn - 0.5f, a = fabsf(t);
    /* sin(2 pi turn) = -sin(2 pi t), folded into a quarter either way; the cosine is -cos(2 pi t) */
    const float near = a > 0.25f ? 0.5f - a : a, s = t < 0.0f ? near : -near, c = a - 0.25f;
    const float s2 = s * s, c2 = c * c;
    *out_sin = s * (6.28318531f +
                    s2 * (-41.3417022f +
                          s2 * (81.6052493f + s2 * (-76.7058597f + s2 * (42.0586939f - s2 * 15.0946426f)))));
    *out_cos = c * (6.28318531f +
                    c2 * (-41.3417022f +
                          c2 * (81.6052493f + c2 * (-76.7058597f + c2 * (42.0586939f - c2 * 15.0946426f)))));
}

#endif
