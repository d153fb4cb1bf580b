/* grown: which tiles of the film are worth sending again to a viewer that sees the film itself, and no
 * coarser levels. A pure function. */
#ifndef FOVEAD_DAEMON_GROWN_H
#define FOVEAD_DAEMON_GROWN_H

#include "pyramid.h"

/* Of count tiles those that have more paths than when they were sent, and at least so many times as many;
 * at most limit of them, those that have grown most first. sent has their paths when they were sent; 0:
 * they were not. Returns how many; out_index has room for limit. */
size_t dmn_grown(const struct dmn_tile *tile, const uint64_t *sent, size_t count, double times, size_t limit,
                 uint32_t *out_index);

#endif
