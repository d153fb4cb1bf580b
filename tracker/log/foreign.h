/* foreign: files that people take for gaze logs and that are none. Their first bytes or their header give
 * them away; the message names what the file is and what is wanted instead. */
#ifndef FOVEAD_TRACKER_LOG_FOREIGN_H
#define FOVEAD_TRACKER_LOG_FOREIGN_H

#include "log/reading.h"

/* By the file's first bytes, of which reading->head holds size. False with a message if it is foreign. */
bool trk_check_magic(const struct trk_reading *reading, size_t size, char out_error[TRK_ERROR_SIZE]);
/* By its header: a file that lies beside a gaze log, or bears its name, and holds no gaze. */
bool trk_check_namesakes(const struct trk_reading *reading, char out_error[TRK_ERROR_SIZE]);

#endif
