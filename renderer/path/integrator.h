/* Batches of paths: placed around the gaze, traced in waves by all threads, and added to a film. */
#ifndef FOVEAD_RENDERER_INTEGRATOR_H
#define FOVEAD_RENDERER_INTEGRATOR_H

#include "light/choice.h"
#include "path/media.h"
#include "path/place.h"
#include "scene/scene.h"
#include "space/camera.h"

struct rnd_worker; /* one thread's own memory */

struct rnd_integrator {
    struct rnd_film *film;
    const struct rnd_scene *scene;
    struct rnd_camera camera;
    rnd_media media; /* that the camera is in */
    struct rnd_pool *pool;
    struct rnd_worker *worker; /* one for each thread of the pool */
    int workers;
    bool surveyed; /* the lights, from this camera */
    struct rnd_light_choice choice;
    struct rnd_places places;
};

/* The film, and the scene while it is in use, must outlive the integrator. Of the options, threads is 1 or
 * more, and size and error bar are the film's. False if memory or threads are short; finish it in any
 * case. */
bool rnd_integrator_init(struct rnd_integrator *integrator, const struct rnd_scene *scene,
                         const struct rnd_camera *camera, struct rnd_film *film,
                         const struct rnd_render_options *options);
void rnd_integrator_finish(struct rnd_integrator *integrator);

/* Go on with this scene and camera, as if it were a new integrator. */
void rnd_integrator_restart(struct rnd_integrator *integrator, const struct rnd_scene *scene,
                            const struct rnd_camera *camera);

/* As rnd_render_batch(), rnd_render_outline() and rnd_render_retrace(). */
void rnd_integrate(struct rnd_integrator *integrator, const struct rnd_aim *aim, uint64_t now_ns,
                   uint32_t paths, struct rnd_batch *out_batch);
void rnd_integrate_outline(struct rnd_integrator *integrator, const struct rnd_aim *aim, uint64_t now_ns,
                           struct rnd_batch *out_batch);
void rnd_integrate_twice(struct rnd_integrator *integrator, const struct rnd_aim *aim, uint32_t paths,
                         struct rnd_batch *out_batch, double *out_seconds);

#endif
