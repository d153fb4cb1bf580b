/* Whether the values of an EXR fit half floats, or need floats. */
#ifndef FOVEAD_RENDERER_EXR_H
#define FOVEAD_RENDERER_EXR_H

#include "import/image_io.h"

/* Is a file of that name an EXR, which holds radiance? */
bool rnd_is_exr(const char *name);

/* How an EXR stores channels that lie side by side, stride values from pixel to pixel: as half floats, or as
 * floats if a value is beyond half's range, or if their mean is so small that half's steps would show. */
enum rnd_channel_type rnd_exr_type(const float *values, size_t pixels, size_t stride, size_t channels);

#endif
