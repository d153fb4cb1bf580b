/* A render in progress: the scene, the film, the threads, and how far the random numbers have been used. */
#ifndef FOVEAD_RENDERER_RENDER_H
#define FOVEAD_RENDERER_RENDER_H

#include "film.h"
#include "light/choice.h"
#include "math/pool.h"
#include "scene/scene.h"

#include <pthread.h>
#include <stdatomic.h>

struct rnd_worker; /* one thread's own memory: path/batch.c */

/* The paths of a tile in a batch. */
struct rnd_run {
    uint32_t tile, first, end;
    _Atomic uint32_t left; /* parts of waves that still have some of them */
};

struct rnd_render {
    const struct rnd_scene *scene;
    float eye[3];   /* in the scene's own coordinates */
    uint64_t media; /* rnd_media that the eye is in: path/media.h */
    const struct rnd_distribution *distribution;
    struct rnd_film film;
    pthread_mutex_t whole; /* held while the film is read as a whole, and while it is emptied */
    struct rnd_pool *pool;
    struct rnd_worker *worker; /* one for each thread of the pool */
    int workers;
    uint32_t seed;
    uint32_t next_cell;  /* cells of positions drawn so far */
    uint32_t generation; /* of the film, from 1: each restart begins the next */
    bool surveyed;       /* the lights, from this eye */
    struct rnd_light_choice choice;

    /* the batch under way */
    uint32_t capacity;         /* of the arrays below, paths */
    float grid;                /* cells of positions along a side of the unit square */
    uint32_t *pixel;           /* of paths as drawn: tile * RND_TILE_PIXELS + pixel within it */
    struct rnd_sample *sample; /* of paths by tile, first drawn first */
    uint32_t *run_of;          /* which run each of them is in */
    struct rnd_run *run;       /* tiles of them at most */
    uint32_t runs;
    uint32_t *start; /* where each tile's paths begin; tiles + 1 */
};

/* path/survey.c: which lights points should ask for, by what really arrives of each around the eye. The
 * threads of the pool share the work; the answer is the same with any number. */
void rnd_survey_lights(const struct rnd_scene *scene, const float eye[3], struct rnd_pool *pool,
                       struct rnd_light_choice *out);

/* path/place.c: draw the positions of paths around aim (drawn: by the render's distribution, else one in
 * every cell of the outline), sort them by tile and number them. */
enum { RND_OUTLINE = 16 }; /* pixels a side of the cells of the first coarse picture */
void rnd_place(struct rnd_render *render, const struct rnd_aim *aim, uint32_t paths, bool drawn);

#endif
