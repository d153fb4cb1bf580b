/* Textures: their memory, and looking them up in their finest level. */
#include "scene/texture.h"

#include <stdlib.h>

void rnd_texture_finish(struct rnd_texture *texture)
{
    free(texture->path);
    free(texture->error);
    free(texture->bytes);
    free(texture->floats);
    *texture = (struct rnd_texture){0};
}

struct rnd_texel rnd_texture_at(const struct rnd_texture *texture, const uint8_t wrap[2], bool nearest,
                                float u, float v)
{
    if (nearest) return rnd_texture_texel(texture, rnd_texture_pick(texture, wrap, u, v, 0, 0.5f, 0.5f));
    struct rnd_texel sum = {0};
    const struct rnd_level *level = &texture->level[0];
    const float x = rnd_wrap(u, wrap[0]) * (float)level->width - 0.5f,
                y = rnd_wrap(v, wrap[1]) * (float)level->height - 0.5f;
    const float fx = x - floorf(x), fy = y - floorf(y);
    for (int i = 0; i < 4; i++) {
        const float weight = (i & 1 ? fx : 1.0f - fx) * (i >> 1 ? fy : 1.0f - fy);
        const struct rnd_texel t = rnd_texture_texel(
            texture, rnd_texel_index(level, wrap, (int)floorf(x) + (i & 1), (int)floorf(y) + (i >> 1)));
        sum.r += weight * t.r, sum.g += weight * t.g, sum.b += weight * t.b, sum.a += weight * t.a;
    }
    return sum;
}
