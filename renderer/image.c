/* Image files for the rest of the project: panoramas and views out, textures' and references' pixels in. */
#include "renderer.h"
#include "import/image_io.h"
#include "rgb_rows.h"

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

bool rnd_image_write(FILE *file, const char *name, int width, int height, const float *rgb,
                     bool equirectangular, char out_error[RND_ERROR_SIZE])
{
    char text[RND_ERROR_SIZE / 2];
    struct rnd_rgb_rows rows;
    if (!rnd_rgb_rows_init(&rows, name, width, height, rgb, equirectangular, out_error)) return false;
    if (rnd_pixels_write(file, &rows.layout, &rows.source, text, sizeof text)) return true;
    snprintf(out_error, RND_ERROR_SIZE, "%.200s: cannot be written: %s", name, text);
    return false;
}
