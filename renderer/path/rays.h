/* The rays of a wave go to Embree. */
#ifndef FOVEAD_RENDERER_PATH_RAYS_H
#define FOVEAD_RENDERER_PATH_RAYS_H

#include "path/wave.h"

/* Find what count paths hit. coherent: they all begin at the camera. */
void rnd_intersect(struct rnd_tracer *tracer, struct rnd_paths *paths, uint32_t count, bool coherent);
/* Where the camera sees the back of what is one-sided, find what is behind that instead. */
void rnd_pass_backs(struct rnd_tracer *tracer, const struct rnd_paths *paths, uint32_t count);
/* Add the radiance of the shadow rays that get through. */
void rnd_occlude(struct rnd_tracer *tracer);

#endif
