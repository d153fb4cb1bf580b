/* Pictures as files that are there whole or not at all. */
#include "image.h"

#include "file.h"

static bool end(struct dmn_file *file, bool good, char out_error[RND_ERROR_SIZE])
{
    if (good) return dmn_file_end(file, out_error);
    dmn_file_drop(file);
    return false;
}

bool dmn_image_write(const char *path, mode_t mode, int width, int height, const float *rgb,
                     bool equirectangular, char out_error[RND_ERROR_SIZE])
{
    struct dmn_file file;

    return dmn_file_begin(&file, path, mode, true, out_error) &&
           end(&file, rnd_image_write(file.file, path, width, height, rgb, equirectangular, out_error),
               out_error);
}

bool dmn_image_save(struct rnd_render *render, const char *path, char out_error[RND_ERROR_SIZE])
{
    struct dmn_file file;

    return dmn_file_begin(&file, path, 0666, true, out_error) &&
           end(&file, rnd_render_save(render, file.file, path, out_error), out_error);
}
