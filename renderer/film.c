/* The film's memory, and what is read from it: tiles at any level, the whole picture, its file. */
#include "math/large_pages.h"
#include "fill.h"
#include "film.h"
#include "image.h"
#include "render.h"
#include "math/sphere.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

bool rnd_film_init(struct rnd_film *film, int width, int height, float error_bar)
{
    *film = (struct rnd_film){.width = width,
                              .height = height,
                              .across = width / RND_TILE,
                              .down = height / RND_TILE,
                              .error_bar = error_bar};
    const size_t tiles = (size_t)film->across * (size_t)film->down;
    film->tile = calloc(tiles, sizeof *film->tile);
    film->published = calloc((tiles + 63) / 64, sizeof *film->published);
    film->weighed = malloc(tiles * sizeof *film->weighed);
    /* Fresh pages of the system cost nothing until a sample falls there. */
    film->pixels = aligned_alloc(64, tiles * sizeof *film->pixels);
    rnd_use_large_pages(film->pixels, tiles * sizeof *film->pixels);
    if (!film->tile || !film->published || !film->weighed || !film->pixels) return false;
    for (size_t t = 0; t < tiles; t++) {
        struct rnd_film_tile *tile = &film->tile[t];
        pthread_mutex_init(&tile->lock, NULL);
        tile->pixels = &film->pixels[t];
        rnd_film_empty(film, tile, 1);
    }
    return true;
}

void rnd_film_finish(struct rnd_film *film)
{
    const int tiles =
        film->tile && film->published && film->weighed && film->pixels ? film->across * film->down : 0;
    for (int t = 0; t < tiles; t++) pthread_mutex_destroy(&film->tile[t].lock);
    free(film->tile);
    free(film->pixels);
    free(film->published);
    free(film->weighed);
    *film = (struct rnd_film){0};
}

/* --- what is known of a tile: published by whoever has its lock --- */

static void publish(const struct rnd_film *film, struct rnd_film_tile *tile)
{
    const size_t index = (size_t)(tile - film->tile);
    const uint32_t turn = atomic_load_explicit(&tile->turn, memory_order_relaxed) + 1;
    uint64_t word[RND_STATE_WORDS] = {0};
    memcpy(word, &tile->state, sizeof tile->state);
    for (int i = 0; i < RND_STATE_WORDS; i++)
        atomic_store_explicit(&tile->published[turn & 1][i], word[i], memory_order_release);
    atomic_store_explicit(&tile->turn, turn, memory_order_release);
    atomic_fetch_or_explicit(&film->published[index / 64], (uint64_t)1 << index % 64, memory_order_release);
}

/* Never waits for a writer: what it writes is the other half. Whoever reads a word of the turn after the next
 * one sees that the turn has passed, and reads again. */
static void read_published(const struct rnd_film_tile *tile, struct rnd_tile *out_state)
{
    uint64_t word[RND_STATE_WORDS];
    uint32_t turn, later = atomic_load_explicit(&tile->turn, memory_order_acquire);
    do {
        turn = later;
        for (int i = 0; i < RND_STATE_WORDS; i++)
            word[i] = atomic_load_explicit(&tile->published[turn & 1][i], memory_order_acquire);
        later = atomic_load_explicit(&tile->turn, memory_order_acquire);
    } while (later != turn);
    memcpy(out_state, word, sizeof *out_state);
}

void rnd_render_tiles(struct rnd_render *render, struct rnd_tile *out_tiles)
{
    const int count = render->film.across * render->film.down;
    for (int i = 0; i < count; i++) read_published(&render->film.tile[i], &out_tiles[i]);
}

uint32_t rnd_render_published(struct rnd_render *render, struct rnd_tile *tiles, uint32_t *out_index)
{
    const struct rnd_film *film = &render->film;
    const uint32_t words = ((uint32_t)(film->across * film->down) + 63) / 64;
    uint32_t count = 0;
    for (uint32_t w = 0; w < words; w++) {
        if (atomic_load_explicit(&film->published[w], memory_order_relaxed) == 0) continue;
        uint64_t bits = atomic_exchange_explicit(&film->published[w], 0, memory_order_acquire);
        for (; bits != 0; bits &= bits - 1) {
            const uint32_t i = 64 * w + (uint32_t)__builtin_ctzll(bits);
            read_published(&film->tile[i], &tiles[i]);
            out_index[count++] = i;
        }
    }
    return count;
}

/* --- writing --- */

void rnd_film_empty(const struct rnd_film *film, struct rnd_film_tile *tile, uint32_t generation)
{
    pthread_mutex_lock(&tile->lock);
    memset(tile->block, 0, sizeof tile->block);
    tile->state = (struct rnd_tile){
        .generation = generation, .unvisited = RND_TILE_PIXELS, .error = INFINITY, .sure_error = INFINITY};
    tile->next_judgement = 2 * RND_TILE_PIXELS;
    tile->former_error = INFINITY;
    tile->grain = -1.0f;
    tile->spread = false;
    tile->listed = tile->drawn = 0;
    publish(film, tile);
    pthread_mutex_unlock(&tile->lock);
}

uint32_t rnd_film_draw_listed(struct rnd_film_tile *tile, uint32_t pixel)
{
    uint32_t number = 0;
    if (tile->drawn == RND_FEW) { /* and this is one too many */
        uint32_t *drawn = tile->pixels->drawn;
        memset(drawn, 0, sizeof tile->pixels->drawn);
        for (uint32_t i = 0; i < tile->drawn; i++) drawn[tile->drawn_list[i]]++;
        tile->drawn++;
        return drawn[pixel]++;
    }
    for (uint32_t i = 0; i < tile->drawn; i++) number += tile->drawn_list[i] == pixel;
    tile->drawn_list[tile->drawn++] = (uint16_t)pixel;
    return number;
}

static void add_to_pixel(struct rnd_film_pixel *pixel, const struct rnd_sample *s)
{
    float *mean = pixel->half[s->number & 1];
    const float share = 1.0f / (float)++pixel->count[s->number & 1];
    for (int c = 0; c < 3; c++) mean[c] += (s->rgb[c] - mean[c]) * share;
}

/* From the list to the pixels. */
static void spread(struct rnd_film_tile *tile)
{
    memset(tile->pixels->pixel, 0, sizeof tile->pixels->pixel);
    for (uint32_t i = 0; i < tile->listed; i++)
        add_to_pixel(&tile->pixels->pixel[tile->list[i].pixel], &tile->list[i]);
    tile->spread = true;
}

/* A pixel of a tile whose paths are still listed, as it will be among the pixels. */
static struct rnd_film_pixel listed_pixel(const struct rnd_film_tile *tile, uint32_t i)
{
    struct rnd_film_pixel pixel = {0};
    for (uint32_t k = 0; k < tile->listed; k++)
        if (tile->list[k].pixel == i) add_to_pixel(&pixel, &tile->list[k]);
    return pixel;
}

/* Mean radiance of a pixel, 0 without a path, and how many paths there are. */
static uint32_t pixel_mean(const struct rnd_film_pixel *pixel, float out_mean[3])
{
    const uint32_t n = pixel->count[0] + pixel->count[1];
    const float share = n > 0 ? (float)pixel->count[1] / (float)n : 0.0f;
    for (int c = 0; c < 3; c++)
        out_mean[c] = pixel->half[0][c] + (pixel->half[1][c] - pixel->half[0][c]) * share;
    return n;
}

static void add(struct rnd_film_tile *tile, const struct rnd_sample *s)
{
    const uint32_t x = s->pixel % RND_TILE, y = s->pixel / RND_TILE;
    struct rnd_film_block *block = &tile->block[y / RND_BLOCK * (RND_TILE / RND_BLOCK) + x / RND_BLOCK];
    float mean[3];
    const struct rnd_film_pixel pixel =
        tile->spread ? tile->pixels->pixel[s->pixel] : listed_pixel(tile, s->pixel);
    const uint32_t n = pixel_mean(&pixel, mean);
    const double share = 1.0 / (double)(n + 1);
    for (int c = 0; c < 3; c++) block->light[c] += ((double)s->rgb[c] - (double)mean[c]) * share;
    block->visited += n == 0;
    block->lit += rnd_luminance(mean) <= 0.0f && rnd_luminance(s->rgb) > 0.0f;
    block->paths++;
    tile->state.unvisited -= n == 0;
    if (tile->spread)
        add_to_pixel(&tile->pixels->pixel[s->pixel], s);
    else
        tile->list[tile->listed++] = *s;
}

void rnd_film_add(const struct rnd_film *film, struct rnd_film_tile *tile, const struct rnd_sample *samples,
                  uint32_t count, const struct rnd_aim *aim, uint64_t now_ns)
{
    uint32_t added = 0;
    for (uint32_t i = 0; i < count; i++) added += samples[i].pixel != RND_TILE_PIXELS;
    if (added == 0) return; /* and the tile does not answer this aim */
    pthread_mutex_lock(&tile->lock);
    if (!tile->spread && tile->listed + added > RND_FEW) spread(tile);
    for (uint32_t i = 0; i < count; i++)
        if (samples[i].pixel != RND_TILE_PIXELS) add(tile, &samples[i]);
    tile->state.samples += added;
    tile->state.gaze_sequence = aim->sequence;
    tile->state.gaze_ns = aim->time_ns;
    tile->state.aimed_ns = now_ns;
    if (tile->spread && tile->state.samples >= tile->next_judgement) {
        rnd_judge(film, tile);
        tile->next_judgement = tile->state.samples + tile->state.samples / 4;
    }
    publish(film, tile);
    pthread_mutex_unlock(&tile->lock);
}

/* --- reading --- */

int rnd_render_levels(const struct rnd_render *render)
{
    int levels = 1; /* the width is twice the height and so divides where the height does */
    while ((render->film.height >> levels) >= RND_TILE && (render->film.height >> levels) % RND_TILE == 0)
        levels++;
    return levels;
}

static inline void add_part(struct rnd_sum *to, const float mean[3], float paths, float hits)
{
    for (int c = 0; c < 3; c++) to->light[c] += mean[c];
    to->area += 1.0f;
    to->paths += paths;
    to->hits += hits;
}

/* Paths of a pixel that found light, as far as its halves tell: of H such paths alike its mean has a relative
 * variance of 1 / H. Halves that agree may do so by chance, while there are few paths. */
static float hits_of(const struct rnd_film_pixel *pixel, uint32_t paths, const float mean[3])
{
    const float bright = rnd_luminance(mean), even = rnd_luminance(pixel->half[0]),
                odd = rnd_luminance(pixel->half[1]);
    if (bright <= 0.0f) return 0.0f;
    const float deviation = 0.5f * (even - odd) / bright, most = 2.0f + (float)paths / 16.0f;
    return fminf((float)paths, fmaxf(1.0f, 1.0f / (deviation * deviation + 1.0f / most)));
}

/* The same of a block, by its pixels: a Poisson number that is 0 in so many of them. */
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
        const struct rnd_film_pixel whole = listed_pixel(tile, pixel);
        const uint32_t n = pixel_mean(&whole, mean);
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
            const uint32_t x = i % RND_TILE, y = i / RND_TILE, n = pixel_mean(pixel, mean);
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

/* Wait for a thread that is just adding to the tile, but not for one that was put aside meanwhile. */
static bool lock_soon(struct rnd_film_tile *tile)
{
    enum { LOOKS = 1000 }; /* some tens of microseconds */
    for (int i = 0; i < LOOKS; i++) {
        if (pthread_mutex_trylock(&tile->lock) == 0) return true;
        rnd_pause();
    }
    return false;
}

bool rnd_render_read(struct rnd_render *render, int level, int x, int y, float *out_rgb,
                     struct rnd_tile *out_state)
{
    const struct rnd_film *film = &render->film;
    const int span =
        1 << level; /* level-0 tiles a side; from level 7 on, each is less than a pixel of the sums */
    struct rnd_sums sums = {0};
    struct rnd_tile state = {0};
    bool whole = true; /* and not emptied or written in part meanwhile */
    for (int i = 0; i < span * span; i++) {
        const int dx = i % span, dy = i / span;
        struct rnd_film_tile *tile = &film->tile[(y * span + dy) * film->across + x * span + dx];
        struct rnd_tile part;
        if (whole && lock_soon(tile)) {
            part = tile->state;
            if (part.samples > 0) add_tile(tile, span, dx * RND_TILE / span, dy * RND_TILE / span, &sums);
            pthread_mutex_unlock(&tile->lock);
        } else {
            read_published(tile, &part);
            whole = false;
        }
        merge_state(&state, &part, i == 0);
        whole = whole && part.generation == state.generation;
    }
    state.luminance /= (float)(span * span);
    if (out_state) *out_state = state;
    return whole && rnd_fill(&sums, out_rgb);
}

/* Standard error of a pixel's luminance from its halves; 0 if one is empty. */
static float pixel_error(const struct rnd_film_tile *tile, int i)
{
    const struct rnd_film_pixel *pixel = &tile->pixels->pixel[i];
    if (pixel->count[0] == 0 || pixel->count[1] == 0) return 0.0f;
    return 0.5f * fabsf(rnd_luminance(pixel->half[0]) - rnd_luminance(pixel->half[1]));
}

void rnd_render_resolve(struct rnd_render *render, float *out_rgb, float *out_samples, float *out_error)
{
    const struct rnd_film *film = &render->film;
    pthread_mutex_lock(&render->whole);
    for (int t = 0; t < film->across * film->down; t++) {
        struct rnd_film_tile *tile = &film->tile[t];
        const int left = t % film->across * RND_TILE, top = t / film->across * RND_TILE;
        pthread_mutex_lock(&tile->lock);
        if (!tile->spread) spread(tile);
        for (int i = 0; i < RND_TILE_PIXELS; i++) {
            const size_t to = (size_t)(top + i / RND_TILE) * film->width + left + i % RND_TILE;
            float mean[3];
            const uint32_t n = pixel_mean(&tile->pixels->pixel[i], mean);
            if (out_rgb) memcpy(&out_rgb[3 * to], mean, sizeof mean);
            if (out_samples) out_samples[to] = (float)n;
            if (out_error) out_error[to] = pixel_error(tile, i);
        }
        pthread_mutex_unlock(&tile->lock);
    }
    pthread_mutex_unlock(&render->whole);
}

bool rnd_render_save(struct rnd_render *render, FILE *file, const char *name,
                     char out_error[RND_ERROR_SIZE])
{
    const int width = render->film.width, height = render->film.height;
    const size_t count = (size_t)width * height;
    float *plane = malloc(count * 5 * sizeof *plane), *data = malloc(count * 5 * sizeof *data);
    bool ok = false;
    if (!plane || !data) {
        snprintf(out_error, RND_ERROR_SIZE, "%.200s: not enough memory", name);
    } else {
        float *samples = plane + 3 * count, *error = samples + count;
        rnd_render_resolve(render, plane, samples, error);
        const enum rnd_channel_type colour = rnd_exr_type(plane, 3 * count),
                                    error_type = rnd_exr_type(error, count);
        const struct rnd_channel channel[5] = {
            {"R", colour}, {"G", colour}, {"B", colour}, {"samples", RND_FLOAT}, {"error", error_type}};
        for (size_t i = 0; i < count; i++) {
            memcpy(&data[5 * i], &plane[3 * i], 3 * sizeof *data);
            data[5 * i + 3] = samples[i];
            data[5 * i + 4] = error[i];
        }
        ok = rnd_image_write_channels(file, name, width, height, 5, channel, data, true, out_error);
    }
    free(plane);
    free(data);
    return ok;
}
