/* Reads a scene file, by the reader of its format. */
#ifndef FOVEAD_RENDERER_FORMATS_H
#define FOVEAD_RENDERER_FORMATS_H

#include "scene/scene.h"

/* Read geometry, materials, textures and punctual lights of a file. False and a line in out_error. */
bool rnd_import(struct rnd_scene *scene, const char *path, char out_error[RND_ERROR_SIZE]);

#endif
