/* The corners of a triangle, packed: all that shading needs of it, in one line of the cache. A hit reads this
 * and none of the mesh's own arrays. */
#ifndef FOVEAD_RENDERER_CORNERS_H
#define FOVEAD_RENDERER_CORNERS_H

#include "math/v3.h"

#include <stdbool.h>
#include <stdint.h>

/* lod of a triangle without texture coordinates, or where they have no extent: the finest level is right. */
#define RND_NO_EXTENT -64.0f

struct rnd_corners {
    uint32_t normal[3]; /* of the corners, octahedral: 16 bits each of two coordinates */
    float uv[3][2];     /* of the corners, first set; 0 if the mesh has none */
    float lod; /* log2 of texture coordinates per metre; with a texture's size, of texels per metre */
    uint32_t tangent[3]; /* of the corners, along u, octahedral; the lowest bit of the first: v grows against
                            cross(normal, tangent) */
    uint32_t colour[3];  /* of the corners: square roots of linear r, g, b, 10 bits each */
};

/* How texture coordinates run over a triangle. */
struct rnd_uv_frame {
    bool spans;          /* the coordinates have an extent */
    float lod;           /* as in rnd_corners */
    struct rnd_v3 along; /* where u grows, of any length; zero without an extent */
    bool mirrored;       /* v grows against cross(normal, along) */
};

/* By the corners' coordinates, and the two sides that begin at the first corner. */
RND_INLINE struct rnd_uv_frame rnd_uv_frame(const float uv[3][2], struct rnd_v3 e1, struct rnd_v3 e2)
{
    const float u1 = uv[1][0] - uv[0][0], v1 = uv[1][1] - uv[0][1], u2 = uv[2][0] - uv[0][0],
                v2 = uv[2][1] - uv[0][1];
    const struct rnd_v3 normal = rnd_v3_cross(e1, e2);
    const float area = u1 * v2 - u2 * v1, world = sqrtf(rnd_v3_dot(normal, normal));
    if (area == 0.0f || !(world > 0.0f)) return (struct rnd_uv_frame){.lod = RND_NO_EXTENT};
    /* (e1, e2) = (T, B) ((u1, u2), (v1, v2)), solved for T; only its direction counts. */
    return (struct rnd_uv_frame){.spans = true,
                                 .lod = 0.5f * log2f(fabsf(area) / world),
                                 .along = rnd_v3_scale(rnd_v3_sub(rnd_v3_scale(e1, v2), rnd_v3_scale(e2, v1)),
                                                       area > 0.0f ? 1.0f : -1.0f),
                                 .mirrored = area < 0.0f};
}

_Static_assert(sizeof(struct rnd_corners) == 64, "the corners of a triangle are one line of the cache");

/* Octahedral encoding (Meyer et al. 2010): good to 5e-5 rad. */
RND_INLINE uint32_t rnd_octahedral(struct rnd_v3 n)
{
    const float scale = 1.0f / rnd_larger(fabsf(n.x) + fabsf(n.y) + fabsf(n.z), 1e-37f);
    float x = n.x * scale, y = n.y * scale;
    if (n.z < 0.0f) {
        const float fold = (1.0f - fabsf(y)) * (x >= 0.0f ? 1.0f : -1.0f);
        y = (1.0f - fabsf(x)) * (y >= 0.0f ? 1.0f : -1.0f);
        x = fold;
    }
    const int32_t ix = (int32_t)(x * 32767.0f + 32767.5f), iy = (int32_t)(y * 32767.0f + 32767.5f);
    return (uint32_t)ix | (uint32_t)iy << 16;
}

/* Not of unit length: its absolute coordinates sum to one. */
RND_INLINE struct rnd_v3 rnd_octahedral_decode(uint32_t code)
{
    const float x = (float)(int32_t)(code & 0xffffu) * (1.0f / 32767.0f) - 1.0f,
                y = (float)(int32_t)(code >> 16) * (1.0f / 32767.0f) - 1.0f;
    const float z = 1.0f - fabsf(x) - fabsf(y), t = rnd_larger(-z, 0.0f);
    return rnd_v3(x + (x >= 0.0f ? -t : t), y + (y >= 0.0f ? -t : t), z);
}

RND_INLINE struct rnd_v3 rnd_corner_colour(uint32_t code)
{
    const float r = (float)(code & 1023u) * (1.0f / 1023.0f),
                g = (float)(code >> 10 & 1023u) * (1.0f / 1023.0f),
                b = (float)(code >> 20 & 1023u) * (1.0f / 1023.0f);
    return rnd_v3(r * r, g * g, b * b);
}

#endif
