/* What materials of all formats share. */
#ifndef FOVEAD_RENDERER_MATERIAL_H
#define FOVEAD_RENDERER_MATERIAL_H

#include "scene/scene.h"

/* material.c: glTF's default: white, wholly metallic and rough, without a texture. */
void rnd_material_init(struct rnd_material *material);
/* material.c: reflectance of the non-metal at normal incidence, by way of index and tint. */
void rnd_material_set_f0(struct rnd_material *material, vec3s f0);
/* material.c: the cheapest kind that is right for it. */
void rnd_material_set_kind(struct rnd_material *material);

#endif
