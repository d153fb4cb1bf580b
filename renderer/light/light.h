/* The lights of a scene, of which next-event estimation draws one at a time. A shading point chooses a group,
 * then a light in it: by power, or by the share of the power that is known to arrive (path/survey.c). */
#ifndef FOVEAD_RENDERER_LIGHT_H
#define FOVEAD_RENDERER_LIGHT_H

#include "light/choice.h"
#include "renderer.h"
#include "scene/scene.h"

/* Draw all groups equally often, and the lights of a group by power. choice was in use before, or is all 0.
 */
void rnd_light_choose_evenly(const struct rnd_lights *lights, struct rnd_light_choice *choice);
void rnd_light_choice_finish(struct rnd_light_choice *choice);

/* Once the geometry is there: find the lights and make their tables. False and a line in out_error. */
bool rnd_lights_build(struct rnd_scene *scene, const char *path, char out_error[RND_ERROR_SIZE]);
void rnd_lights_finish(struct rnd_lights *lights);

/* Draw a light of a group for the point, from four numbers in [0,1). False if its light does not reach the
 * point. */
bool rnd_light_draw(const struct rnd_scene *scene, const struct rnd_light_choice *choice, int group,
                    struct rnd_v3 point, const float u[4], struct rnd_light_sample *out);

/* Weight of a direction that was drawn with density pdf, and that another way draws with density other (Veach
 * 1997, power heuristic with exponent 2). */
RND_INLINE float rnd_power_heuristic(float pdf, float other)
{
    const float r = other / pdf;
    return 1.0f / (1.0f + r * r);
}

#endif
