/* Embree's trees of a scene. */
#ifndef FOVEAD_RENDERER_TREE_H
#define FOVEAD_RENDERER_TREE_H

#include "scene/scene.h"

/* Build the scene's trees from its meshes and instances, after its materials. False and a line in out_error.
 */
bool rnd_accel_build(struct rnd_scene *scene, char out_error[RND_ERROR_SIZE]);

#endif
