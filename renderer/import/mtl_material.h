/* Materials of OBJ and the other formats that assimp reads. */
#ifndef FOVEAD_RENDERER_MTL_MATERIAL_H
#define FOVEAD_RENDERER_MTL_MATERIAL_H

#include "import/import.h"
#include "import/mtl_file.h"

struct aiMaterial;
struct aiScene;

/* One material of OBJ and the like. Its images are looked for where its library is, if mtl
 * knows it, then where the scene file is. False and a line in in->error. */
bool rnd_mtl_material(struct rnd_import *in, const struct aiScene *file, const struct aiMaterial *from,
                      const struct rnd_mtl_file *mtl, struct rnd_material *to);

#endif
