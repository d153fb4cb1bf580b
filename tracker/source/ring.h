/* ring: samples that wait for a reader, for sources that another thread fills.
 *
 * It holds about a second of a fast source. When the reader is later than that, the oldest sample is dropped
 * with its sequence number, so the reader sees the gap. Used with source->lock held. */
#ifndef FOVEAD_TRACKER_RING_H
#define FOVEAD_TRACKER_RING_H

#include "tracker.h"

enum { TRK_RING = 1024 };

struct trk_ring {
    struct trk_sample sample[TRK_RING];
    size_t first, count;
};

static inline void trk_ring_drop(struct trk_ring *ring)
{
    ring->first = (ring->first + 1) % TRK_RING;
    ring->count--;
}

static inline void trk_ring_put(struct trk_ring *ring, const struct trk_sample *sample)
{
    if (ring->count == TRK_RING) trk_ring_drop(ring);
    ring->sample[(ring->first + ring->count++) % TRK_RING] = *sample;
}

/* The oldest sample, which stays in the ring; NULL if there is none. */
static inline const struct trk_sample *trk_ring_first(const struct trk_ring *ring)
{
    return ring->count ? &ring->sample[ring->first] : NULL;
}

#endif
