/* Pyramids of textures. A value of a level is the mean of 2 x 2 values of the level below it, or of fewer at
 * the right and lower border. */
#include "light/pyramid.h"

#include <stdlib.h>

/* Larger values, and NaN, count as 0: light from there is found by chance alone. */
#define MOST 1e12f

struct rnd_pyramid {
    struct rnd_pyramid_of of;
    int levels;                             /* the first is the texture itself */
    struct rnd_level level[RND_MAX_LEVELS]; /* first: index in mean, from the second level on */
    struct rnd_pyramid_mean mean[];
};

static struct rnd_pyramid_mean of_texel(const struct rnd_pyramid_of *of, size_t texel)
{
    const struct rnd_texel t = rnd_texture_texel(of->texture, texel);
    float own = of->channel == RND_PYRAMID_LUMINANCE ? rnd_v3_luminance(rnd_v3(t.r, t.g, t.b))
                : of->channel == RND_PYRAMID_ALPHA   ? t.a
                                                     : t.r;
    if (of->cutoff > 0.0f) own = own >= of->cutoff ? 1.0f : 0.0f;
    if (!(fabsf(own) < MOST)) own = 0.0f;
    return (struct rnd_pyramid_mean){own, own * own};
}

static struct rnd_pyramid_mean at(const struct rnd_pyramid *pyramid, int level, size_t i)
{
    return level > 0 ? pyramid->mean[i] : of_texel(&pyramid->of, i);
}

static void add(struct rnd_pyramid_mean *sum, struct rnd_pyramid_mean mean, float weight)
{
    sum->value += weight * mean.value;
    sum->square += weight * mean.square;
}

static void fill(struct rnd_pyramid *pyramid, int level)
{
    const struct rnd_level *from = &pyramid->level[level - 1], *to = &pyramid->level[level];
    for (int y = 0; y < to->height; y++)
        for (int x = 0; x < to->width; x++) {
            const int right = 2 * x + 1 < from->width, down = 2 * y + 1 < from->height;
            const size_t i = from->first + (size_t)(2 * y) * (size_t)from->width + (size_t)(2 * x);
            const float weight = 1.0f / (float)((1 + right) * (1 + down));
            struct rnd_pyramid_mean sum = {0};
            for (int dy = 0; dy <= down; dy++)
                for (int dx = 0; dx <= right; dx++)
                    add(&sum, at(pyramid, level - 1, i + (size_t)dy * (size_t)from->width + (size_t)dx),
                        weight);
            pyramid->mean[to->first + (size_t)y * (size_t)to->width + (size_t)x] = sum;
        }
}

struct rnd_pyramid *rnd_pyramid_create(const struct rnd_pyramid_of *of)
{
    struct rnd_level level[RND_MAX_LEVELS] = {of->texture->level[0]};
    int levels = 1;
    size_t count = 0;
    level[0].first = 0;
    for (int w = level[0].width, h = level[0].height; (w > 1 || h > 1) && levels < RND_MAX_LEVELS;) {
        w = (w + 1) / 2;
        h = (h + 1) / 2;
        level[levels++] = (struct rnd_level){w, h, count};
        count += (size_t)w * (size_t)h;
    }
    struct rnd_pyramid *pyramid = malloc(sizeof *pyramid + count * sizeof *pyramid->mean);
    if (!pyramid) return NULL;
    pyramid->of = *of;
    pyramid->levels = levels;
    for (int l = 0; l < levels; l++) pyramid->level[l] = level[l];
    for (int l = 1; l < levels; l++) fill(pyramid, l);
    return pyramid;
}

void rnd_pyramid_destroy(struct rnd_pyramid *pyramid)
{
    free(pyramid);
}

void rnd_pyramid_size(const struct rnd_pyramid *pyramid, int out_size[2])
{
    out_size[0] = pyramid->level[0].width;
    out_size[1] = pyramid->level[0].height;
}

bool rnd_pyramid_is(const struct rnd_pyramid *pyramid, const struct rnd_pyramid_of *of)
{
    return pyramid->of.texture == of->texture && pyramid->of.channel == of->channel &&
           pyramid->of.cutoff == of->cutoff;
}

struct rnd_pyramid_mean rnd_pyramid_mean(const struct rnd_pyramid *pyramid, const uint8_t wrap[2], float u,
                                         float v, float least_side)
{
    int l = 0;
    while (l + 1 < pyramid->levels && (float)(1 << l) < least_side) l++;
    const struct rnd_level *level = &pyramid->level[l];
    const float square = 1.0f / (float)(1 << l);
    const float x = rnd_wrap(u, wrap[0]) * (float)pyramid->level[0].width * square - 0.5f,
                y = rnd_wrap(v, wrap[1]) * (float)pyramid->level[0].height * square - 0.5f;
    const float fx = x - floorf(x), fy = y - floorf(y);
    struct rnd_pyramid_mean sum = {0};
    for (int i = 0; i < 4; i++)
        add(&sum,
            at(pyramid, l, rnd_texel_index(level, wrap, (int)floorf(x) + (i & 1), (int)floorf(y) + (i >> 1))),
            (i & 1 ? fx : 1.0f - fx) * (i >> 1 ? fy : 1.0f - fy));
    return sum;
}
