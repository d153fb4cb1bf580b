/* rows: what every log must hold, whatever its format: order, limits, sorting. */
#ifndef FOVEAD_TRACKER_LOG_ROWS_H
#define FOVEAD_TRACKER_LOG_ROWS_H

#include "log/reading.h"

enum { TRK_MAX_ROWS = 64 * 1024 * 1024 }; /* 6 days at 120 Hz */

/* The longest span of device time, 104 days in ns: beyond 2^53 a double no longer counts nanoseconds, and a
 * speed factor could not be applied exactly. */
#define TRK_MAX_DEVICE_NS (UINT64_C(1) << 53)

#define TRK_MAX_DISORDER_NS UINT64_C(1000000000)

/* Append a sample. False with a message if sequence or one of the times goes back, device time exceeds
 * TRK_MAX_DEVICE_NS, or there are more than TRK_MAX_ROWS rows. */
bool trk_log_append(struct trk_reading *reading, const struct trk_sample *sample,
                    char out_error[TRK_ERROR_SIZE]);

/* Sort a disordered log, whose times start at TRK_MAX_DISORDER_NS so that none is below 0, and number its
 * samples again. False when memory is short. */
bool trk_rows_sort(struct trk_reading *reading);

#endif
