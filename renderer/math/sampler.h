/* Random numbers by address: (seed, dimension, index) gives the same pair always; nothing is advanced.
 *
 * Two-dimensional Sobol points, index-shuffled and Owen-scrambled by hashing (Laine and Karras 2011 with
 * Vegdahl's constants); higher dimensions reuse the pair with other seeds (Burley 2020, "padding").
 */
#ifndef FOVEAD_RENDERER_SAMPLER_H
#define FOVEAD_RENDERER_SAMPLER_H

#include "math/v3.h"

#include <stdint.h>

RND_INLINE uint32_t rnd_hash(uint32_t x)
{
    x ^= x >> 16, x *= 0x7feb352du;
    x ^= x >> 15, x *= 0x846ca68bu;
    return x ^ x >> 16;
}

RND_INLINE uint32_t rnd_hash2(uint32_t a, uint32_t b)
{
    return rnd_hash(a + 0x9e3779b9u * rnd_hash(b));
}

RND_INLINE uint32_t rnd_reverse(uint32_t x)
{
    x = __builtin_bswap32(x);
    x = (x >> 4 & 0x0f0f0f0fu) | (x & 0x0f0f0f0fu) << 4;
    x = (x >> 2 & 0x33333333u) | (x & 0x33333333u) << 2;
    return (x >> 1 & 0x55555555u) | (x & 0x55555555u) << 1;
}

/* A random permutation in which every bit depends on lower ones only: Owen's scramble of bit-reversed
 * numbers. */
RND_INLINE uint32_t rnd_permute(uint32_t x, uint32_t seed)
{
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= seed >> 16 | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}

/* The second Sobol dimension, bit-reversed: the Pascal triangle mod 2 applied to the bits of the index. */
RND_INLINE uint32_t rnd_pascal(uint32_t x)
{
    x ^= x >> 1 & 0x55555555u;
    x ^= x >> 2 & 0x33333333u;
    x ^= x >> 4 & 0x0f0f0f0fu;
    x ^= x >> 8 & 0x00ff00ffu;
    return x ^ (x >> 16 & 0x0000ffffu);
}

/* 32 random bits to [0,1). */
RND_INLINE float rnd_unit(uint32_t x)
{
    return (float)(int32_t)(x >> 8) * 0x1p-24f; /* signed: vectors have no other conversion */
}

struct rnd_two {
    float u, v;
};

/* The point of this index in the sequence of this seed and dimension; both coordinates in [0,1). */
RND_INLINE struct rnd_two rnd_two(uint32_t seed, uint32_t dimension, uint32_t index)
{
    const uint32_t s = rnd_hash2(seed, dimension);
    const uint32_t i = rnd_reverse(rnd_permute(rnd_reverse(index), s));
    return (struct rnd_two){rnd_unit(rnd_reverse(rnd_permute(i, s * 0x9e3779b1u + 1u))),
                            rnd_unit(rnd_reverse(rnd_permute(rnd_pascal(i), s * 0x85ebca6bu + 2u)))};
}

RND_INLINE void rnd_pair(uint32_t seed, uint32_t dimension, uint32_t index, float out[2])
{
    const struct rnd_two two = rnd_two(seed, dimension, index);
    out[0] = two.u;
    out[1] = two.v;
}

/* Two further numbers for what needs no good distribution: which texel of four. */
RND_INLINE void rnd_dither(uint32_t seed, uint32_t index, uint32_t which, float *out_r, float *out_s)
{
    const uint32_t h = rnd_hash(seed ^ (index * 0x9e3779b9u + which * 0x85ebca6bu));
    *out_r = (float)(int32_t)(h & 0xffffu) * 0x1p-16f;
    *out_s = (float)(int32_t)(h >> 16) * 0x1p-16f;
}

#endif
