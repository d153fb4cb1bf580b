/* grown: which tiles of the film are worth sending again to a viewer that sees the film itself, and no
 * coarser levels. A pure function. */
#ifndef FOVEAD_DAEMON_GROWN_H
#define FOVEAD_DAEMON_GROWN_H

#include "pyramid.h"

/* Choose the tiles, of count, that have more paths than when they were sent. A tile that was sent before must
 * also have at least times as many paths as then. If more than limit qualify, those that have grown most are
 * chosen. sent has for each tile the paths that it had when it was sent; 0: it was never sent. out_index,
 * with room for limit, gets their indices, the most grown first. Returns how many. */
size_t dmn_grown(const struct dmn_tile *tile, const uint64_t *sent, size_t count, double times, size_t limit,
                 uint32_t *out_index);

#endif
