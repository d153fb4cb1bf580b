/* The corners of triangles, packed for shading. */
#ifndef FOVEAD_RENDERER_IMPORT_CORNERS_H
#define FOVEAD_RENDERER_IMPORT_CORNERS_H

#include "scene/scene.h"

/* Pack the corners of all triangles, mesh by mesh. False if memory is short. */
bool rnd_corners_build(struct rnd_scene *scene);

#endif
