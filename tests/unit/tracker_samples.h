/* Access to the samples of a log, for tests. */
#ifndef FOVEAD_TESTS_TRACKER_SAMPLES_H
#define FOVEAD_TESTS_TRACKER_SAMPLES_H

#include "tracker.h"

#include <stdlib.h>
#include <string.h>

/* Sample i. It stays valid until eight more have been asked for. */
static inline const struct trk_sample *sample_at(const struct trk_log *log, size_t i)
{
    static struct trk_sample samples[8];
    static unsigned next;
    struct trk_sample *sample = &samples[next++ % 8];
    trk_log_sample(log, i, sample);
    return sample;
}

/* All samples of the log. The caller frees them. */
static inline struct trk_sample *samples_of(const struct trk_log *log)
{
    struct trk_sample *samples = malloc(log->count * sizeof *samples);
    for (size_t i = 0; samples && i < log->count; i++) trk_log_sample(log, i, &samples[i]);
    return samples;
}

static inline bool same_samples(const struct trk_log *a, const struct trk_log *b)
{
    bool same = a->count == b->count;
    for (size_t i = 0; same && i < a->count; i++)
        same = memcmp(sample_at(a, i), sample_at(b, i), sizeof(struct trk_sample)) == 0;
    return same;
}

#endif
