/* The closure of a surface: all its lobes together, for light that leaves the surface in one direction. */
#ifndef FOVEAD_RENDERER_CLOSURE_H
#define FOVEAD_RENDERER_CLOSURE_H

#include "material/lobe.h"

struct rnd_closure {
    struct rnd_sight sight;
    bool hidden; /* the same medium is on both sides: light goes straight on */
    bool bent;   /* a lobe may be on the wrong side of the triangle */
    int count;   /* of lobes that are there, from the top layer down */
    const struct rnd_lobe *lobe[RND_LOBE_COUNT];
    struct rnd_lobe_share share[RND_LOBE_COUNT];
};

/* A sampled direction that a path goes on in. */
struct rnd_scattered {
    vec3s wi;     /* unit, world */
    vec3s weight; /* BSDF times cosine over pdf */
    float pdf;    /* per steradian; 1 if delta */
    bool delta;   /* a single direction: next-event estimation cannot find it */
};

/* The closure of a surface seen from wo (unit, away from the surface, on the side of the normals). It points
 * to the surface. */
void rnd_closure_at(const struct rnd_surface *surface, vec3s wo, struct rnd_closure *out);

/* BSDF times cosine for light from wi (unit, away from the surface, on any side), and the pdf with which
 * rnd_closure_sample() samples wi, per steradian. Deltas have no pdf and give nothing. */
vec3s rnd_closure_evaluate(const struct rnd_closure *closure, vec3s wi, float *out_pdf);

/* Sample a direction from three numbers in [0,1); it is below the surface too if that transmits. False if
 * the path ends here. */
bool rnd_closure_sample(const struct rnd_closure *closure, const float u[3], struct rnd_scattered *out);

/* Share of light that goes straight through, as if the surface were smooth and its two sides parallel. */
vec3s rnd_closure_through(const struct rnd_closure *closure);

#endif
