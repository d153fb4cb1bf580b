/* The film: paths are added to its tiles, and it is read as a whole. */
#ifndef FOVEAD_RENDERER_FILM_H
#define FOVEAD_RENDERER_FILM_H

#include "film/tile.h"
#include "math/pool.h"

/* An empty film of generation 1. planes: the set of those that it keeps. False if memory is short; finish
 * it in any case. */
bool rnd_film_init(struct rnd_film *film, int width, int height, float error_bar, uint32_t planes,
                   const struct rnd_camera *camera);
void rnd_film_finish(struct rnd_film *film);

/* Empty the film for the paths of a camera: it is as at first, but of that generation. If history is not
 * NULL, its paths go there: to a film of the same size and planes, which loses its own. The threads of the
 * pool share the work. Other threads may read both films meanwhile: each tile is whole, or empty, or a
 * former one. */
void rnd_film_restart(struct rnd_film *film, struct rnd_film *history, const struct rnd_camera *camera,
                      uint32_t generation, struct rnd_pool *pool);

/* The number of the next path of a pixel; the one after it has the next one. */
uint32_t rnd_film_draw_listed(struct rnd_film_tile *tile, uint32_t pixel);
static inline uint32_t rnd_film_draw(struct rnd_film_tile *tile, uint32_t pixel)
{
    return tile->drawn > RND_FEW ? tile->pixels->drawn[pixel]++ : rnd_film_draw_listed(tile, pixel);
}

/* Add samples to a tile, with the values of the film's planes (film->planes.channels for each sample; NULL
 * if it has none). The tile remembers aim and now_ns as those of its newest batch. */
void rnd_film_add(const struct rnd_film *film, struct rnd_film_tile *tile, const struct rnd_sample *samples,
                  const float *planes, uint32_t count, const struct rnd_aim *aim, uint64_t now_ns);

/* Update tiles, laid out row by row: write those that changed since the last call. Returns their number;
 * their indices go to out_index, which has room for all. For one thread. */
uint32_t rnd_film_published(const struct rnd_film *film, struct rnd_tile *tiles, uint32_t *out_index);
/* The state of a tile as it was published last. Does not wait for its lock. */
void rnd_film_state(const struct rnd_film_tile *tile, struct rnd_tile *out_state);

/* Lock a tile for reading: wait for a thread that is just adding to it, but not for one that the system has
 * suspended. False if the lock is not to be had. */
bool rnd_film_lock_soon(struct rnd_film_tile *tile);

/* Of a tile whose lock is held: its paths are in its pixels after this. */
void rnd_film_spread(struct rnd_film_tile *tile);
/* Of such a pixel, its paths and the mean of its halves. Returns how many paths. */
uint32_t rnd_film_mean(const struct rnd_film_pixel *pixel, float out_mean[3]);
/* Standard error of its luminance, from the halves; 0 if one is empty. */
float rnd_film_error(const struct rnd_film_pixel *pixel);
/* Pixel i of a tile, wherever its paths are. */
struct rnd_film_pixel rnd_film_pixel_at(const struct rnd_film_tile *tile, uint32_t i);
/* In a film with planes: the record of a pixel, and the floats of a block. */
void *rnd_film_record(const struct rnd_film *film, const struct rnd_film_tile *tile, uint32_t pixel);
float *rnd_film_plane_block(const struct rnd_film *film, const struct rnd_film_tile *tile, uint32_t block);

/* The whole film: see rnd_render_resolve(). */
void rnd_film_resolve(const struct rnd_film *film, float *out_rgb, float *out_samples, float *out_error);

#endif
