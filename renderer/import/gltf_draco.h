/* Geometry that is there in Draco's form alone, decoded by assimp. */
#ifndef FOVEAD_RENDERER_GLTF_DRACO_H
#define FOVEAD_RENDERER_GLTF_DRACO_H

#include "import/gltf_document.h"

/* Is a primitive's geometry there in Draco's form alone? */
bool rnd_gltf_is_draco(const struct rnd_gltf *gltf, const json_t *primitive);
/* Make a shape of such a primitive. False and a line. */
bool rnd_gltf_draco(struct rnd_gltf *gltf, const json_t *primitive, const char *where, uint32_t material,
                    const char *name);

#endif
