/* What light does at a surface: materials evaluated at a hit, drawn from and evaluated as BSDFs. */
#ifndef FOVEAD_RENDERER_SHADE_H
#define FOVEAD_RENDERER_SHADE_H

#include "scene/scene.h"

/* A point that a ray hit. Normals face the side that the ray came from. */
struct rnd_surface {
    const struct rnd_material *material;
    vec3s position;
    vec3s geometric, shading; /* unit normals */
    bool front;               /* hit from the outside: the side of the triangle's own normal */
    vec3s base;
    float metallic, alpha; /* GGX alpha: roughness squared */
};

/* What a ray hit. */
struct rnd_hit {
    uint32_t mesh, triangle; /* mesh is RTC_INVALID_GEOMETRY_ID if it hit nothing */
    float u, v;              /* barycentric */
    float distance;
    vec3s normal; /* of the triangle, of any length: its outside is where the vertices turn left */
    const struct rnd_instance *instance; /* through which the mesh is seen, or NULL: the world's own */
};

/* The surface at a hit of a ray with that direction. */
void rnd_surface_at(const struct rnd_scene *scene, const struct rnd_hit *hit, vec3s direction,
                    struct rnd_surface *out);

/* BSDF times cosine for light from wi leaving along wo (unit, away from the surface), and the density with
 * which rnd_bsdf_draw() draws wi, per steradian. Zero for smooth dielectrics, which have no such density. */
vec3s rnd_bsdf(const struct rnd_surface *surface, vec3s wo, vec3s wi, float *out_pdf);

struct rnd_bsdf_sample {
    vec3s wi;
    vec3s weight; /* BSDF times cosine over density */
    float pdf;    /* per steradian; meaningless if delta */
    bool delta;   /* a single direction: next-event estimation cannot find it */
};

/* Draw a direction; u are three numbers in [0,1). False if the path ends here. */
bool rnd_bsdf_draw(const struct rnd_surface *surface, vec3s wo, const float u[3],
                   struct rnd_bsdf_sample *out);

/* The position moved off the surface towards the side that direction points to, so that a ray from it does
 * not hit the triangle that it left (Waechter and Binder 2019, Ray Tracing Gems ch. 6). */
vec3s rnd_leave(const struct rnd_surface *surface, vec3s direction);

#endif
