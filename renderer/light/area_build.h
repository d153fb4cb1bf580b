/* Emissive triangles: found, divided where they shine unevenly, and made into a table. */
#ifndef FOVEAD_RENDERER_AREA_BUILD_H
#define FOVEAD_RENDERER_AREA_BUILD_H

#include "scene/scene.h"

/* rnd_light_kind.build: fills lights->area, and sets first_light of the meshes that have areas. */
bool rnd_areas_build(struct rnd_scene *scene, double *out_power);

#endif
