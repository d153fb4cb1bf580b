/* Textures of a scene: RGBA with mipmaps, and how they are looked up. */
#ifndef FOVEAD_RENDERER_TEXTURE_H
#define FOVEAD_RENDERER_TEXTURE_H

#include "math/v3.h"
#include "renderer.h"
#include "scene/pixels.h"
#include "math/srgb.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { RND_MAX_LEVELS = 16 };

/* How a texture continues outside of [0,1). */
enum rnd_wrap { RND_REPEAT, RND_MIRROR, RND_CLAMP };

struct rnd_level {
    int width, height;
    size_t first; /* its first texel */
};

struct rnd_texture {
    char *path;
    enum rnd_pixels_use use;
    const void *file; /* bytes of a file in memory, which the scene owns; or NULL */
    size_t file_bytes;
    bool first;     /* asked for before the tree and the lights can be built */
    bool has_alpha; /* the file has a channel for it; else it is 1 everywhere */
    int levels;     /* 0: not read */
    char *error;    /* why it cannot be read: a line, or NULL */
    struct {        /* what a reader says of the file; 0: it was not asked */
        int width, height;
        bool bytes;
    } measured;
    int skip;        /* number of finest levels that are left out, as there is no room for them */
    float log2_size; /* of the square root of the finest level's texels */
    struct rnd_level level[RND_MAX_LEVELS]; /* each half as large as the one before, down to one texel */
    uint8_t *bytes;                         /* RGBA, levels one behind the other; NULL if floats */
    float *floats;
};

struct rnd_texel {
    float r, g, b, a; /* linear */
};

void rnd_texture_finish(struct rnd_texture *texture);

/* A texture coordinate brought into [0, 1]. */
RND_INLINE float rnd_wrap(float u, uint8_t mode)
{
    const float whole = floorf(u), part = u - whole;
    if (mode == RND_CLAMP) return fmaxf(0.0f, fminf(u, 1.0f));
    if (mode == RND_MIRROR && fmodf(fabsf(whole), 2.0f) == 1.0f) return 1.0f - part;
    return part;
}

/* Index of the texel at column x and row y of a level, each at most its size outside of it. */
RND_INLINE size_t rnd_texel_index(const struct rnd_level *level, const uint8_t wrap[2], int x, int y)
{
    const int w = level->width, h = level->height;
    x = x < 0 ? (wrap[0] == RND_REPEAT ? x + w : 0) : x >= w ? (wrap[0] == RND_REPEAT ? x - w : w - 1) : x;
    y = y < 0 ? (wrap[1] == RND_REPEAT ? y + h : 0) : y >= h ? (wrap[1] == RND_REPEAT ? y - h : h - 1) : y;
    return level->first + (size_t)y * (size_t)w + (size_t)x;
}

RND_INLINE struct rnd_texel rnd_texture_texel(const struct rnd_texture *texture, size_t i)
{
    if (texture->floats) {
        const float *f = texture->floats + 4 * i;
        return (struct rnd_texel){f[0], f[1], f[2], f[3]};
    }
    const uint8_t *b = texture->bytes + 4 * i;
    if (texture->use != RND_PIXELS_DATA)
        return (struct rnd_texel){rnd_srgb_decode(b[0]), rnd_srgb_decode(b[1]), rnd_srgb_decode(b[2]),
                                  b[3] * (1.0f / 255.0f)};
    return (struct rnd_texel){b[0] * (1.0f / 255.0f), b[1] * (1.0f / 255.0f), b[2] * (1.0f / 255.0f),
                              b[3] * (1.0f / 255.0f)};
}

/* The texel that stands for (u, v) when its neighbours are chosen by two random numbers in [0, 1) with the
 * weights of bilinear interpolation (1/2 and 1/2: the nearest one): the mean over the numbers is the
 * interpolated value, at a fourth of the price (Pharr et al. 2024, "Filtering after shading with stochastic
 * texture filtering"). */
RND_INLINE size_t rnd_texture_pick(const struct rnd_texture *texture, const uint8_t wrap[2], float u, float v,
                                   int level, float r, float s)
{
    const struct rnd_level *l = &texture->level[level];
    const float x = rnd_wrap(u, wrap[0]) * (float)l->width - 0.5f + r,
                y = rnd_wrap(v, wrap[1]) * (float)l->height - 0.5f + s;
    return rnd_texel_index(l, wrap, (int)floorf(x), (int)floorf(y));
}

/* In the finest level: bilinear, or the nearest texel. */
struct rnd_texel rnd_texture_at(const struct rnd_texture *texture, const uint8_t wrap[2], bool nearest,
                                float u, float v);

#endif
