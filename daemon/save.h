/* save: the film as a file. */
#ifndef FOVEAD_DAEMON_SAVE_H
#define FOVEAD_DAEMON_SAVE_H

#include "renderer.h"

/* As rnd_render_save(), to a path, as a file that appears whole or not at all. An existing file is replaced.
 */
bool dmn_save_film(struct rnd_render *render, const char *path, const struct rnd_exposure *exposure,
                   char out_error[RND_ERROR_SIZE]);

#endif
