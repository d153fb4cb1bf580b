/* Writing an image with channels of its own. */
#ifndef FOVEAD_RENDERER_IMAGE_H
#define FOVEAD_RENDERER_IMAGE_H

#include "renderer.h"
#include "scene/image_io.h"

/* As rnd_image_write(), for interleaved floats of named channels. */
bool rnd_image_write_channels(FILE *file, const char *name, int width, int height, int channels,
                              const struct rnd_channel *channel, const float *data, bool equirectangular,
                              char out_error[RND_ERROR_SIZE]);

/* How an EXR stores count values: as half floats, or as floats if one is beyond half's range, or if their
 * mean is so small that half's steps would show. */
enum rnd_channel_type rnd_exr_type(const float *values, size_t count);

#endif
