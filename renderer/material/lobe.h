/* A lobe: one way in which a surface scatters light, such as a clear coat or rough glass.
 *
 * Lobes lie in layers. Each one takes its share of the light, and the layers below get the rest:
 * 1 - albedo of the layer as seen from wo, which is exact for a world of constant radiance and, as in glTF's
 * own formulas, not reciprocal. material/closure.h puts a surface's lobes together. */
#ifndef FOVEAD_RENDERER_LOBE_H
#define FOVEAD_RENDERER_LOBE_H

#include "material/ggx.h"
#include "material/surface.h"

/* The table of lobes, from the top layer down. Another lobe is a file, and a name here. */
#define RND_LOBES(row) row(coat) row(sheen) row(metal_rough) row(thin) row(thick)

#define RND_LOBE_ONE(name) +1
enum {
    RND_LOBE_COUNT = RND_LOBES(RND_LOBE_ONE),
    RND_LOBE_BYTES = 64, /* most that a lobe keeps of a point */
};

/* A surface as it is seen from one direction. */
struct rnd_sight {
    const struct rnd_surface *surface;
    struct rnd_v3 towards;     /* wo in the world: unit, from the surface to where light is followed to */
    struct rnd_v3_frame frame; /* its z is the shading normal */
    struct rnd_v3 wo;          /* in that frame */
    bool inside;               /* seen from inside of the material's own medium */
};

/* A lobe's part in the closure of a surface. */
struct rnd_lobe_share {
    float strength; /* of the light, how much reaches the lobe */
    float taken;    /* of the light, how much the layers below do without */
    /* Of the lobe to be sampled. weigh() gives the light that the lobe scatters, mean of the channels;
     * rnd_closure_at() scales the sum of all lobes to 1. */
    float chance;
    bool bent; /* the lobe has a normal of its own that is not the triangle's */
    _Alignas(16) unsigned char own[RND_LOBE_BYTES]; /* what the lobe keeps: a struct of its file */
};

/* A direction that light comes from. Where normals are bent, a lobe's part on the wrong side of the triangle
 * is folded back about the triangle's plane (see rnd_fold()): the lobe is then evaluated in the mirrored
 * direction. */
struct rnd_incoming {
    struct rnd_v3 world, local; /* unit; local in the frame of the sight */
    bool above;                 /* light arrives above the triangle */
    bool folded;                /* world is mirrored, and above is of the true direction */
};

struct rnd_lobe_sample {
    struct rnd_v3 wi;     /* unit, world */
    bool above;           /* meant for above the triangle */
    bool folds;           /* on the wrong side of the triangle, wi is mirrored; else the path ends there */
    bool delta;           /* a single direction, which has no pdf */
    struct rnd_v3 weight; /* of delta: BSDF times cosine over the chance of it */
};

struct rnd_lobe {
    const char *name, *source; /* source of its formulas: author, year */
    /* Is the lobe there? left: of the light, how much the layers above leave. */
    bool (*weigh)(const struct rnd_sight *sight, float left, struct rnd_lobe_share *out);
    /* BSDF times cosine times strength, and the pdf of sample() per steradian. False: both are 0. Deltas
     * have neither. */
    bool (*evaluate)(const struct rnd_sight *sight, const struct rnd_lobe_share *share,
                     const struct rnd_incoming *in, struct rnd_v3 *out_f, float *out_pdf);
    /* Sample a direction from three numbers in [0,1). False if the path ends. */
    bool (*sample)(const struct rnd_sight *sight, const struct rnd_lobe_share *share, struct rnd_v3 u,
                   struct rnd_lobe_sample *out);
    /* Share of light that goes straight through, as if the lobe were smooth and the surface's two sides
     * parallel. NULL: none does. */
    struct rnd_v3 (*through)(const struct rnd_sight *sight, const struct rnd_lobe_share *share);
};

#define RND_LOBE_DECLARE(name) extern const struct rnd_lobe rnd_lobe_##name;
RND_LOBES(RND_LOBE_DECLARE)

/* Is a normal bent away from the triangle's? Rounding bends none. */
static inline bool rnd_is_bent(const struct rnd_surface *surface, vec3s normal)
{
    return glms_vec3_dot(normal, surface->geometric) < 1.0f - 1e-6f;
}

/* A direction of a frame in the world, made unit again. */
static inline struct rnd_v3 rnd_unit_to_world(const struct rnd_v3_frame *frame, struct rnd_v3 local)
{
    return rnd_v3_normalize(rnd_v3_to_world(frame, local));
}

#endif
