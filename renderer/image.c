/* Image files for the rest of the project: panoramas and views out, textures' and references' pixels in. */
#include "image.h"
#include "math/srgb.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static bool read_pixels(const char *path, struct rnd_pixels *out_pixels, char out_error[RND_ERROR_SIZE])
{
    char text[RND_ERROR_SIZE / 2];
    if (rnd_pixels_read(path, NULL, 0, RND_PIXELS_COLOUR, false, out_pixels, text, sizeof text)) return true;
    snprintf(out_error, RND_ERROR_SIZE, "%.200s: not a readable image: %s", path, text);
    return false;
}

float *rnd_image_read(const char *path, int *out_width, int *out_height, bool *out_display,
                      char out_error[RND_ERROR_SIZE])
{
    struct rnd_pixels pixels;
    if (!read_pixels(path, &pixels, out_error)) return NULL;
    const size_t count = (size_t)pixels.width * pixels.height, n = pixels.channels;
    float *rgb = malloc(count * 3 * sizeof *rgb);
    if (!rgb) {
        snprintf(out_error, RND_ERROR_SIZE, "%.200s: not enough memory", path);
    } else {
        for (size_t i = 0; i < count; i++)
            for (size_t c = 0; c < 3; c++) rgb[3 * i + c] = pixels.floats[n * i + (n >= 3 ? c : 0)];
        *out_width = pixels.width;
        *out_height = pixels.height;
        if (out_display) *out_display = pixels.display;
    }
    rnd_pixels_finish(&pixels);
    return rgb;
}

float *rnd_image_read_channel(const char *path, const char *channel, int *out_width, int *out_height,
                              char out_error[RND_ERROR_SIZE])
{
    struct rnd_pixels pixels;
    if (!read_pixels(path, &pixels, out_error)) return NULL;
    int found = -1;
    for (int c = 0; c < pixels.channels; c++)
        if (strcmp(pixels.channel_names[c], channel) == 0) found = c;
    float *values = NULL;
    const size_t count = (size_t)pixels.width * pixels.height;
    if (found < 0)
        snprintf(out_error, RND_ERROR_SIZE, "%.200s: has no channel \"%.60s\"", path, channel);
    else if (!(values = malloc(count * sizeof *values)))
        snprintf(out_error, RND_ERROR_SIZE, "%.200s: not enough memory", path);
    for (size_t i = 0; values && i < count; i++) values[i] = pixels.floats[i * pixels.channels + found];
    *out_width = pixels.width;
    *out_height = pixels.height;
    rnd_pixels_finish(&pixels);
    return values;
}

bool rnd_image_write_channels(FILE *file, const char *name, int width, int height, int channels,
                              const struct rnd_channel *channel, const float *data, bool equirectangular,
                              char out_error[RND_ERROR_SIZE])
{
    const char *dot = strrchr(name, '.'), *slash = strrchr(name, '/');
    char text[RND_ERROR_SIZE / 2];
    if (!dot || (slash && dot < slash) || !dot[1]) {
        snprintf(out_error, RND_ERROR_SIZE, "%.200s: expected a file name that ends in .exr, .png or .jpg",
                 name);
        return false;
    }
    if (rnd_pixels_write(file, dot + 1, width, height, channels, channel, data, equirectangular, text,
                         sizeof text))
        return true;
    snprintf(out_error, RND_ERROR_SIZE, "%.200s: cannot be written: %s", name, text);
    return false;
}

enum rnd_channel_type rnd_exr_type(const float *values, size_t count)
{
    const float largest_half = 65504.0f;
    /* Half has steps of 2^-24 below 2^-14, that is of a sixteen-thousandth of this mean. */
    const double least_mean = 0x1p-10;
    double sum = 0.0;
    for (size_t i = 0; i < count; i++) {
        const float size = fabsf(values[i]);
        if (size > largest_half) return RND_FLOAT;
        sum += size;
    }
    return sum > 0.0 && sum < least_mean * (double)count ? RND_FLOAT : RND_HALF;
}

bool rnd_image_write(FILE *file, const char *name, int width, int height, const float *rgb,
                     bool equirectangular, char out_error[RND_ERROR_SIZE])
{
    const char *dot = strrchr(name, '.');
    const bool exr = dot && strcasecmp(dot, ".exr") == 0, hdr = dot && strcasecmp(dot, ".hdr") == 0;
    const size_t count = (size_t)width * height * 3;
    const enum rnd_channel_type type = exr ? rnd_exr_type(rgb, count) : hdr ? RND_FLOAT : RND_BYTE;
    const struct rnd_channel channel[3] = {{"R", type}, {"G", type}, {"B", type}};
    if (exr || hdr)
        return rnd_image_write_channels(file, name, width, height, 3, channel, rgb, equirectangular,
                                        out_error);

    float *stored = malloc(count * sizeof *stored);
    if (!stored) {
        snprintf(out_error, RND_ERROR_SIZE, "%.200s: not enough memory", name);
        return false;
    }
    for (size_t i = 0; i < count; i++) stored[i] = rnd_srgb_encode(rgb[i]);
    const bool ok =
        rnd_image_write_channels(file, name, width, height, 3, channel, stored, equirectangular, out_error);
    free(stored);
    return ok;
}
