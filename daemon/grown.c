/* Which tiles of the film are worth sending again. */
#include "grown.h"

/* The factor by which a tile's paths have grown since it was sent. A tile that was never sent counts as
 * having had 1 path. */
static double growth(uint64_t now, uint64_t sent)
{
    return (double)now / (double)(sent > 0 ? sent : 1);
}

size_t dmn_grown(const struct dmn_tile *tile, const uint64_t *sent, size_t count, double times, size_t limit,
                 uint32_t *out_index)
{
    size_t found = 0;

    for (size_t i = 0; i < count && limit > 0; i++) {
        const double grown = growth(tile[i].samples, sent[i]);
        size_t at;

        if (tile[i].samples <= sent[i] || (sent[i] > 0 && grown < times)) continue;
        if (found < limit)
            at = found++;
        else if (grown > growth(tile[out_index[limit - 1]].samples, sent[out_index[limit - 1]]))
            at = limit - 1;
        else
            continue;
        for (; at > 0 && grown > growth(tile[out_index[at - 1]].samples, sent[out_index[at - 1]]); at--)
            out_index[at] = out_index[at - 1];
        out_index[at] = (uint32_t)i;
    }
    return found;
}
