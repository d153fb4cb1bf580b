/* recording: several recordings in one table. Rows of different participants or recordings belong to
 * different gazes. */
#ifndef FOVEAD_TRACKER_LOG_RECORDING_H
#define FOVEAD_TRACKER_LOG_RECORDING_H

#include "log/reading.h"

/* Which recording a row belongs to: the wanted one, or another. SEVERAL: the option matches more than one
 * recording, or there is no option and the table holds more than one. */
enum trk_recording_row { TRK_RECORDING_WANTED, TRK_RECORDING_OTHER, TRK_RECORDING_SEVERAL };

/* Classify a row with these fields; NULL if the table lacks the column. */
enum trk_recording_row trk_recording_of_row(struct trk_reading *reading, const char *participant,
                                            const char *name);

/* Call it after the last row: does exactly one recording match the option? has_columns: the table has a
 * column that identifies recordings. False with a message that lists the recordings. */
bool trk_recording_is_met(const struct trk_reading *reading, bool has_columns,
                          char out_error[TRK_ERROR_SIZE]);

#endif
