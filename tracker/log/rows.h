/* rows: checks on the samples of every format: order, limits, sorting. */
#ifndef FOVEAD_TRACKER_LOG_ROWS_H
#define FOVEAD_TRACKER_LOG_ROWS_H

#include "log/reading.h"

enum { TRK_MAX_ROWS = 64 * 1024 * 1024 }; /* 6 days at 120 Hz */

/* The longest span of device time, 104 days in ns. Beyond 2^53 a double no longer represents every
 * nanosecond, so a speed factor could not be applied exactly. */
#define TRK_MAX_DEVICE_NS (UINT64_C(1) << 53)

#define TRK_MAX_DISORDER_NS UINT64_C(1000000000)

/* Append a sample. False with a message if sequence or one of the times goes back, device time exceeds
 * TRK_MAX_DEVICE_NS, or there are more than TRK_MAX_ROWS rows. */
bool trk_log_append(struct trk_reading *reading, const struct trk_sample *sample,
                    char out_error[TRK_ERROR_SIZE]);

/* Sort the samples of a log whose rows may be out of order, and renumber them. Their times start at
 * TRK_MAX_DISORDER_NS, so that no time is below 0 before the sort. False if memory runs out. */
bool trk_rows_sort(struct trk_reading *reading);

#endif
