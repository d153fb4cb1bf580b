/* Sums of the film over the pixels of a tile at any level. */
#include "film/sums.h"
#include "math/sphere.h"

#include <math.h>
#include <string.h>

static inline void add_part(struct rnd_sum *to, const float mean[3], float paths, float hits)
{
    for (int c = 0; c < 3; c++) to->light[c] += mean[c];
    to->area += 1.0f;
    to->paths += paths;
    to->hits += hits;
}

/* About how many paths of a pixel found light, by its halves: the mean of H equal hits has a relative
 * variance of 1 / H. While there are few paths, halves may agree by chance. */
static float hits_of(const struct rnd_film_pixel *pixel, uint32_t paths, const float mean[3])
{
    const float bright = rnd_luminance(mean), even = rnd_luminance(pixel->half[0]),
                odd = rnd_luminance(pixel->half[1]);
    if (bright <= 0.0f) return 0.0f;
    const float deviation = 0.5f * (even - odd) / bright, most = 2.0f + (float)paths / 16.0f;
    return fminf((float)paths, fmaxf(1.0f, 1.0f / (deviation * deviation + 1.0f / most)));
}

/* The same for a block, by the share of its pixels that found none: the probability that a Poisson variable
 * is 0. */
static float block_hits(const struct rnd_film_block *block)
{
    if (block->lit == block->visited) return (float)block->paths;
    const float visited = (float)block->visited;
    return fminf((float)block->paths, -visited * log1pf(-(float)block->lit / visited));
}

static void add_blocks(const struct rnd_film_tile *tile, int scale, int left, int top, struct rnd_sums *sums)
{
    const int per = scale / RND_BLOCK, n = RND_TILE / RND_BLOCK;
    for (int i = 0; i < RND_TILE_BLOCKS; i++) {
        const struct rnd_film_block *block = &tile->block[i];
        if (block->visited == 0) continue;
        float mean[3];
        for (int c = 0; c < 3; c++) mean[c] = (float)fmax(0.0, block->light[c] / block->visited);
        add_part(&sums->pixel[(top + i / n / per) * RND_TILE + left + i % n / per], mean, (float)block->paths,
                 block_hits(block));
    }
}

static void add_listed(const struct rnd_film_tile *tile, int scale, int left, int top, struct rnd_sums *sums)
{
    bool seen[RND_TILE_PIXELS] = {false};
    for (uint32_t i = 0; i < tile->listed; i++) {
        const uint32_t pixel = tile->list[i].pixel;
        float mean[3];
        if (seen[pixel]) continue;
        seen[pixel] = true;
        const struct rnd_film_pixel whole = rnd_film_pixel_at(tile, pixel);
        const uint32_t n = rnd_film_mean(&whole, mean);
        const int x = (int)pixel % RND_TILE, y = (int)pixel / RND_TILE;
        add_part(&sums->pixel[(top + y / scale) * RND_TILE + left + x / scale], mean, (float)n,
                 rnd_luminance(mean) > 0.0f ? 1.0f : 0.0f);
    }
}

/* Add a level-0 tile's part, scale pixels of it to one of the sums', from (left, top) of them on. */
static void add_tile(const struct rnd_film_tile *tile, int scale, int left, int top, struct rnd_sums *sums)
{
    if (scale >= RND_BLOCK) {
        add_blocks(tile, scale, left, top, sums);
    } else if (!tile->spread) {
        add_listed(tile, scale, left, top, sums);
    } else {
        const int shift = __builtin_ctz((unsigned)scale); /* it is a power of two */
        for (uint32_t i = 0; i < RND_TILE_PIXELS; i++) {
            float mean[3];
            const struct rnd_film_pixel *pixel = &tile->pixels->pixel[i];
            const uint32_t x = i % RND_TILE, y = i / RND_TILE, n = rnd_film_mean(pixel, mean);
            const uint32_t to = ((uint32_t)top + (y >> shift)) * RND_TILE + (uint32_t)left + (x >> shift);
            const struct rnd_film_block *block =
                &tile->block[y / RND_BLOCK * (RND_TILE / RND_BLOCK) + x / RND_BLOCK];
            if (n == 0) continue;
            /* hits matter only where a pixel of the block found no light */
            add_part(&sums->pixel[to], mean, (float)n,
                     block->lit == block->visited ? (float)n : hits_of(pixel, n, mean));
        }
    }
}

/* --- planes --- */

static bool has_paths(const struct rnd_film_tile *tile, uint32_t pixel)
{
    const struct rnd_film_pixel found = rnd_film_pixel_at(tile, pixel);
    return found.count[0] + found.count[1] > 0;
}

/* Add the planes of a level-0 tile, as add_tile() does. */
static void add_planes(const struct rnd_film *film, const struct rnd_film_tile *tile, int scale, int left,
                       int top, float *planes)
{
    const struct rnd_planes *kept = &film->planes;
    const int side = scale >= RND_BLOCK ? RND_TILE / RND_BLOCK : RND_TILE,
              per = scale >= RND_BLOCK ? scale / RND_BLOCK : scale;
    for (int i = 0; i < side * side; i++) {
        const int to = (top + i / side / per) * RND_TILE + left + i % side / per;
        float *sum = planes + (size_t)to * (size_t)kept->channels;
        if (scale >= RND_BLOCK) {
            const uint32_t visited = tile->block[i].visited;
            if (visited > 0)
                rnd_planes_sum_block(kept, rnd_film_plane_block(film, tile, (uint32_t)i), visited, sum);
        } else if (has_paths(tile, (uint32_t)i)) {
            rnd_planes_sum(kept, rnd_film_record(film, tile, (uint32_t)i), sum);
        }
    }
}

static void divide_planes(const struct rnd_film *film, const struct rnd_sums *sums, float *planes)
{
    for (int i = 0; i < RND_TILE_PIXELS; i++)
        if (sums->pixel[i].area > 0.0f)
            rnd_planes_divide(&film->planes, sums->pixel[i].area, planes + i * film->planes.channels);
}

/* --- a tile of a level --- */

static void merge_state(struct rnd_tile *to, const struct rnd_tile *from, bool first)
{
    if (first) {
        *to = *from;
        return;
    }
    const bool newer = from->samples > 0 && (to->samples == 0 || from->aimed_ns > to->aimed_ns);
    to->samples += from->samples;
    to->unvisited += from->unvisited;
    to->error = fmaxf(to->error, from->error);
    to->sure_error = fmaxf(to->sure_error, from->sure_error);
    to->luminance += from->luminance;
    to->converged &= from->converged;
    if (!newer) return;
    to->gaze_sequence = from->gaze_sequence;
    to->gaze_ns = from->gaze_ns;
    to->aimed_ns = from->aimed_ns;
}

bool rnd_film_sums(const struct rnd_film *film, int level, int x, int y, struct rnd_sums *out_sums,
                   float *out_planes, struct rnd_tile *out_state)
{
    const int span =
        1 << level; /* level-0 tiles a side; from level 7 on, each is less than a pixel of the sums */
    struct rnd_tile state = {0};
    memset(out_sums, 0, sizeof *out_sums);
    if (out_planes) memset(out_planes, 0, RND_TILE_PIXELS * film->planes.channels * sizeof *out_planes);
    bool whole = true; /* and not emptied or written in part meanwhile */
    for (int i = 0; i < span * span; i++) {
        const int dx = i % span, dy = i / span;
        struct rnd_film_tile *tile = &film->tile[(y * span + dy) * film->across + x * span + dx];
        struct rnd_tile part;
        if (whole && rnd_film_lock_soon(tile)) {
            part = tile->state;
            if (i == 0) out_sums->camera = tile->camera;
            const int left = dx * RND_TILE / span, top = dy * RND_TILE / span;
            if (part.samples > 0) add_tile(tile, span, left, top, out_sums);
            if (part.samples > 0 && out_planes) add_planes(film, tile, span, left, top, out_planes);
            pthread_mutex_unlock(&tile->lock);
        } else {
            rnd_film_state(tile, &part);
            whole = false;
        }
        merge_state(&state, &part, i == 0);
        whole = whole && part.generation == state.generation;
    }
    if (whole && out_planes) divide_planes(film, out_sums, out_planes);
    state.luminance /= (float)(span * span);
    *out_state = state;
    return whole;
}
