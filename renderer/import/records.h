/* Records of triangles, for shading. */
#ifndef FOVEAD_RENDERER_RECORDS_H
#define FOVEAD_RENDERER_RECORDS_H

#include "scene/scene.h"

/* Make the records of all meshes, in the order of the meshes. False if memory is short. */
bool rnd_records_build(struct rnd_scene *scene);

#endif
