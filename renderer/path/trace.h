/* Paths from the eye: unidirectional, next-event estimation, multiple importance sampling, Russian roulette.
 *
 * Paths are traced in waves: all of a wave take a step together, so that rays go to Embree in packets and
 * streams. What a path brings depends on the wave that it is in (Embree's kernels round differently for
 * packets and single rays), so whoever wants the same picture twice must form the same waves twice.
 */
#ifndef FOVEAD_RENDERER_TRACE_H
#define FOVEAD_RENDERER_TRACE_H

#include "scene/scene.h"

enum {
    RND_WAVE = 512, /* most paths of a wave */
};

/* Dimension 0 of a path's random numbers is its place within the pixel; the rest are the tracer's. */
enum { RND_DIMENSION_PIXEL, RND_DIMENSION_PATH };

/* A path that is under way, or at its end. */
struct rnd_path {
    vec3s origin, direction; /* of the next ray; unit */
    uint32_t seed, index;    /* address of its random numbers */
    vec3s radiance;          /* that it has brought so far */
    vec3s throughput;
    float pdf;  /* with which the direction was drawn, per steradian */
    bool delta; /* the direction could not have been found by next-event estimation */
};

struct rnd_tracer; /* one thread's memory for waves */

/* max_bounces 0: Russian roulette alone ends a path. NULL when memory is short. */
struct rnd_tracer *rnd_tracer_create(const struct rnd_scene *scene, int max_bounces);
void rnd_tracer_destroy(struct rnd_tracer *tracer); /* accepts NULL */
/* Go on with another scene. */
void rnd_tracer_scene(struct rnd_tracer *tracer, const struct rnd_scene *scene);

/* Trace count paths (at most RND_WAVE) to their ends. The caller sets origin, direction, seed and index;
 * radiance is the answer. Neighbours should be neighbours: packets are formed in the order given. Returns the
 * number of rays. */
uint64_t rnd_trace(struct rnd_tracer *tracer, struct rnd_path *paths, uint32_t count);

#endif
