/* foreign: recognises files that people mistake for gaze logs, by their first bytes or their header. The
 * message says what the file is and which file is wanted instead. */
#ifndef FOVEAD_TRACKER_LOG_FOREIGN_H
#define FOVEAD_TRACKER_LOG_FOREIGN_H

#include "log/reading.h"

/* Check the file's first bytes: reading->head holds `size` of them. False with a message if the file is
 * foreign. */
bool trk_check_magic(const struct trk_reading *reading, size_t size, char out_error[TRK_ERROR_SIZE]);
/* Check the file's header, for files that lie beside a gaze log or have its name but hold no gaze. False with
 * a message if it is such a file. */
bool trk_check_namesakes(const struct trk_reading *reading, char out_error[TRK_ERROR_SIZE]);

#endif
