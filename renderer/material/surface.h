/* A point on a surface, with its material as textures make it there: what closures are made of. */
#ifndef FOVEAD_RENDERER_SURFACE_H
#define FOVEAD_RENDERER_SURFACE_H

#include "math/v3.h"
#include "scene/scene.h"

/* What glTF's extensions add, textures included. */
struct rnd_layers {
    vec3s f0;       /* of the non-metal, by channel */
    float specular; /* reflectance of the non-metal at grazing angles */
    float transmission;
    float coat, coat_alpha; /* clearcoat */
    vec3s coat_normal;      /* unit, on the side of the ray */
    vec3s sheen;
    float sheen_roughness;
};

/* The border of a volume at a point: what is in front of it, where the ray came from, and behind. */
struct rnd_interface {
    float eta;                     /* index behind over index in front */
    float squeeze;                 /* factor of radiance that is refracted: see path/media.h */
    const struct rnd_glass *glass; /* of the material's own medium in the other one, or NULL: none is known */
    bool inside;                   /* the material's own medium is in front */
    bool hidden;                   /* the same medium is on both sides: light goes straight on */
};

/* A point that a ray hit. Normals face the side that the ray came from. */
struct rnd_surface {
    const struct rnd_material *material;
    vec3s position;
    vec3s geometric, shading; /* unit normals */
    bool front;               /* hit from the outside: the side of the triangle's own normal */
    vec3s base;
    float metallic, alpha; /* GGX alpha: roughness squared */
    struct rnd_layers layers;
    bool pane; /* rays that the pane lets through do not hit it: see material/glass.h */
    /* Of a material with a volume. rnd_surface_at() takes the other side to be air; path/media.h knows. */
    struct rnd_interface between;
};

/* The border of a material with a volume in air, met from its front or its back. */
static inline struct rnd_interface rnd_interface_in_air(const struct rnd_material *material, bool front)
{
    const float eta = front ? material->ior : 1.0f / material->ior;
    return (struct rnd_interface){
        .eta = eta, .squeeze = 1.0f / (eta * eta), .glass = material->glass[0], .inside = !front};
}

static inline struct rnd_v3 rnd_to_v3(vec3s a)
{
    return rnd_v3(a.x, a.y, a.z);
}

static inline vec3s rnd_from_v3(struct rnd_v3 a)
{
    return (vec3s){{a.x, a.y, a.z}};
}

#endif
