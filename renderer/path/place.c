/* Where the paths of a batch go: positions drawn around the gaze, sorted by tile.
 *
 * A position is drawn as a point of the unit square, which the distribution warps onto the sphere. Sixteen
 * paths at a time share one of the square's cells, so that their rays keep together in Embree's packets;
 * cells follow each other as Owen-scrambled Sobol points do, spread evenly at every length of a batch. A cell
 * holds the same share of a distribution's samples wherever it lies, so it is small at the fovea and grows
 * towards the periphery.
 *
 * Nothing here looks at what earlier paths have found. A place that got fewer paths because it looked
 * good would keep what it has found, and lack what it has not found yet: the mean of all such places would be
 * too dark where light is rare.
 */
#include "path/place.h"
#include "film/film.h"
#include "math/sampler.h"
#include "math/uv.h"

#include <stdlib.h>
#include <string.h>

enum {
    CELL = 16,        /* paths in a cell, four by four */
    MOST_CELLS = 256, /* along a side of the square */
};

/* tile * RND_TILE_PIXELS + pixel within it */
RND_INLINE uint32_t pixel_index(uint32_t across, uint32_t x, uint32_t y)
{
    const uint32_t tile = y / RND_TILE * across + x / RND_TILE;
    return tile * RND_TILE_PIXELS + y % RND_TILE * RND_TILE + x % RND_TILE;
}

enum { SOME = 256 }; /* positions at a time */

/* The places of count directions, at most SOME. */
static void pixels_of(const struct rnd_film *film, uint32_t count, const float *direction,
                      uint32_t *out_pixel)
{
    const float width = (float)film->width, height = (float)film->height;
    const uint32_t across = (uint32_t)film->across;
    float x[SOME], y[SOME], z[SOME]; /* loops over triples stay scalar */
    uint32_t pixel[SOME];
    for (uint32_t i = 0; i < count; i++) {
        x[i] = direction[3 * i];
        y[i] = direction[3 * i + 1];
        z[i] = direction[3 * i + 2];
    }
    for (size_t i = 0; i < count; i++) {
        float u, v;
        rnd_v3_to_uv(rnd_v3(x[i], y[i], z[i]), &u, &v);
        pixel[i] = pixel_index(across, (uint32_t)(int32_t)rnd_smaller(u * width, width - 1.0f),
                               (uint32_t)(int32_t)rnd_smaller(v * height, height - 1.0f));
    }
    memcpy(out_pixel, pixel, count * sizeof *pixel);
}

/* How many cells along a side, a power of two. Where samples are densest, at the gaze, a cell then has about
 * one pixel for each of its paths. With more cells, many paths would fall in few pixels. */
static float grid_of(const struct rnd_places *places, const struct rnd_aim *aim)
{
    const float pixel = 2.0f * (float)M_PI / (float)places->film->width;
    const float share = places->distribution->density(aim, aim->gaze) * pixel * pixel;
    float grid = 1.0f;
    while (grid < MOST_CELLS && 4.0f * grid * grid * CELL * share <= 1.0f) grid *= 2.0f;
    return grid;
}

/* Lower corner of a cell. */
static void corner_of(const struct rnd_places *places, uint32_t cell, float out[2])
{
    float u[2];
    rnd_pair(places->seed, 0, cell, u);
    for (int c = 0; c < 2; c++) out[c] = floorf(u[c] * places->grid) / places->grid;
}

/* Positions for cells first to end of those that are next; paths is the number of paths in all. */
static void draw(struct rnd_places *places, const struct rnd_aim *aim, uint32_t first, uint32_t end,
                 uint32_t paths)
{
    const float quarter = 0.25f / places->grid;
    float u[2 * SOME], direction[3 * SOME];
    for (uint32_t c = first; c < end; c += SOME / CELL) {
        const uint32_t cells = end - c < SOME / CELL ? end - c : SOME / CELL;
        for (uint32_t k = 0; k < cells; k++) {
            const uint32_t cell = places->next_cell + c + k, seed = places->seed + 3;
            float corner[2], *to = &u[2 * CELL * k];
            corner_of(places, cell, corner);
#pragma GCC ivdep
            for (uint32_t within = 0; within < CELL; within++) {
                const uint32_t h = rnd_hash2(seed, cell * CELL + within);
                to[2 * within] = corner[0] + quarter * ((float)(int32_t)(within % 4) +
                                                        (float)(int32_t)(h & 0xffffu) * 0x1p-16f);
                to[2 * within + 1] = corner[1] + quarter * ((float)(int32_t)(within / 4) +
                                                            (float)(int32_t)(h >> 16) * 0x1p-16f);
            }
        }
        const uint32_t i = c * CELL, n = paths - i < cells * CELL ? paths - i : cells * CELL;
        places->distribution->sample(aim, n, u, direction);
        pixels_of(places->film, n, direction, &places->pixel[i]);
    }
}

/* A random pixel of each cell of the outline. */
static void outline(struct rnd_places *places, uint32_t paths)
{
    const uint32_t across = (uint32_t)places->film->width / RND_OUTLINE,
                   tiles = (uint32_t)places->film->across;
    for (uint32_t i = 0; i < paths; i++) {
        const uint32_t h = rnd_hash2(places->seed + 1, i);
        places->pixel[i] = pixel_index(tiles, i % across * RND_OUTLINE + h % RND_OUTLINE,
                                       i / across * RND_OUTLINE + h / RND_OUTLINE % RND_OUTLINE);
    }
}

/* Counting sort by tile. Paths of a tile stay in the order in which they were drawn. Makes a run for each
 * tile that has paths. */
static void sort(struct rnd_places *places, uint32_t paths)
{
    const uint32_t tiles = (uint32_t)(places->film->across * places->film->down);
    uint32_t *start = places->start;
    memset(start, 0, (tiles + 1) * sizeof *start);
    for (uint32_t i = 0; i < paths; i++) {
        const uint32_t t = places->pixel[i] / RND_TILE_PIXELS;
        start[t]++;
        __builtin_prefetch(&places->film->pixels[t].drawn[places->pixel[i] % RND_TILE_PIXELS], 1);
    }
    places->runs = 0;
    for (uint32_t t = 0, sum = 0; t < tiles; t++) {
        const uint32_t n = start[t];
        if (n == 0) continue;
        struct rnd_run *run = &places->run[places->runs];
        run->tile = t;
        run->first = sum;
        run->end = start[t] = sum + n;
        for (uint32_t i = sum; i < sum + n; i++) places->run_of[i] = places->runs;
        start[t] = sum;
        sum += n;
        places->runs++;
    }
    for (uint32_t i = 0; i < paths; i++) {
        const uint32_t t = places->pixel[i] / RND_TILE_PIXELS, pixel = places->pixel[i] % RND_TILE_PIXELS;
        struct rnd_sample *sample = &places->sample[start[t]++];
        sample->pixel = pixel;
        sample->number = rnd_film_draw(&places->film->tile[t], pixel);
    }
}

struct placing {
    struct rnd_places *places;
    const struct rnd_aim *aim;
    uint32_t paths;
};

static void draw_share(void *context, uint32_t first, uint32_t end)
{
    const struct placing *p = context;
    draw(p->places, p->aim, first, end, p->paths);
}

void rnd_places_draw(struct rnd_places *places, struct rnd_pool *pool, const struct rnd_aim *aim,
                     uint32_t paths)
{
    struct placing placing = {.places = places, .aim = aim, .paths = paths};
    const uint32_t cells = (paths + CELL - 1) / CELL;
    places->grid = grid_of(places, aim);
    rnd_pool_share(pool, cells, SOME / CELL, draw_share, &placing);
    places->next_cell += cells;
    sort(places, paths);
}

uint32_t rnd_places_of_outline(const struct rnd_film *film)
{
    return (uint32_t)(film->width / RND_OUTLINE) * (uint32_t)(film->height / RND_OUTLINE);
}

void rnd_places_outline(struct rnd_places *places, uint32_t paths)
{
    outline(places, paths);
    sort(places, paths);
}

bool rnd_places_init(struct rnd_places *places, const struct rnd_film *film,
                     const struct rnd_distribution *distribution, uint32_t seed)
{
    const size_t tiles = (size_t)film->across * (size_t)film->down;
    *places = (struct rnd_places){.film = film, .distribution = distribution, .seed = seed};
    places->start = malloc((tiles + 1) * sizeof *places->start);
    return places->start;
}

static void free_paths(struct rnd_places *places)
{
    free(places->pixel);
    free(places->sample);
    free(places->planes);
    free(places->run_of);
    free(places->run);
}

void rnd_places_finish(struct rnd_places *places)
{
    free_paths(places);
    free(places->start);
}

bool rnd_places_reserve(struct rnd_places *places, uint32_t paths)
{
    if (paths <= places->capacity) return true;
    const size_t tiles = (size_t)places->film->across * (size_t)places->film->down;
    const size_t channels = (size_t)places->film->planes.channels;
    free_paths(places);
    places->pixel = malloc(paths * sizeof *places->pixel);
    places->sample = malloc(paths * sizeof *places->sample);
    places->planes = channels > 0 ? malloc(paths * channels * sizeof *places->planes) : NULL;
    places->run_of = malloc(paths * sizeof *places->run_of);
    places->run = malloc((tiles < paths ? tiles : paths) * sizeof *places->run);
    const bool ok =
        places->pixel && places->sample && places->run_of && places->run && (channels == 0 || places->planes);
    places->capacity = ok ? paths : 0;
    return ok;
}
