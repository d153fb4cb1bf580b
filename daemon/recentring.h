/* recentring: the rotation that recentring gave an eye tracker, kept from one start of fovead to the next in
 * $XDG_STATE_HOME/fovead (or ~/.local/state/fovead). */
#ifndef FOVEAD_DAEMON_RECENTRING_H
#define FOVEAD_DAEMON_RECENTRING_H

#include "daemon.h"

/* Path of the file; false if the environment names no folder for it. */
bool dmn_recentring_path(char *out_path, size_t size);
/* Read the rotation (x, y, z, w). False if there is none, or, with a line on stderr, if its file is broken.
 */
bool dmn_recentring_load(float out_rotation[4]);
/* Write the rotation; missing folders are made. False with a line in out_error. */
bool dmn_recentring_save(const float rotation[4], char out_error[TRK_ERROR_SIZE]);

#endif
