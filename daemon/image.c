/* Pictures as files that appear whole or not at all. */
#include "image.h"

#include "file.h"

bool dmn_image_write(const char *path, mode_t mode, int width, int height, const float *rgb,
                     bool equirectangular, char out_error[RND_ERROR_SIZE])
{
    struct dmn_file file;

    if (!dmn_file_begin(&file, path, mode, true, out_error)) return false;
    if (rnd_image_write(file.file, path, width, height, rgb, equirectangular, out_error))
        return dmn_file_end(&file, out_error);
    dmn_file_drop(&file);
    return false;
}
