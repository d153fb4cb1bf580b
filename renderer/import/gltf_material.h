/* Materials of a glTF file. */
#ifndef FOVEAD_RENDERER_GLTF_MATERIAL_H
#define FOVEAD_RENDERER_GLTF_MATERIAL_H

#include "import/gltf_document.h"

/* Read the file's materials, in its order, and append glTF's default material. Values out of range are
 * clamped, with a warning. False and a line. */
bool rnd_gltf_materials(struct rnd_gltf *gltf);

#endif
