/* What light does at a surface: materials evaluated at a hit, drawn from and evaluated as BSDFs. */
#ifndef FOVEAD_RENDERER_SHADE_H
#define FOVEAD_RENDERER_SHADE_H

#include "scene/scene.h"

/* What RND_RICH has besides; glTF's textures are in it. */
struct rnd_layers {
    vec3s f0; /* of the non-metal, by channel */
    float specular;
    float transmission;
    float coat, coat_alpha; /* clearcoat */
    vec3s coat_normal;      /* unit, on the side of the ray */
    vec3s sheen;
    float sheen_roughness;
};

/* A point that a ray hit. Normals face the side that the ray came from. */
struct rnd_surface {
    const struct rnd_material *material;
    vec3s position;
    vec3s geometric, shading; /* unit normals */
    bool front;               /* hit from the outside: the side of the triangle's own normal */
    vec3s base;
    float metallic, alpha;    /* GGX alpha: roughness squared */
    struct rnd_layers layers; /* set for RND_RICH alone, as what follows */
    bool pane;
};

/* What a ray hit. */
struct rnd_hit {
    uint32_t mesh, triangle; /* mesh is RTC_INVALID_GEOMETRY_ID if it hit nothing */
    float u, v;              /* barycentric */
    float distance;
    vec3s normal; /* of the triangle, of any length: its outside is where the vertices turn left */
    const struct rnd_instance *instance; /* through which the mesh is seen, or NULL: the world's own */
};

/* point.c: the surface at a hit of a ray with that direction. */
void rnd_surface_at(const struct rnd_scene *scene, const struct rnd_hit *hit, vec3s direction,
                    struct rnd_surface *out);

/* Has the surface an inside that light gets to? */
static inline bool rnd_has_volume(const struct rnd_surface *surface)
{
    return surface->material->kind == RND_RICH && surface->material->transmission > 0.0f &&
           !surface->material->thin;
}

/* Share of light that is left of a ray of that length, m, that hit the surface: a ray that hits a volume from
 * its back was inside all its way (Beer and Lambert). */
static inline vec3s rnd_transmittance(const struct rnd_surface *surface, float distance)
{
    const vec3s s = surface->material->absorption;
    if (surface->front || !rnd_has_volume(surface)) return glms_vec3_one();
    return (vec3s){{expf(-s.x * distance), expf(-s.y * distance), expf(-s.z * distance)}};
}

/* BSDF times cosine for light from wi leaving along wo (unit, away from the surface, wo on the side of the
 * normals, wi anywhere), and the density with which rnd_bsdf_draw() draws wi, per steradian. What is smooth
 * and transmits has no such density and gives nothing. */
vec3s rnd_bsdf(const struct rnd_surface *surface, vec3s wo, vec3s wi, float *out_pdf);

struct rnd_bsdf_sample {
    vec3s wi;
    vec3s weight; /* BSDF times cosine over density */
    float pdf;    /* per steradian; meaningless if delta */
    bool delta;   /* a single direction: next-event estimation cannot find it */
};

/* Draw a direction, below the surface too if it transmits; u are three numbers in [0,1). False if the path
 * ends here. */
bool rnd_bsdf_draw(const struct rnd_surface *surface, vec3s wo, const float u[3],
                   struct rnd_bsdf_sample *out);

/* The position moved off the surface towards the side that direction points to, so that a ray from it does
 * not hit the triangle that it left (Waechter and Binder 2019, Ray Tracing Gems ch. 6). */
vec3s rnd_leave(const struct rnd_surface *surface, vec3s direction);

#endif
