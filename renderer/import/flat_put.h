/* A scene written in one piece. */
#ifndef FOVEAD_RENDERER_FLAT_PUT_H
#define FOVEAD_RENDERER_FLAT_PUT_H

#include "import/flat.h"

/* Write a scene to an empty file, freeing its meshes on the way, so that they are there once.
 * False if that fails. */
bool rnd_flat_put(struct rnd_scene *scene, int fd);

#endif
