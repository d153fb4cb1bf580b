/* All of a glTF 2.0 file, JSON or binary. */
#ifndef FOVEAD_RENDERER_GLTF_H
#define FOVEAD_RENDERER_GLTF_H

#include "import/import.h"

/* Fill the scene. False and a line in in->error, which names the place in the JSON, as
 * meshes[0].primitives[1].indices, and what was expected there. */
bool rnd_import_gltf(struct rnd_import *in);

#endif
