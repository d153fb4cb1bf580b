/* A picture in memory as the rows of a file. */
#ifndef FOVEAD_RENDERER_RGB_ROWS_H
#define FOVEAD_RENDERER_RGB_ROWS_H

#include "import/image_io.h"
#include "renderer.h"

struct rnd_rgb_rows {
    struct rnd_pixels_source source; /* first */
    struct rnd_layout layout;
    const float *rgb;
    bool encode; /* as sRGB */
};

/* In the format that the end of name says: see rnd_image_write(). rgb must stay as long as rows are asked
 * for. False with a line in out_error if the name has no end. */
bool rnd_rgb_rows_init(struct rnd_rgb_rows *rows, const char *name, int width, int height, const float *rgb,
                       bool equirectangular, char out_error[RND_ERROR_SIZE]);

#endif
