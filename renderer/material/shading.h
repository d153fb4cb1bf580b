/* What a triangle's corners, its maps and its instance make of one point: normals, texels, colours, and where
 * rays begin. The wave calls these functions in loops over many points (path/surface.c), and material/point.c
 * for a single one, so that both see the same surface. */
#ifndef FOVEAD_RENDERER_SHADING_H
#define FOVEAD_RENDERER_SHADING_H

#include "math/v3.h"
#include "scene/scene.h"

#include <stdint.h>
#include <string.h>

/* --- normals --- */

/* A point's normals, turned to where a ray came from. */
struct rnd_facing {
    struct rnd_v3 direction;          /* of the ray, unit */
    struct rnd_v3 geometric, shading; /* unit */
    float side;                       /* 1: the ray hit the outside; -1: the inside */
};

/* The triangle's outside normal and the interpolated one (both of any length) turned to the ray. A shading
 * normal that the ray sees from behind, or below the triangle, gives way to the triangle's. */
RND_INLINE struct rnd_facing rnd_face(struct rnd_v3 normal, struct rnd_v3 smooth, struct rnd_v3 direction)
{
    const struct rnd_v3 outside = rnd_v3_normalize(normal);
    const float side = rnd_v3_dot(outside, direction) < 0.0f ? 1.0f : -1.0f;
    const struct rnd_v3 geometric = rnd_v3_scale(outside, side),
                        shading = rnd_v3_scale(rnd_v3_normalize(smooth), side);
    const int good = (rnd_v3_dot(shading, direction) < 0.0f) & (rnd_v3_dot(shading, geometric) > 0.0f);
    return (struct rnd_facing){direction, geometric, rnd_v3_select(good, shading, geometric), side};
}

/* Between the normals of a triangle's corners, as rnd_corners has them; of any length. */
RND_INLINE struct rnd_v3 rnd_smooth_normal(uint32_t code_a, uint32_t code_b, uint32_t code_c, float u,
                                           float v)
{
    const struct rnd_v3 a = rnd_v3_normalize(rnd_octahedral_decode(code_a)),
                        b = rnd_v3_normalize(rnd_octahedral_decode(code_b)),
                        c = rnd_v3_normalize(rnd_octahedral_decode(code_c));
    return rnd_v3_muladd(c, v, rnd_v3_muladd(b, u, rnd_v3_scale(a, 1.0f - u - v)));
}

/* A normal of a mesh in the world: it keeps its side, and not its length. */
RND_INLINE struct rnd_v3 rnd_normal_to_world(const struct rnd_instance *instance, struct rnd_v3 n)
{
    const float *m = instance->normal_to_world;
    return rnd_v3(m[0] * n.x + m[3] * n.y + m[6] * n.z, m[1] * n.x + m[4] * n.y + m[7] * n.z,
                  m[2] * n.x + m[5] * n.y + m[8] * n.z);
}

/* --- normal maps --- */

/* Where a normal map's u grows, of any length; zero: nowhere. turn: -1 if v grows against
 * cross(normal, along), else 1. */
struct rnd_tangent {
    struct rnd_v3 along;
    float turn;
};

/* Do the corners of a triangle have tangents? */
RND_INLINE bool rnd_has_tangents(const struct rnd_mesh *mesh, const struct rnd_corners *corners)
{
    return mesh->tangent || corners->lod > RND_NO_EXTENT;
}

/* Between the tangents of a triangle's corners, as rnd_corners has them. */
RND_INLINE struct rnd_tangent rnd_tangent_at(const uint32_t code[3], float u, float v)
{
    struct rnd_tangent out = {rnd_octahedral_decode(code[0]), code[0] & 1u ? -1.0f : 1.0f};
    if (code[0] == code[1] && code[0] == code[2]) return out;
    out.along = rnd_v3_scale(rnd_v3_normalize(out.along), 1.0f - u - v);
    out.along = rnd_v3_muladd(rnd_v3_normalize(rnd_octahedral_decode(code[1])), u, out.along);
    out.along = rnd_v3_muladd(rnd_v3_normalize(rnd_octahedral_decode(code[2])), v, out.along);
    return out;
}

RND_INLINE struct rnd_tangent rnd_tangent_to_world(const struct rnd_instance *instance,
                                                   struct rnd_tangent tangent)
{
    const float *m = instance->to_world;
    const struct rnd_v3 d = tangent.along;
    return (struct rnd_tangent){rnd_v3(m[0] * d.x + m[3] * d.y + m[6] * d.z,
                                       m[1] * d.x + m[4] * d.y + m[7] * d.z,
                                       m[2] * d.x + m[5] * d.y + m[8] * d.z),
                                instance->mirrors ? -tangent.turn : tangent.turn};
}

/* The shading normal bent by a texel of a normal map (glTF 2.0 section 3.9.3). A normal that the ray sees
 * from behind is bent until it is seen, and the triangle's own takes the place of one below it. */
RND_INLINE struct rnd_v3 rnd_bend_normal(const struct rnd_facing *facing, struct rnd_tangent tangent,
                                         float scale, struct rnd_texel t)
{
    const struct rnd_v3 outside = rnd_v3_scale(facing->shading, facing->side);
    struct rnd_v3 along = rnd_v3_muladd(outside, -rnd_v3_dot(tangent.along, outside), tangent.along);
    const float length = sqrtf(rnd_v3_dot(along, along));
    if (!(length > 1e-6f)) return facing->shading; /* texture coordinates that span nothing */
    along = rnd_v3_scale(along, 1.0f / length);
    const struct rnd_v3 across = rnd_v3_scale(rnd_v3_cross(outside, along), tangent.turn);
    struct rnd_v3 bent = rnd_v3_scale(outside, 2.0f * t.b - 1.0f);
    bent = rnd_v3_muladd(along, scale * (2.0f * t.r - 1.0f), bent);
    /* green points up in the picture, and v down */
    bent = rnd_v3_muladd(across, -scale * (2.0f * t.g - 1.0f), bent);
    const float square = rnd_v3_dot(bent, bent);
    if (!(square > 1e-12f)) return facing->shading;
    bent = rnd_v3_scale(bent, facing->side / sqrtf(square));
    const float seen = 1e-2f, cosine = -rnd_v3_dot(bent, facing->direction);
    if (cosine < seen) bent = rnd_v3_normalize(rnd_v3_muladd(facing->direction, cosine - seen, bent));
    return rnd_v3_dot(bent, facing->geometric) > 0.0f ? bent : facing->geometric;
}

/* --- texels --- */

/* log2 to a tenth: the exponent, and the mantissa as if it were straight. */
RND_INLINE float rnd_roughly_log2(float x)
{
    int32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return (float)bits * 0x1p-23f - 127.0f;
}

/* Where a map is looked up, by the texture coordinates of the triangle's corners. */
RND_INLINE void rnd_map_place(const struct rnd_map *map, const float uv[3][2], float u, float v, float *out_x,
                              float *out_y)
{
    const float w = 1.0f - u - v, *m = map->transform;
    const float x = w * uv[0][0] + u * uv[1][0] + v * uv[2][0],
                y = w * uv[0][1] + u * uv[1][1] + v * uv[2][1];
    *out_x = map->has_transform ? m[0] * x + m[1] * y + m[2] : x;
    *out_y = map->has_transform ? m[3] * x + m[4] * y + m[5] : y;
}

/* log2 of texture coordinates per metre as a map's transform leaves them; lod: before. */
RND_INLINE float rnd_map_lod(const struct rnd_map *map, float lod)
{
    const float *m = map->transform;
    if (!map->has_transform) return lod;
    return lod + 0.5f * rnd_roughly_log2(rnd_larger(fabsf(m[0] * m[4] - m[1] * m[3]), 1e-12f));
}

/* By how many levels textures are finer where a path meets them after another surface: a coarse texel may
 * hold colours that no face shows, and its light would spread. */
#define RND_INDIRECT_FINER 5.0f

/* The mipmap level whose texels are half as large as a path's cone where it hits, or finer. size: log2 of
 * texels per metre at the finest level; footprint: width of the cone, in the mesh's own metres; cosine:
 * between the ray and the shading normal; finer: so many levels. */
RND_INLINE float rnd_level_at(float size, float footprint, float cosine, float finer)
{
    /* longer by 1 / cosine one way alone: the mean of both */
    const float width = rnd_larger(footprint, 1e-12f) / sqrtf(rnd_larger(cosine, 0.01f));
    /* 1 for half of the cone, less 1/2 to round */
    return rnd_larger(size + rnd_roughly_log2(width) - (0.5f + finer), 0.0f);
}

/* The texel of a map at coordinates x, y; two numbers in [0,1) pick it among its neighbours. */
RND_INLINE size_t rnd_map_texel(const struct rnd_map *map, const struct rnd_texture *texture, float x,
                                float y, float level, const float pick[2])
{
    const int l = (int)rnd_smaller(level, (float)(texture->levels - 1));
    return rnd_texture_pick(texture, map->wrap, x, y, l, map->nearest ? 0.5f : pick[0],
                            map->nearest ? 0.5f : pick[1]);
}

/* --- colours --- */

RND_INLINE struct rnd_v3 rnd_vertex_colour(const struct rnd_corners *corners, float u, float v)
{
    struct rnd_v3 c = rnd_v3_scale(rnd_corner_colour(corners->colour[0]), 1.0f - u - v);
    c = rnd_v3_muladd(rnd_corner_colour(corners->colour[1]), u, c);
    return rnd_v3_muladd(rnd_corner_colour(corners->colour[2]), v, c);
}

/* --- where rays begin --- */

/* How far off a surface rays begin: beyond what rounding may have moved the point into it, by its coordinates
 * and by the length of the ray that found it. */
RND_INLINE float rnd_offset(struct rnd_v3 p, float distance)
{
    const float largest = rnd_larger(rnd_larger(fabsf(p.x), fabsf(p.y)), rnd_larger(fabsf(p.z), distance));
    return largest * 0x1p-16f;
}

/* The step off the surface, from a point to where a ray in a direction begins. */
RND_INLINE struct rnd_v3 rnd_step_off(struct rnd_v3 p, float distance, struct rnd_v3 geometric,
                                      struct rnd_v3 direction)
{
    const float off = rnd_offset(p, distance);
    return rnd_v3_scale(geometric, rnd_v3_dot(direction, geometric) >= 0.0f ? off : -off);
}

#endif
