/* recording: several recordings in one table. Rows of different participants or recordings are not one gaze.
 */
#ifndef FOVEAD_TRACKER_LOG_RECORDING_H
#define FOVEAD_TRACKER_LOG_RECORDING_H

#include "log/reading.h"

/* Whose a row is. SEVERAL: the option fits more than one recording, or there is no option and earlier rows
 * are of another recording. */
enum trk_recording_row { TRK_RECORDING_WANTED, TRK_RECORDING_OTHER, TRK_RECORDING_SEVERAL };

/* A row with these fields; NULL where the table has no such column. */
enum trk_recording_row trk_recording_of_row(struct trk_reading *reading, const char *participant,
                                            const char *name);

/* After the last row: is there exactly one recording that the option means? has_columns: the table tells
 * recordings apart. False with a message that names the recordings. */
bool trk_recording_is_met(const struct trk_reading *reading, bool has_columns,
                          char out_error[TRK_ERROR_SIZE]);

#endif
