/* A scene file: which reader it is for. */
#ifndef FOVEAD_RENDERER_FORMATS_H
#define FOVEAD_RENDERER_FORMATS_H

#include "scene/scene.h"

/* Read geometry, materials, textures and punctual lights of a file. */
bool rnd_import(struct rnd_scene *scene, const char *path, char out_error[RND_ERROR_SIZE]);

#endif
