/* Emissive triangles: what is drawn of them how often. A triangle whose texture or coverage makes its light
 * uneven is divided into parts, the more the brighter they are: a bright spot is drawn as often as it should
 * be. */
#ifndef FOVEAD_RENDERER_EMITTER_H
#define FOVEAD_RENDERER_EMITTER_H

#include "scene/scene.h"

/* Find what emits, and divide it: fills the lights' areas, and marks the meshes. *out_weight is of each area,
 * by which they are to be drawn; the caller frees. False if memory is short. */
bool rnd_emitters_build(struct rnd_scene *scene, float **out_weight);

/* Does a mesh of that material give light? */
bool rnd_emits(const struct rnd_material *material);

#endif
