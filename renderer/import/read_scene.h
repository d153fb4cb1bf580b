/* Reading a scene file by fovead-reader. */
#ifndef FOVEAD_RENDERER_READ_SCENE_H
#define FOVEAD_RENDERER_READ_SCENE_H

#include "scene/scene.h"

/* As rnd_import(), but by fovead-reader, whose answer is checked. False and a line in out_error. */
bool rnd_scene_read(struct rnd_scene *scene, const struct rnd_scene_options *options,
                    char out_error[RND_ERROR_SIZE]);

#endif
