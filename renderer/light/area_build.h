/* Emissive triangles: found, divided where they shine unevenly, and made into a table. */
#ifndef FOVEAD_RENDERER_AREA_BUILD_H
#define FOVEAD_RENDERER_AREA_BUILD_H

#include "scene/scene.h"

/* As struct rnd_light_kind has it: fills the lights' areas, and marks the meshes that have some. */
bool rnd_areas_build(struct rnd_scene *scene, double *out_power);

#endif
