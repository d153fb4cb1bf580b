/* samples: how a log keeps its samples.
 *
 * These functions add and replace samples; trk_log_sample() and trk_log_time() of tracker.h read them. Only
 * one thread may use a log while it is made or changed. */
#ifndef FOVEAD_TRACKER_SAMPLES_H
#define FOVEAD_TRACKER_SAMPLES_H

#include "tracker.h"

/* Append a sample. False when memory is short; the log is then as it was. */
bool trk_samples_add(struct trk_log *log, const struct trk_sample *sample);

/* Replace sample i of log->count. Fast where i goes up or down step by step. False when memory is short; the
 * log is then as it was. */
bool trk_samples_put(struct trk_log *log, size_t i, const struct trk_sample *sample);

/* To be called when no more is to be added or replaced for now: pack the block that is still open. False when
 * memory is short. */
bool trk_samples_pack(struct trk_log *log);

/* Accepts NULL. */
void trk_samples_destroy(struct trk_samples *samples);

#endif
