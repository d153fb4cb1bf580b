/* image: pictures as files that appear whole or not at all. */
#ifndef FOVEAD_DAEMON_IMAGE_H
#define FOVEAD_DAEMON_IMAGE_H

#include "daemon.h"

/* As rnd_image_write(), to a path, as a file of that mode. An existing file is replaced. */
bool dmn_image_write(const char *path, mode_t mode, int width, int height, const float *rgb,
                     bool equirectangular, char out_error[RND_ERROR_SIZE]);

#endif
