/* Emissive triangles, or parts of them. */
#ifndef FOVEAD_RENDERER_AREA_H
#define FOVEAD_RENDERER_AREA_H

#include "light/choice.h"
#include "scene/scene.h"

#include <math.h>

/* Emitted radiance at barycentric (u, v) of the area's triangle, as a ray that hits it sees it. */
struct rnd_v3 rnd_area_emission(const struct rnd_scene *scene, const struct rnd_area *area, float u, float v);
/* The same at barycentric (s, t) of the area itself, times its coverage there. */
struct rnd_v3 rnd_area_gives(const struct rnd_scene *scene, const struct rnd_area *area, float s, float t);

/* From barycentric coordinates of an area to those of its triangle. */
RND_INLINE void rnd_area_place(const struct rnd_area *area, float s, float t, float *out_u, float *out_v)
{
    const float side = 1.0f / (float)(1u << (area->flags >> RND_AREA_HALVINGS)),
                turn = area->flags & RND_AREA_TURNED ? -1.0f : 1.0f;
    *out_u = side * ((float)(area->place & 0xffffu) + turn * s);
    *out_v = side * ((float)(area->place >> 16) + turn * t);
}

/* The area that covers barycentric (u, v) of triangle i and is drawn: i itself, or a part of it. */
RND_INLINE uint32_t rnd_area_at(const struct rnd_lights *lights, uint32_t i, float u, float v)
{
    while (lights->area[i].flags & RND_AREA_DIVIDED) {
        const int k = u >= 0.5f ? 1 : v >= 0.5f ? 2 : u + v <= 0.5f ? 0 : 3;
        u = k == 3 ? 1.0f - 2.0f * u : 2.0f * u - (k == 1 ? 1.0f : 0.0f);
        v = k == 3 ? 1.0f - 2.0f * v : 2.0f * v - (k == 2 ? 1.0f : 0.0f);
        i = lights->area[i].place + (uint32_t)k;
    }
    return i;
}

/* A triangle that is seen at a smaller cosine is nearly edge-on, and its density mostly rounding: it is not
 * drawn. */
#define RND_LEAST_COSINE 1e-6f

/* Density per steradian of drawing the point of a triangle at a distance along a direction, if the triangle
 * itself is drawn with that probability. 0 if it is seen edge-on. */
RND_INLINE float rnd_area_pdf(const struct rnd_area *area, float probability, struct rnd_v3 direction,
                              float distance)
{
    const struct rnd_v3 twice = rnd_v3_cross(area->e1, area->e2);
    const float projected = fabsf(rnd_v3_dot(twice, direction)); /* twice the area, times the cosine */
    const float least = RND_LEAST_COSINE * RND_LEAST_COSINE * rnd_v3_dot(twice, twice);
    const float pdf = probability * distance * distance / (0.5f * rnd_larger(projected, 1e-37f));
    return (projected * projected > least) & (pdf < INFINITY) ? pdf : 0.0f;
}

/* A point of a triangle, as seen from another point. */
struct rnd_area_point {
    struct rnd_v3 direction; /* unit, towards it */
    float distance;
    float s, t; /* barycentric, of the area */
};

/* Draw a point of a triangle as seen from a point, by two numbers in [0,1). Returns the density as
 * rnd_area_pdf() does, 0 if the triangle does not shine there. */
RND_INLINE float rnd_area_draw(const struct rnd_area *area, float probability, struct rnd_v3 point, float u,
                               float v, struct rnd_area_point *out)
{
    const float root = sqrtf(u), s = v * root, t = root - s; /* uniform over the triangle */
    const struct rnd_v3 p = rnd_v3_muladd(area->e2, t, rnd_v3_muladd(area->e1, s, area->corner)),
                        to = rnd_v3_sub(p, point);
    const float distance = sqrtf(rnd_v3_dot(to, to));
    out->direction = rnd_v3_scale(to, 1.0f / rnd_larger(distance, 1e-37f));
    out->distance = distance;
    out->s = s;
    out->t = t;
    const float facing = rnd_v3_dot(rnd_v3_cross(area->e1, area->e2), out->direction);
    const int shines = (facing < 0.0f) | ((area->flags & RND_AREA_DOUBLE) != 0);
    const float pdf = rnd_area_pdf(area, probability, out->direction, distance);
    return shines & (distance > 0.0f) ? pdf : 0.0f;
}

/* rnd_light_kind.draw. */
bool rnd_area_light(const struct rnd_scene *scene, const struct rnd_light_choice *choice, struct rnd_v3 point,
                    const float u[4], struct rnd_light_sample *out);

#endif
