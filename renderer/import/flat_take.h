/* Taking a scene from one piece of memory (flat.h), which is not trusted. */
#ifndef FOVEAD_RENDERER_FLAT_TAKE_H
#define FOVEAD_RENDERER_FLAT_TAKE_H

#include "import/flat.h"

/* Fill a scene from the scene->flat_bytes bytes at scene->flat, which its meshes go on using. False with what
 * is wrong, as "a mesh whose ...". */
bool rnd_flat_take(struct rnd_scene *scene, char *out_why, size_t size);

#endif
