/* The film as a file that appears whole or not at all. */
#include "save.h"

#include "file.h"

bool dmn_save_film(struct rnd_render *render, const char *path, const struct rnd_exposure *exposure,
                   char out_error[RND_ERROR_SIZE])
{
    struct dmn_file file;

    if (!dmn_file_begin(&file, path, 0666, true, out_error)) return false;
    if (rnd_render_save(render, file.file, path, exposure, out_error)) return dmn_file_end(&file, out_error);
    dmn_file_drop(&file);
    return false;
}
