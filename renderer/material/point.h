/* The surface at a single point. */
#ifndef FOVEAD_RENDERER_POINT_H
#define FOVEAD_RENDERER_POINT_H

#include "material/shading.h"
#include "material/surface.h"

/* A point of a triangle. */
struct rnd_point {
    uint32_t mesh, triangle;
    float u, v;                          /* barycentric */
    struct rnd_v3 position;              /* in the world, as a ray found it */
    const struct rnd_instance *instance; /* through which the mesh is seen, or NULL: the world's own */
};

/* How its textures are filtered: by the mipmap level of a path's cone, and one random texel of four. */
struct rnd_filter {
    float footprint; /* width of the cone at the point, in the mesh's own metres; 0: the finest level */
    float finer;     /* levels finer than that */
    float pick[2];   /* random numbers in [0,1) */
};

/* The surface at a point whose normals are known. */
void rnd_surface_at(const struct rnd_scene *scene, const struct rnd_point *point,
                    const struct rnd_facing *facing, const struct rnd_filter *filter,
                    struct rnd_surface *out);

/* The normals at a point that a ray in that direction hit. normal is Embree's: of the triangle, of any
 * length, in the mesh's own coordinates. */
struct rnd_facing rnd_facing_at(const struct rnd_scene *scene, const struct rnd_point *point,
                                struct rnd_v3 normal, struct rnd_v3 direction);

#endif
