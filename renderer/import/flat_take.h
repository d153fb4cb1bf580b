/* A scene taken from one piece of memory that is not trusted. */
#ifndef FOVEAD_RENDERER_FLAT_TAKE_H
#define FOVEAD_RENDERER_FLAT_TAKE_H

#include "import/flat.h"

/* Fill a scene from scene->flat, of scene->flat_bytes, which its meshes go on using. False with
 * what is wrong, as "a mesh whose ...". */
bool rnd_flat_take(struct rnd_scene *scene, char *out_why, size_t size);

#endif
