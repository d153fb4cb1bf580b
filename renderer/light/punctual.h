/* Point, spot and directional lights (KHR_lights_punctual). */
#ifndef FOVEAD_RENDERER_PUNCTUAL_H
#define FOVEAD_RENDERER_PUNCTUAL_H

#include "light/choice.h"
#include "scene/scene.h"

/* rnd_light_kind.build and .draw. */
bool rnd_punctual_build(struct rnd_scene *scene, double *out_power);
bool rnd_punctual_light(const struct rnd_scene *scene, const struct rnd_light_choice *choice,
                        struct rnd_v3 point, const float u[4], struct rnd_light_sample *out);

#endif
