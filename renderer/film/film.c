/* The film's memory, adding to it, and reading it as a whole. */
#include "film/film.h"
#include "film/converge.h"
#include "math/large_pages.h"
#include "math/sphere.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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

/* Never waits for a writer, who writes the other half. If the writer has meanwhile come round to the half
 * that was read, the turn has changed, and the half is read again. */
void rnd_film_state(const struct rnd_film_tile *tile, struct rnd_tile *out_state)
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

uint32_t rnd_film_published(const struct rnd_film *film, struct rnd_tile *tiles, uint32_t *out_index)
{
    const uint32_t words = ((uint32_t)(film->across * film->down) + 63) / 64;
    uint32_t count = 0;
    for (uint32_t w = 0; w < words; w++) {
        if (atomic_load_explicit(&film->published[w], memory_order_relaxed) == 0) continue;
        uint64_t bits = atomic_exchange_explicit(&film->published[w], 0, memory_order_acquire);
        for (; bits != 0; bits &= bits - 1) {
            const uint32_t i = 64 * w + (uint32_t)__builtin_ctzll(bits);
            rnd_film_state(&film->tile[i], &tiles[i]);
            out_index[count++] = i;
        }
    }
    return count;
}

bool rnd_film_lock_soon(struct rnd_film_tile *tile)
{
    enum { LOOKS = 1000 }; /* some tens of microseconds */
    for (int i = 0; i < LOOKS; i++) {
        if (pthread_mutex_trylock(&tile->lock) == 0) return true;
        rnd_pause();
    }
    return false;
}

/* --- emptying a tile --- */

/* Take all paths out of a tile whose lock is held, or which nobody knows yet. */
static void empty(const struct rnd_film *film, struct rnd_film_tile *tile, const struct rnd_camera *camera,
                  uint32_t generation)
{
    memset(tile->block, 0, sizeof tile->block);
    if (tile->planes && tile->state.samples > 0)
        memset(tile->planes, 0, rnd_planes_size(&film->planes, 0, RND_TILE_BLOCKS));
    tile->state = (struct rnd_tile){
        .generation = generation, .unvisited = RND_TILE_PIXELS, .error = INFINITY, .sure_error = INFINITY};
    tile->camera = *camera;
    tile->next_judgement = 2 * RND_TILE_PIXELS;
    tile->former_error = INFINITY;
    tile->grain = -1.0f;
    tile->spread = false;
    tile->listed = tile->drawn = 0;
    publish(film, tile);
}

/* Give the paths of a tile to a tile of another film, which is empty. The locks of both are held. */
static void hand_over(struct rnd_film_tile *tile, const struct rnd_film *history,
                      struct rnd_film_tile *former)
{
    struct rnd_film_pixels *pixels = former->pixels;
    void *planes = former->planes;
    former->pixels = tile->pixels;
    former->planes = tile->planes;
    tile->pixels = pixels;
    tile->planes = planes;
    former->state = tile->state;
    former->camera = tile->camera;
    former->spread = tile->spread;
    former->listed = tile->listed;
    memcpy(former->list, tile->list, sizeof former->list);
    memcpy(former->block, tile->block, sizeof former->block);
    publish(history, former);
}

/* --- life --- */

bool rnd_film_init(struct rnd_film *film, int width, int height, float error_bar, uint32_t planes,
                   const struct rnd_camera *camera)
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
    rnd_planes_init(&film->planes, planes);
    const size_t size = rnd_planes_size(&film->planes, RND_TILE_PIXELS, RND_TILE_BLOCKS);
    if (size > 0) film->plane_memory = calloc(tiles, size);
    rnd_use_large_pages(film->plane_memory, tiles * size);
    if (!film->tile || !film->published || !film->weighed || !film->pixels ||
        (size > 0 && !film->plane_memory))
        return false;
    for (size_t t = 0; t < tiles; t++) {
        struct rnd_film_tile *tile = &film->tile[t];
        pthread_mutex_init(&tile->lock, NULL);
        tile->pixels = &film->pixels[t];
        if (size > 0) tile->planes = film->plane_memory + t * size;
        empty(film, tile, camera, 1);
    }
    return true;
}

void rnd_film_finish(struct rnd_film *film)
{
    const int tiles = film->tile && film->tile->pixels ? film->across * film->down : 0;
    for (int t = 0; t < tiles; t++) pthread_mutex_destroy(&film->tile[t].lock);
    free(film->tile);
    free(film->pixels);
    free(film->plane_memory);
    free(film->published);
    free(film->weighed);
    *film = (struct rnd_film){0};
}

struct restart {
    const struct rnd_film *film, *history;
    const struct rnd_camera *camera;
    uint32_t generation;
};

/* Tiles first to end. */
static void restart(void *context, uint32_t first, uint32_t end)
{
    const struct restart *to = context;
    for (uint32_t t = first; t < end; t++) {
        struct rnd_film_tile *tile = &to->film->tile[t];
        pthread_mutex_lock(&tile->lock);
        if (to->history) {
            struct rnd_film_tile *former = &to->history->tile[t];
            pthread_mutex_lock(&former->lock);
            empty(to->history, former, to->camera, 0);
            hand_over(tile, to->history, former);
            pthread_mutex_unlock(&former->lock);
        }
        empty(to->film, tile, to->camera, to->generation);
        pthread_mutex_unlock(&tile->lock);
    }
}

void rnd_film_restart(struct rnd_film *film, struct rnd_film *history, const struct rnd_camera *camera,
                      uint32_t generation, struct rnd_pool *pool)
{
    struct restart to = {film, history, camera, generation};
    rnd_pool_share(pool, (uint32_t)(film->across * film->down), 64, restart, &to);
    if (history) { /* all tiles have each other's memory now */
        struct rnd_film_pixels *pixels = history->pixels;
        uint8_t *plane_memory = history->plane_memory;
        history->pixels = film->pixels;
        history->plane_memory = film->plane_memory;
        history->paths = film->paths;
        film->pixels = pixels;
        film->plane_memory = plane_memory;
    }
    film->brightness = film->grain = 0.0f;
    film->paths = film->next_survey = 0;
}

/* --- adding paths --- */

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

void *rnd_film_record(const struct rnd_film *film, const struct rnd_film_tile *tile, uint32_t pixel)
{
    return (uint8_t *)tile->planes + rnd_planes_size(&film->planes, pixel, RND_TILE_BLOCKS);
}

float *rnd_film_plane_block(const struct rnd_film *film, const struct rnd_film_tile *tile, uint32_t block)
{
    return (float *)tile->planes + block * (uint32_t)film->planes.channels;
}

static void add_to_pixel(struct rnd_film_pixel *pixel, const struct rnd_sample *s)
{
    float *mean = pixel->half[s->number & 1];
    const float share = 1.0f / (float)++pixel->count[s->number & 1];
    for (int c = 0; c < 3; c++) mean[c] += (s->rgb[c] - mean[c]) * share;
}

/* From the list to the pixels. */
void rnd_film_spread(struct rnd_film_tile *tile)
{
    memset(tile->pixels->pixel, 0, sizeof tile->pixels->pixel);
    for (uint32_t i = 0; i < tile->listed; i++)
        add_to_pixel(&tile->pixels->pixel[tile->list[i].pixel], &tile->list[i]);
    tile->spread = true;
}

/* A pixel of a tile whose paths are still listed, as it will be among the pixels. */
static struct rnd_film_pixel listed(const struct rnd_film_tile *tile, uint32_t i)
{
    struct rnd_film_pixel pixel = {0};
    for (uint32_t k = 0; k < tile->listed; k++)
        if (tile->list[k].pixel == i) add_to_pixel(&pixel, &tile->list[k]);
    return pixel;
}

struct rnd_film_pixel rnd_film_pixel_at(const struct rnd_film_tile *tile, uint32_t i)
{
    return tile->spread ? tile->pixels->pixel[i] : listed(tile, i);
}

/* Mean radiance of a pixel, 0 without a path, and how many paths there are. */
uint32_t rnd_film_mean(const struct rnd_film_pixel *pixel, float out_mean[3])
{
    const uint32_t n = pixel->count[0] + pixel->count[1];
    const float share = n > 0 ? (float)pixel->count[1] / (float)n : 0.0f;
    for (int c = 0; c < 3; c++)
        out_mean[c] = pixel->half[0][c] + (pixel->half[1][c] - pixel->half[0][c]) * share;
    return n;
}

static uint32_t block_of(uint32_t pixel)
{
    const uint32_t x = pixel % RND_TILE, y = pixel / RND_TILE;
    return y / RND_BLOCK * (RND_TILE / RND_BLOCK) + x / RND_BLOCK;
}

static void add(struct rnd_film_tile *tile, const struct rnd_sample *s)
{
    struct rnd_film_block *block = &tile->block[block_of(s->pixel)];
    float mean[3];
    const struct rnd_film_pixel pixel = rnd_film_pixel_at(tile, s->pixel);
    const uint32_t n = rnd_film_mean(&pixel, mean);
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

/* Before its radiance is added: the number of the pixel's paths counts for both. */
static void add_planes(const struct rnd_film *film, struct rnd_film_tile *tile, uint32_t i,
                       const float *values)
{
    const struct rnd_film_pixel pixel = rnd_film_pixel_at(tile, i);
    rnd_planes_add(&film->planes, rnd_film_record(film, tile, i),
                   rnd_film_plane_block(film, tile, block_of(i)), pixel.count[0] + pixel.count[1], values);
}

void rnd_film_add(const struct rnd_film *film, struct rnd_film_tile *tile, const struct rnd_sample *samples,
                  const float *planes, uint32_t count, const struct rnd_aim *aim, uint64_t now_ns)
{
    uint32_t added = 0;
    for (uint32_t i = 0; i < count; i++) added += samples[i].pixel != RND_TILE_PIXELS;
    if (added == 0) return; /* and the tile does not answer this aim */
    pthread_mutex_lock(&tile->lock);
    if (!tile->spread && tile->listed + added > RND_FEW) rnd_film_spread(tile);
    for (uint32_t i = 0; i < count; i++) {
        if (samples[i].pixel == RND_TILE_PIXELS) continue;
        if (planes) add_planes(film, tile, samples[i].pixel, planes + i * (size_t)film->planes.channels);
        add(tile, &samples[i]);
    }
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

/* --- the whole film --- */

float rnd_film_error(const struct rnd_film_pixel *pixel)
{
    if (pixel->count[0] == 0 || pixel->count[1] == 0) return 0.0f;
    return 0.5f * fabsf(rnd_luminance(pixel->half[0]) - rnd_luminance(pixel->half[1]));
}

void rnd_film_resolve(const struct rnd_film *film, float *out_rgb, float *out_samples, float *out_error)
{
    for (int t = 0; t < film->across * film->down; t++) {
        struct rnd_film_tile *tile = &film->tile[t];
        const int left = t % film->across * RND_TILE, top = t / film->across * RND_TILE;
        pthread_mutex_lock(&tile->lock);
        if (!tile->spread) rnd_film_spread(tile);
        for (int i = 0; i < RND_TILE_PIXELS; i++) {
            const size_t to = (size_t)(top + i / RND_TILE) * film->width + left + i % RND_TILE;
            float mean[3];
            const uint32_t n = rnd_film_mean(&tile->pixels->pixel[i], mean);
            if (out_rgb) memcpy(&out_rgb[3 * to], mean, sizeof mean);
            if (out_samples) out_samples[to] = (float)n;
            if (out_error) out_error[to] = rnd_film_error(&tile->pixels->pixel[i]);
        }
        pthread_mutex_unlock(&tile->lock);
    }
}
