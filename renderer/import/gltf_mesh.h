/* Meshes of a glTF file. */
#ifndef FOVEAD_RENDERER_GLTF_MESH_H
#define FOVEAD_RENDERER_GLTF_MESH_H

#include "import/gltf_document.h"

/* Make shapes of a mesh's primitives, if that has not been done. False and a line. */
bool rnd_gltf_read_mesh(struct rnd_gltf *gltf, size_t mesh);

#endif
