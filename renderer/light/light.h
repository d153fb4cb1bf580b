/* The lights of a scene, drawn one at a time for next-event estimation. A shading point chooses a group, then
 * a light within the group: by power, or by what of that is known to arrive (path/survey.c). */
#ifndef FOVEAD_RENDERER_LIGHT_H
#define FOVEAD_RENDERER_LIGHT_H

#include "light/choice.h"
#include "renderer.h"
#include "scene/scene.h"

/* Every group as often, and by power within it. choice is one that was in use, or zeros. */
void rnd_light_choose_evenly(const struct rnd_lights *lights, struct rnd_light_choice *choice);
void rnd_light_choice_finish(struct rnd_light_choice *choice);

/* After the geometry: find what emits and make the tables. */
bool rnd_lights_build(struct rnd_scene *scene, const char *path, char out_error[RND_ERROR_SIZE]);
void rnd_lights_finish(struct rnd_lights *lights);

/* Draw a light of a group for the point from four numbers in [0,1). False if what was drawn does not reach
 * it. */
bool rnd_light_draw(const struct rnd_scene *scene, const struct rnd_light_choice *choice, int group,
                    struct rnd_v3 point, const float u[4], struct rnd_light_sample *out);

/* Weight of a direction drawn with density pdf that another way would draw with density other (Veach 1997,
 * power heuristic with exponent 2). */
RND_INLINE float rnd_power_heuristic(float pdf, float other)
{
    const float r = other / pdf;
    return 1.0f / (1.0f + r * r);
}

#endif
