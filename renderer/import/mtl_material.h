/* Materials of OBJ and other formats that assimp reads. */
#ifndef FOVEAD_RENDERER_MTL_MATERIAL_H
#define FOVEAD_RENDERER_MTL_MATERIAL_H

#include "import/import.h"
#include "import/mtl_file.h"

struct aiMaterial;
struct aiScene;

/* Read one material. Its images are looked for beside its library, if mtl knows it, then beside the scene
 * file. False and a line in in->error. */
bool rnd_mtl_material(struct rnd_import *in, const struct aiScene *file, const struct aiMaterial *from,
                      const struct rnd_mtl_file *mtl, struct rnd_material *to);

#endif
