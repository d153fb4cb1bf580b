/* What materials of all formats share. */
#ifndef FOVEAD_RENDERER_MATERIAL_H
#define FOVEAD_RENDERER_MATERIAL_H

#include "scene/scene.h"

/* glTF's default: white, wholly metallic and rough, without a texture. */
void rnd_material_init(struct rnd_material *material);
/* Reflectance of the non-metal at normal incidence, by way of index and tint. */
void rnd_material_set_f0(struct rnd_material *material, vec3s f0);
/* The cheapest kind that is right for it. */
void rnd_material_set_kind(struct rnd_material *material);

/* Media, and tables for those that are rough glass. False if memory is short. */
bool rnd_materials_build(struct rnd_scene *scene);

#endif
