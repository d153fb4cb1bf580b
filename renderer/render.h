/* A render in progress: the scene, the film, the threads, and how far the random numbers have been used. */
#ifndef FOVEAD_RENDERER_RENDER_H
#define FOVEAD_RENDERER_RENDER_H

#include "film.h"
#include "path/pool.h"
#include "scene/scene.h"

#include <pthread.h>

struct rnd_worker; /* one thread's own memory: path/batch.c */

struct rnd_render {
    const struct rnd_scene *scene;
    float eye[3];
    const struct rnd_distribution *distribution;
    struct rnd_film film;
    pthread_mutex_t whole; /* held while the film is read as a whole, and while it is emptied */
    struct rnd_pool *pool;
    struct rnd_worker *worker; /* one for each thread of the pool */
    int workers;
    uint32_t seed;
    uint32_t next_place; /* positions drawn so far: the index of the next one */
    uint32_t generation; /* restarts so far */

    /* the batch under way */
    uint32_t capacity; /* of the arrays below, paths */
    float *place;      /* directions: 3 a path */
    uint32_t *pixel;   /* tile * RND_TILE_PIXELS + pixel within it */
    uint32_t *order;   /* paths sorted by tile, first drawn first */
    uint32_t *start;   /* where each tile's paths begin in order; tiles + 1 */
    uint32_t *chunk;   /* tiles at which the shares of work begin; at most tiles + 1 */
};

#endif
