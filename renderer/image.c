/* Image files for the rest of the project: panoramas and views out, textures' and references' pixels in. */
#include "exr.h"
#include "math/srgb.h"
#include "renderer.h"
#include "import/image_io.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static bool read_pixels(const struct rnd_pixels_file *file, struct rnd_pixels *out_pixels,
                        char out_error[RND_ERROR_SIZE])
{
    char text[RND_ERROR_SIZE / 2];
    if (rnd_pixels_read(file, out_pixels, text, sizeof text)) return true;
    snprintf(out_error, RND_ERROR_SIZE, "%.200s: %s: %s", file->path,
             file->channel ? "cannot be read" : "not a readable image", text);
    return false;
}

float *rnd_image_read(const char *path, int *out_width, int *out_height, bool *out_display,
                      char out_error[RND_ERROR_SIZE])
{
    const struct rnd_pixels_file file = {.path = path, .use = RND_PIXELS_COLOUR};
    struct rnd_pixels pixels;
    if (!read_pixels(&file, &pixels, out_error)) return NULL;
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
    const struct rnd_pixels_file file = {.path = path, .use = RND_PIXELS_COLOUR, .channel = channel};
    struct rnd_pixels pixels;
    if (!read_pixels(&file, &pixels, out_error)) return NULL;
    *out_width = pixels.width;
    *out_height = pixels.height;
    return pixels.floats;
}

/* Pixels of a picture in memory. */
struct picture {
    struct rnd_pixels_source source; /* first */
    const float *rgb;
    size_t row; /* values */
    bool encode;
};

static void fill_rows(struct rnd_pixels_source *source, int first, int count, float *out_pixels)
{
    const struct picture *picture = (const struct picture *)(const void *)source;
    const float *from = picture->rgb + (size_t)first * picture->row;
    const size_t all = (size_t)count * picture->row;
    if (!picture->encode)
        memcpy(out_pixels, from, all * sizeof *from);
    else
        for (size_t i = 0; i < all; i++) out_pixels[i] = rnd_srgb_encode(from[i]);
}

bool rnd_image_write(FILE *file, const char *name, int width, int height, const float *rgb,
                     bool equirectangular, char out_error[RND_ERROR_SIZE])
{
    const char *dot = strrchr(name, '.'), *slash = strrchr(name, '/');
    char text[RND_ERROR_SIZE / 2];
    if (!dot || (slash && dot < slash) || !dot[1]) {
        snprintf(out_error, RND_ERROR_SIZE, "%.200s: expected a file name that ends in .exr, .png or .jpg",
                 name);
        return false;
    }
    const bool exr = strcasecmp(dot, ".exr") == 0, hdr = strcasecmp(dot, ".hdr") == 0;
    const enum rnd_channel_type type = exr   ? rnd_exr_type(rgb, (size_t)width * (size_t)height, 3, 3)
                                       : hdr ? RND_FLOAT
                                             : RND_BYTE;
    struct picture picture = {{fill_rows}, rgb, (size_t)width * 3, !exr && !hdr};
    struct rnd_layout layout = {.width = width,
                                .height = height,
                                .channels = 3,
                                .channel = {{"R", type}, {"G", type}, {"B", type}},
                                .equirectangular = equirectangular};
    snprintf(layout.format, sizeof layout.format, "%s", dot + 1);
    if (rnd_pixels_write(file, &layout, &picture.source, text, sizeof text)) return true;
    snprintf(out_error, RND_ERROR_SIZE, "%.200s: cannot be written: %s", name, text);
    return false;
}
