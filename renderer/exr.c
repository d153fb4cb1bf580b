/* Whether the values of an EXR fit half floats, or need floats. */
#include "exr.h"

#include <math.h>
#include <string.h>

bool rnd_is_exr(const char *name)
{
    const char *dot = strrchr(name, '.');
    return dot && strcasecmp(dot, ".exr") == 0;
}

enum rnd_channel_type rnd_exr_type(const float *values, size_t pixels, size_t stride, size_t channels)
{
    const float largest_half = 65504.0f;
    /* Half has steps of 2^-24 below 2^-14, that is of a sixteen-thousandth of this mean. */
    const double least_mean = 0x1p-10;
    double sum = 0.0;
    for (size_t i = 0; i < pixels; i++)
        for (size_t c = 0; c < channels; c++) {
            const float size = fabsf(values[i * stride + c]);
            if (size > largest_half) return RND_FLOAT;
            sum += size;
        }
    return sum > 0.0 && sum < least_mean * (double)(pixels * channels) ? RND_FLOAT : RND_HALF;
}
