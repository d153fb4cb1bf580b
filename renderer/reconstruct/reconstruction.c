/* The table of reconstructions, and what rows may ask for. */
#include "reconstruct/reconstruction.h"

#define ROW(name) &rnd_reconstruction_##name,
static const struct rnd_reconstruction *const table[] = {RND_RECONSTRUCTIONS(ROW)};

const struct rnd_reconstruction *rnd_reconstruction_at(size_t index)
{
    return index < sizeof table / sizeof *table ? table[index] : NULL;
}

bool rnd_window_history(const struct rnd_window *window, int level, int x, int y, struct rnd_sums *out_sums,
                        float *out_planes)
{
    struct rnd_tile tile;
    return window->history && rnd_film_sums(window->history, level, x, y, out_sums, out_planes, &tile) &&
           tile.samples > 0 && tile.generation < window->generation;
}
