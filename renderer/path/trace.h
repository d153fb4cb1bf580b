/* Paths from the camera: unidirectional, next-event estimation, multiple importance sampling, Russian
 * roulette.
 *
 * Paths are traced in waves. All paths of a wave take a step together, so that their rays go to Embree in
 * packets and streams, and vector instructions do the rest. A path's contribution depends on its wave,
 * because Embree's kernels round differently for packets and single rays. The same waves give the same
 * picture. */
#ifndef FOVEAD_RENDERER_TRACE_H
#define FOVEAD_RENDERER_TRACE_H

#include "light/choice.h"
#include "path/media.h"
#include "path/wave_io.h"
#include "scene/scene.h"
#include "space/camera.h"

struct rnd_tracer; /* one thread's memory for waves */

/* choice is the caller's, who may change it between waves; max_bounces and firefly as in struct
 * rnd_render_options; width of the film, pixels; seed of the random numbers of its pixels. NULL when memory
 * is short. */
struct rnd_tracer *rnd_tracer_create(const struct rnd_scene *scene, const struct rnd_light_choice *choice,
                                     int max_bounces, float firefly, int width, uint32_t seed);
void rnd_tracer_destroy(struct rnd_tracer *tracer); /* accepts NULL */
/* Go on with another scene. */
void rnd_tracer_scene(struct rnd_tracer *tracer, const struct rnd_scene *scene);
/* Record the calls to Embree from now on; NULL: no more. */
struct rnd_tape;
void rnd_tracer_tape(struct rnd_tracer *tracer, struct rnd_tape *tape);
/* Forget the time that stages took; and add it to a batch's. */
void rnd_tracer_reset(struct rnd_tracer *tracer);
void rnd_tracer_stages(const struct rnd_tracer *tracer, struct rnd_batch *batch);

/* Trace count paths (at most RND_WAVE) from the camera, which is in those media, to their ends.
 * Paths next to each other in the wave should point in similar directions: packets are formed in that order.
 * Returns the number of rays. */
uint64_t rnd_trace(struct rnd_tracer *tracer, const struct rnd_camera *camera, rnd_media media,
                   struct rnd_wave_io *io, uint32_t count);

#endif
