/* What materials of all formats share, and those of MTL and of all other formats but glTF's. */
#ifndef FOVEAD_RENDERER_MATERIAL_H
#define FOVEAD_RENDERER_MATERIAL_H

#include "scene/scene.h"

#include <assimp/scene.h>

struct rnd_mtl_file;

/* material.c: glTF's default: white, wholly metallic and rough, without a texture. */
void rnd_material_init(struct rnd_material *material);
/* material.c: reflectance of the non-metal at normal incidence, by way of index and tint. */
void rnd_material_set_f0(struct rnd_material *material, vec3s f0);
/* material.c: the cheapest kind that is right for it. */
void rnd_material_set_kind(struct rnd_material *material);

/* mtl_material.c: one material of OBJ and the like. Its images are looked for where its library is, if mtl
 * knows it, then in directory, "" or with a slash at its end. */
bool rnd_mtl_material(struct rnd_scene *scene, const struct aiScene *file, const struct aiMaterial *from,
                      const char *path, const char *directory, const struct rnd_mtl_file *mtl,
                      struct rnd_material *to, char out_error[RND_ERROR_SIZE]);

#endif
