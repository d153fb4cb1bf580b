/* Meshes and materials as assimp has them. */
#ifndef FOVEAD_RENDERER_ASSIMP_H
#define FOVEAD_RENDERER_ASSIMP_H

#include "import/import.h"

struct aiMesh;

/* Make a shape of a mesh's triangles. The name must outlive the import. False and a line in in->error. */
bool rnd_assimp_mesh(struct rnd_import *in, const struct aiMesh *from, uint32_t material, const char *name);

/* Read all of a file, in a format that assimp reads. False and a line in in->error. */
bool rnd_import_assimp(struct rnd_import *in);

#endif
