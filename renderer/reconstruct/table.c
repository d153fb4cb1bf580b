/* The reconstructions, in the order of their table. */
#include "reconstruct/reconstruction.h"

#define ROW(name) &rnd_reconstruction_##name,
static const struct rnd_reconstruction *const table[] = {RND_RECONSTRUCTIONS(ROW)};

const struct rnd_reconstruction *rnd_reconstruction_at(size_t index)
{
    return index < sizeof table / sizeof *table ? table[index] : NULL;
}
