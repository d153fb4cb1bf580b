/* Reading an environment map. */
#ifndef FOVEAD_RENDERER_ENVIRONMENT_H
#define FOVEAD_RENDERER_ENVIRONMENT_H

#include "scene/scene.h"

/* Read the scene's environment map. out_warning is a line about pixels that are no radiance, or "". False and
 * a line in out_error on failure. */
bool rnd_environment_read(struct rnd_scene *scene, const char *path, float azimuth_deg,
                          char out_warning[RND_ERROR_SIZE], char out_error[RND_ERROR_SIZE]);

#endif
