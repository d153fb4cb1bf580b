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

/* The border of a volume at a point: what is in front of it, where the ray came from, and behind. */
struct rnd_interface {
    float eta;     /* index behind over index in front */
    float squeeze; /* factor of radiance that is refracted: see path/media.h */
    const struct rnd_glass
        *glass;  /* of the material's own medium in the other; NULL: no facets to speak of */
    bool inside; /* the material's own medium is in front */
    bool hidden; /* the same medium is on both sides: nothing is there */
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
    struct rnd_interface
        between; /* of what has a volume: by rnd_surface_at() with air, else see path/media.h */
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

/* The border of a material with a volume in air, met from its front or its back. */
static inline struct rnd_interface rnd_interface_in_air(const struct rnd_material *material, bool front)
{
    const float eta = front ? material->ior : 1.0f / material->ior;
    return (struct rnd_interface){
        .eta = eta, .squeeze = 1.0f / (eta * eta), .glass = material->glass[0], .inside = !front};
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
