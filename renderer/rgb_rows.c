/* A picture in memory as the rows of a file. */
#include "rgb_rows.h"
#include "exr.h"
#include "math/srgb.h"

#include <ctype.h>
#include <stdio.h>
#include <string.h>

static void fill_rows(struct rnd_pixels_source *source, int first, int count, float *out_pixels)
{
    const struct rnd_rgb_rows *rows = (const struct rnd_rgb_rows *)(const void *)source;
    const size_t row = (size_t)rows->layout.width * 3, all = (size_t)count * row;
    const float *from = rows->rgb + (size_t)first * row;
    if (!rows->encode)
        memcpy(out_pixels, from, all * sizeof *from);
    else
        for (size_t i = 0; i < all; i++) out_pixels[i] = rnd_srgb_encode(from[i]);
}

bool rnd_rgb_rows_init(struct rnd_rgb_rows *rows, const char *name, int width, int height, const float *rgb,
                       bool equirectangular, char out_error[RND_ERROR_SIZE])
{
    const char *dot = strrchr(name, '.'), *slash = strrchr(name, '/');
    if (!dot || (slash && dot < slash) || !dot[1]) {
        snprintf(out_error, RND_ERROR_SIZE, "%.200s: expected a file name that ends in .exr, .png or .jpg",
                 name);
        return false;
    }
    const bool exr = rnd_is_exr(name), hdr = strcasecmp(dot, ".hdr") == 0;
    const enum rnd_channel_type type = exr   ? rnd_exr_type(rgb, (size_t)width * (size_t)height, 3, 3)
                                       : hdr ? RND_FLOAT
                                             : RND_BYTE;
    *rows = (struct rnd_rgb_rows){.source = {fill_rows},
                                  .layout = {.width = width,
                                             .height = height,
                                             .channels = 3,
                                             .channel = {{"R", type}, {"G", type}, {"B", type}},
                                             .equirectangular = equirectangular},
                                  .rgb = rgb,
                                  .encode = !exr && !hdr};
    for (size_t i = 0; dot[1 + i] && i + 1 < sizeof rows->layout.format; i++)
        rows->layout.format[i] = (char)tolower((unsigned char)dot[1 + i]);
    return true;
}
