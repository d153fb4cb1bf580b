/* Writing a scene into one piece of memory (flat.h). */
#ifndef FOVEAD_RENDERER_FLAT_PUT_H
#define FOVEAD_RENDERER_FLAT_PUT_H

#include "import/flat.h"

/* Write a scene to an empty file. Each mesh is freed when it is written, so that memory holds it once. False
 * on failure. */
bool rnd_flat_put(struct rnd_scene *scene, int fd);

#endif
