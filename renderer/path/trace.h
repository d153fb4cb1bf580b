/* One path from the eye: unidirectional, next-event estimation, multiple importance sampling, Russian
 * roulette. */
#ifndef FOVEAD_RENDERER_TRACE_H
#define FOVEAD_RENDERER_TRACE_H

#include "scene/scene.h"

struct rnd_tracer {
    const struct rnd_scene *scene;
    int max_bounces; /* 0: Russian roulette alone */
    uint64_t rays;   /* counts up */
};

/* Dimension 0 of a path's random numbers is its place within the pixel; the rest are the tracer's. */
enum { RND_DIMENSION_PIXEL, RND_DIMENSION_PATH };

/* Radiance along a ray (unit direction). The path's random numbers are those of (seed, index). */
vec3s rnd_trace(struct rnd_tracer *tracer, vec3s origin, vec3s direction, uint32_t seed, uint32_t index);

#endif
