/* The film: tiles of pixels. A pixel has two half-means, whose difference tells its error.
 *
 * One thread at a time writes a tile. It holds the tile's lock only while it adds finished samples, so a
 * reader never sees half an addition and never waits for a ray. The state of a tile is also published, and
 * can be read without the lock: if the system suspends a thread that holds the lock, nobody who only reads
 * states has to wait.
 *
 * Pixels are most of a film. They lie in memory of their own, which is not touched before the tile has more
 * than a few paths: fresh memory is slow, and the first coarse picture must not wait for all of it.
 */
#ifndef FOVEAD_RENDERER_TILE_H
#define FOVEAD_RENDERER_TILE_H

#include "film/planes.h"
#include "renderer.h"
#include "space/camera.h"

#include <pthread.h>
#include <stdatomic.h>

enum {
    RND_TILE_PIXELS = RND_TILE * RND_TILE,
    RND_BLOCK = 8, /* pixels a side of a block, whose means make the coarse levels cheap */
    RND_TILE_BLOCKS = (RND_TILE / RND_BLOCK) * (RND_TILE / RND_BLOCK),
    RND_FEW = 32, /* paths of a tile that are listed; the first coarse picture has 16 */
    RND_STATE_WORDS = (sizeof(struct rnd_tile) + 7) / 8,
};

/* A path's end: its pixel within the tile, and its contribution. */
struct rnd_sample {
    uint32_t pixel;  /* RND_TILE_PIXELS: it was left out */
    uint32_t number; /* the pixel's paths before this one; even ones go to half 0, odd ones to half 1 */
    float rgb[3];
};

/* A pixel's two halves, in one line of the cache. Means, because sums of many thousand paths would lose what
 * single ones add. */
struct rnd_film_pixel {
    uint32_t count[2]; /* paths in each half */
    float half[2][3];  /* mean radiance of each half; 0 without paths */
};

/* The pixels of a tile. */
struct rnd_film_pixels {
    struct rnd_film_pixel pixel[RND_TILE_PIXELS];
    uint32_t drawn[RND_TILE_PIXELS]; /* paths that positions were drawn for */
};
_Static_assert(sizeof(struct rnd_film_pixels) % 64 == 0, "no pixel lies in two lines of the cache");

/* What a block's pixels hold: its mean is light / visited, each pixel counting alike. Doubles, because what
 * they gain with every path is small. */
struct rnd_film_block {
    double light[3]; /* sum of the mean radiance of pixels */
    uint64_t paths;
    uint32_t visited, lit; /* pixels that have paths, that have found light */
};

struct rnd_film_tile {
    pthread_mutex_t lock; /* guards all that follows, but for what is published and what is drawn */
    struct rnd_tile state;
    struct rnd_camera
        camera; /* where its paths begin: while a film is begun anew, not yet the same for all tiles */
    uint64_t next_judgement; /* samples at which the error is worth a look */
    float former_error;      /* sure error: of the last judgement alone, INFINITY before */
    float grain;             /* mean radiance of the paths that find light; negative before it is known */
    bool spread;             /* its paths are in the pixels, and not in the list below */
    uint32_t listed;         /* of the list: */
    struct rnd_sample list[RND_FEW]; /* all its paths, in the order in which they were added */
    struct rnd_film_pixels *pixels;  /* without meaning before they are in use */
    void *planes;                    /* as film/planes.h has it; NULL: the film has none */
    struct rnd_film_block block[RND_TILE_BLOCKS];

    /* The state as it was published last, in the half that the turn names; the next one goes to the other. */
    _Atomic uint32_t turn;
    _Atomic uint64_t published[2][RND_STATE_WORDS];

    /* Paths that positions were drawn for; a batch that was cut short leaves some of them out. They are in
     * drawn_list, or in the pixels once there are more than RND_FEW. Only whoever places a batch looks at
     * this.
     */
    uint32_t drawn;
    uint16_t drawn_list[RND_FEW];
};

/* A value of a tile, and its solid angle but for a common factor. */
struct rnd_weighed {
    float value, weight;
};

struct rnd_film {
    int width, height; /* pixels */
    int across, down;  /* tiles */
    float error_bar;
    struct rnd_film_tile *tile;     /* row by row */
    struct rnd_film_pixels *pixels; /* theirs, in the same order */
    struct rnd_planes planes;       /* that it keeps beside radiance */
    uint8_t *plane_memory;          /* of its tiles, in the same order; NULL: no planes */
    _Atomic uint64_t
        *published; /* a bit for each tile: it was, and rnd_render_published() has not told so yet */
    /* Of the picture as a whole, by rnd_film_survey(); it changes between batches only. */
    float brightness; /* luminance that tiles have: the median, or the mean where most are black; 0 before */
    float grain;      /* of tiles: what one in ten exceeds */
    uint64_t paths, next_survey;
    struct rnd_weighed *weighed; /* room for one for each tile */
};

#endif
