/* samples: how a log keeps its samples.
 *
 * These functions add and replace samples; trk_log_sample() and trk_log_time() of tracker.h read them. Only
 * one thread may use a log while it is made or changed. */
#ifndef FOVEAD_TRACKER_SAMPLES_H
#define FOVEAD_TRACKER_SAMPLES_H

#include "tracker.h"

/* Append a sample. False if memory runs out; then the log is unchanged. */
bool trk_samples_add(struct trk_log *log, const struct trk_sample *sample);

/* Replace sample i. Fast if successive calls go up or down in steps of one. False if memory runs out; then
 * the log is unchanged. */
bool trk_samples_put(struct trk_log *log, size_t i, const struct trk_sample *sample);

/* Pack the block that is still open. Call it when no samples are to be added or replaced for now. False if
 * memory runs out. */
bool trk_samples_pack(struct trk_log *log);

/* Accepts NULL. */
void trk_samples_destroy(struct trk_samples *samples);

#endif
