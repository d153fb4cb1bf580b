/* How much of each group of lights really arrives around the camera. */
#ifndef FOVEAD_RENDERER_SURVEY_H
#define FOVEAD_RENDERER_SURVEY_H

#include "light/choice.h"
#include "math/pool.h"
#include "scene/scene.h"
#include "space/camera.h"

/* Which lights points should ask for, by what really arrives of each around the camera. The threads of the
 * pool share the work; the answer is the same with any number. */
void rnd_survey_lights(const struct rnd_scene *scene, const struct rnd_camera *camera, struct rnd_pool *pool,
                       struct rnd_light_choice *out);

#endif
