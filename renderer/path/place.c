/* Where the paths of a batch go: positions drawn around the gaze, sorted by tile.
 *
 * A position is drawn as a point of the unit square, which the distribution warps onto the sphere. Sixteen
 * paths at a time share one of the square's cells, so that their rays keep together in Embree's packets;
 * cells follow each other as Owen-scrambled Sobol points do, spread evenly at every length of a batch. A cell
 * holds the same share of a distribution's samples wherever it lies, so it is small at the fovea and grows
 * towards the periphery.
 */
#include "path/uv.h"
#include "render.h"
#include "sampler.h"

#include <string.h>

enum {
    CELL = 16,        /* paths in a cell, four by four */
    MOST_CELLS = 256, /* along a side of the square */
    TRIES = 8,        /* cells looked at for each that is wanted, at the most */
};

/* Share of its usual samples that a tile still gets when nobody would see what more of them bring. */
#define FLOOR 0.125f

static uint32_t pixel_index(const struct rnd_film *film, int x, int y)
{
    const uint32_t tile = (uint32_t)(y / RND_TILE * film->across + x / RND_TILE);
    return tile * RND_TILE_PIXELS + (uint32_t)(y % RND_TILE * RND_TILE + x % RND_TILE);
}

static uint32_t pixel_of(const struct rnd_film *film, const float direction[3])
{
    float u, v;
    rnd_v3_to_uv(rnd_v3(direction[0], direction[1], direction[2]), &u, &v);
    const int x = (int)(u * (float)film->width), y = (int)(v * (float)film->height);
    return pixel_index(film, x < film->width ? x : film->width - 1, y < film->height ? y : film->height - 1);
}

/* How many cells along a side: so many, a power of two, that where samples are densest, at the gaze, a cell
 * has a pixel for each of its paths. More would trace many paths in few places. */
static float grid_of(const struct rnd_render *render, const struct rnd_aim *aim)
{
    const float pixel = 2.0f * (float)M_PI / (float)render->film.width;
    const float share = render->distribution->density(aim, aim->gaze) * pixel * pixel;
    float grid = 1.0f;
    while (grid < MOST_CELLS && 4.0f * grid * grid * CELL * share <= 1.0f) grid *= 2.0f;
    return grid;
}

/* Lower corner of a cell. */
static void corner_of(const struct rnd_render *render, uint32_t cell, float out[2])
{
    float u[2];
    rnd_pair(render->seed, 0, cell, u);
    for (int c = 0; c < 2; c++) out[c] = floorf(u[c] * render->grid) / render->grid;
}

/* Is the tile in the middle of a cell as good as it can be seen to be? */
static bool is_quiet(const struct rnd_render *render, const struct rnd_aim *aim, uint32_t cell)
{
    float u[2], direction[3];
    corner_of(render, cell, u);
    for (int c = 0; c < 2; c++) u[c] += 0.5f / render->grid;
    render->distribution->sample(aim, 1, u, direction);
    const uint32_t index = pixel_of(&render->film, direction) / RND_TILE_PIXELS;
    const struct rnd_tile *tile = &render->film.tile[index].state;
    if (tile->converged) return true;
    return render->distribution->follows_gaze &&
           rnd_tile_settled(render, tile, (int)index % render->film.across, (int)index / render->film.across,
                            aim->gaze);
}

/* Choose the next cells. What falls on a quiet tile is mostly passed over, for others to have its samples. */
static void choose_cells(struct rnd_render *render, const struct rnd_aim *aim, uint32_t cells)
{
    uint32_t chosen = 0, spare = (TRIES - 1) * cells;
    while (chosen < cells) {
        const uint32_t cell = render->next_cell++;
        if (spare > 0 && is_quiet(render, aim, cell) && rnd_unit(rnd_hash2(render->seed + 2, cell)) >= FLOOR)
            spare--;
        else
            render->cell[chosen++] = cell;
    }
}

/* Positions of paths first to end; first is a cell's. */
static void draw(struct rnd_render *render, const struct rnd_aim *aim, uint32_t first, uint32_t end)
{
    enum { DRAW = 16 * CELL };
    const float quarter = 0.25f / render->grid;
    float u[2 * DRAW], direction[3 * DRAW], corner[2];
    for (uint32_t i = first; i < end; i += DRAW) {
        const uint32_t n = end - i < DRAW ? end - i : DRAW;
        for (uint32_t k = 0; k < n; k++) {
            const uint32_t cell = render->cell[(i + k) / CELL], within = k % CELL;
            if (within == 0) corner_of(render, cell, corner);
            const uint32_t h = rnd_hash2(render->seed + 3, cell * CELL + within);
            const float x = (float)(within % 4) + (float)(h & 0xffffu) * 0x1p-16f,
                        y = (float)(within / 4) + (float)(h >> 16) * 0x1p-16f;
            u[2 * k] = corner[0] + x * quarter;
            u[2 * k + 1] = corner[1] + y * quarter;
        }
        render->distribution->sample(aim, n, u, direction);
        for (uint32_t k = 0; k < n; k++) render->pixel[i + k] = pixel_of(&render->film, direction + 3 * k);
    }
}

/* A random pixel of each cell of the outline. */
static void outline(struct rnd_render *render, uint32_t paths)
{
    const uint32_t across = (uint32_t)render->film.width / RND_OUTLINE;
    for (uint32_t i = 0; i < paths; i++) {
        const uint32_t h = rnd_hash2(render->seed + 1, i);
        render->pixel[i] = pixel_index(&render->film, (int)(i % across * RND_OUTLINE + h % RND_OUTLINE),
                                       (int)(i / across * RND_OUTLINE + h / RND_OUTLINE % RND_OUTLINE));
    }
}

/* Counting sort by tile, paths of a tile in the order in which they were drawn; runs of those that have some.
 */
static void sort(struct rnd_render *render, uint32_t paths)
{
    const uint32_t tiles = (uint32_t)(render->film.across * render->film.down);
    uint32_t *start = render->start;
    memset(start, 0, (tiles + 1) * sizeof *start);
    for (uint32_t i = 0; i < paths; i++) start[render->pixel[i] / RND_TILE_PIXELS]++;
    render->runs = 0;
    for (uint32_t t = 0, sum = 0; t < tiles; t++) {
        const uint32_t n = start[t];
        if (n == 0) continue;
        struct rnd_run *run = &render->run[render->runs];
        run->tile = t;
        run->first = sum;
        run->end = start[t] = sum + n;
        for (uint32_t i = sum; i < sum + n; i++) render->run_of[i] = render->runs;
        start[t] = sum;
        sum += n;
        render->runs++;
    }
    for (uint32_t i = 0; i < paths; i++) {
        const uint32_t t = render->pixel[i] / RND_TILE_PIXELS, pixel = render->pixel[i] % RND_TILE_PIXELS;
        struct rnd_sample *sample = &render->sample[start[t]++];
        sample->pixel = pixel;
        sample->number = render->film.tile[t].drawn[pixel]++;
    }
}

struct placing {
    struct rnd_render *render;
    const struct rnd_aim *aim;
    uint32_t paths;
};

/* One thread's share of the cells. */
static void draw_share(void *context, int worker)
{
    const struct placing *p = context;
    const uint64_t cells = (p->paths + CELL - 1) / CELL, workers = (uint64_t)p->render->workers;
    const uint32_t first = CELL * (uint32_t)(cells * (unsigned)worker / workers);
    const uint32_t end = CELL * (uint32_t)(cells * ((unsigned)worker + 1u) / workers);
    draw(p->render, p->aim, first, end < p->paths ? end : p->paths);
}

void rnd_place(struct rnd_render *render, const struct rnd_aim *aim, uint32_t paths, bool drawn)
{
    struct placing placing = {render, aim, paths};
    if (drawn) {
        render->grid = grid_of(render, aim);
        choose_cells(render, aim, (paths + CELL - 1) / CELL);
        rnd_pool_run(render->pool, draw_share, &placing);
    } else {
        outline(render, paths);
    }
    sort(render, paths);
}
