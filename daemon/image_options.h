/* image_options: what command lines and requests say about files of pictures. */
#ifndef FOVEAD_DAEMON_IMAGE_OPTIONS_H
#define FOVEAD_DAEMON_IMAGE_OPTIONS_H

#include "daemon.h"
#include "option.h"

/* How names of pictures end, for people. */
#define DMN_IMAGE_ENDS ".exr, .png or .jpg"
/* Does a path end so, in any letter case? .jpeg is taken too. */
bool dmn_image_is_named(const char *path);
bool dmn_image_is_exr(const char *path);

/* Takes stops or "auto" into the struct rnd_exposure at the option's target. */
bool dmn_take_exposure(const struct dmn_option *option, const char *text, void *values, char *out_error);

#endif
