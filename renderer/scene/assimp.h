/* Meshes and materials as assimp has them. */
#ifndef FOVEAD_RENDERER_ASSIMP_H
#define FOVEAD_RENDERER_ASSIMP_H

#include "scene/import.h"

struct aiMesh;
struct aiMaterial;
struct aiScene;
struct aiFileIO;
struct rnd_mtl_file;

/* Make a shape of a mesh's triangles; the name must outlive the import. False and a line in in->error. */
bool rnd_assimp_mesh(struct rnd_import *in, const struct aiMesh *from, uint32_t material, const char *name);

/* mtl_material.c: one material of OBJ and the like. Its images are looked for where its library is, if mtl
 * knows it, then where the scene file is. False and a line in in->error. */
bool rnd_mtl_material(struct rnd_import *in, const struct aiScene *file, const struct aiMaterial *from,
                      const struct rnd_mtl_file *mtl, struct rnd_material *to);

/* assimp_file.c: what assimp opens files with, while in lasts. */
struct aiFileIO rnd_assimp_files(struct rnd_import *in);

#endif
