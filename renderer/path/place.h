/* Where the paths of a batch go: positions drawn around the gaze, sorted by tile. */
#ifndef FOVEAD_RENDERER_PLACE_H
#define FOVEAD_RENDERER_PLACE_H

#include "film/tile.h"
#include "math/pool.h"

enum { RND_OUTLINE = 16 }; /* pixels a side of the cells of the first coarse picture */

/* The paths of a tile in a batch. */
struct rnd_run {
    uint32_t tile, first, end;
    _Atomic uint32_t left; /* parts of waves that still have some of them */
};

struct rnd_places {
    const struct rnd_film *film;
    const struct rnd_distribution *distribution;
    uint32_t seed;
    uint32_t next_cell; /* cells of positions drawn so far */

    /* number of paths in the batch under way */
    uint32_t capacity;         /* of the arrays below, paths */
    float grid;                /* cells of positions along a side of the unit square */
    uint32_t *pixel;           /* of each path, as drawn: tile * RND_TILE_PIXELS + pixel within it */
    struct rnd_sample *sample; /* paths sorted by tile, first drawn first */
    float *planes;             /* of each path, values of the film's planes; NULL: it has none */
    uint32_t *run_of;          /* of each path, which run it belongs to */
    struct rnd_run *run;       /* tiles of them at most */
    uint32_t runs;
    uint32_t *start; /* where each tile's paths begin; tiles + 1 */
};

/* The film must outlive the places. False if memory is short; finish it in any case. */
bool rnd_places_init(struct rnd_places *places, const struct rnd_film *film,
                     const struct rnd_distribution *distribution, uint32_t seed);
void rnd_places_finish(struct rnd_places *places);

/* Have room for a batch of so many paths. False if memory is short. */
bool rnd_places_reserve(struct rnd_places *places, uint32_t paths);
/* Draw the positions of paths around aim by the distribution, sort them by tile and number them. There is
 * room. */
void rnd_places_draw(struct rnd_places *places, struct rnd_pool *pool, const struct rnd_aim *aim,
                     uint32_t paths);
/* The same, with one path in each of the cells of the first coarse picture, of which there are so many. */
uint32_t rnd_places_of_outline(const struct rnd_film *film);
void rnd_places_outline(struct rnd_places *places, uint32_t paths);

#endif
