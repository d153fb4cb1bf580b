/* Materials of a glTF file. */
#ifndef FOVEAD_RENDERER_GLTF_MATERIAL_H
#define FOVEAD_RENDERER_GLTF_MATERIAL_H

#include "import/gltf_document.h"

/* All of the file's materials, in its order, and after them glTF's default. Values out of their range are
 * clamped, with a warning. False and a line. */
bool rnd_gltf_materials(struct rnd_gltf *gltf);

#endif
