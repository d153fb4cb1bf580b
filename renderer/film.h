/* The film: tiles of pixels with two half-sums each, so that their difference tells the error.
 *
 * A tile is written by one thread at a time; its lock is held only while finished samples are added, so that
 * a reader never sees half an addition and never waits for a ray.
 */
#ifndef FOVEAD_RENDERER_FILM_H
#define FOVEAD_RENDERER_FILM_H

#include "renderer.h"

#include <sched.h>
#include <stdatomic.h>

enum {
    RND_TILE_PIXELS = RND_TILE * RND_TILE,
    RND_BLOCK = 8, /* pixels a side of a block, whose sums make the coarse levels cheap */
    RND_TILE_BLOCKS = (RND_TILE / RND_BLOCK) * (RND_TILE / RND_BLOCK),
};

struct rnd_film_tile {
    atomic_flag lock; /* guards everything below */
    struct rnd_tile state;
    uint64_t next_judgement;           /* samples at which the error is worth a look */
    bool passed;                       /* the last judgement was below the bar */
    uint32_t count[RND_TILE_PIXELS];   /* paths; even ones went to half 0, odd ones to half 1 */
    float half[2][RND_TILE_PIXELS][3]; /* sums of radiance; without meaning where count is 0 */
    float block[RND_TILE_BLOCKS][4];   /* sums of radiance, and the count */
};

struct rnd_film {
    int width, height; /* pixels */
    int across, down;  /* tiles */
    float error_bar;
    struct rnd_film_tile *tile; /* row by row */
};

/* A path's end: which pixel of its tile, what it brought. */
struct rnd_sample {
    uint32_t pixel, number; /* number: the pixel's paths before this one */
    float rgb[3];
};

bool rnd_film_init(struct rnd_film *film, int width, int height, float error_bar);
void rnd_film_finish(struct rnd_film *film);
/* Take all paths out of a tile: it is as at first, but of that generation. */
void rnd_film_empty(struct rnd_film_tile *tile, uint32_t generation);

/* Add samples to a tile; aim and now_ns are what it remembers as its newest batch. */
void rnd_film_add(const struct rnd_film *film, struct rnd_film_tile *tile, const struct rnd_sample *samples,
                  uint32_t count, const struct rnd_aim *aim, uint64_t now_ns);

static inline void rnd_film_lock(struct rnd_film_tile *tile)
{
    while (atomic_flag_test_and_set_explicit(&tile->lock, memory_order_acquire)) sched_yield();
}

static inline void rnd_film_unlock(struct rnd_film_tile *tile)
{
    atomic_flag_clear_explicit(&tile->lock, memory_order_release);
}

/* converge.c: the tile's error by its half-buffers, and whether it is converged. Call with the lock held. */
void rnd_judge(struct rnd_film_tile *tile, float error_bar);

#endif
