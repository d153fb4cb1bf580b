/* The film's memory, and what is read from it: tiles at any level, the whole picture, its file. */
#include "large_pages.h"
#include "film.h"
#include "image.h"
#include "render.h"
#include "sphere.h"

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
    /* Fresh pages of the system cost nothing until a sample falls there. */
    film->pixels = malloc(tiles * sizeof *film->pixels);
    rnd_use_large_pages(film->pixels, tiles * sizeof *film->pixels);
    if (!film->tile || !film->published || !film->pixels) return false;
    for (size_t t = 0; t < tiles; t++) {
        struct rnd_film_tile *tile = &film->tile[t];
        pthread_mutex_init(&tile->lock, NULL);
        tile->pixels = &film->pixels[t];
        rnd_film_empty(film, tile, 0);
    }
    return true;
}

void rnd_film_finish(struct rnd_film *film)
{
    const int tiles = film->tile && film->published && film->pixels ? film->across * film->down : 0;
    for (int t = 0; t < tiles; t++) pthread_mutex_destroy(&film->tile[t].lock);
    free(film->tile);
    free(film->pixels);
    free(film->published);
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
    tile->state =
        (struct rnd_tile){.generation = generation, .unvisited = RND_TILE_PIXELS, .error = INFINITY};
    tile->next_judgement = 2 * RND_TILE_PIXELS;
    tile->passed = tile->spread = false;
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

static void add_to_pixel(struct rnd_film_pixels *pixels, const struct rnd_sample *sample)
{
    const uint32_t h = sample->number & 1;
    float *sum = pixels->half[h][sample->pixel];
    /* The half-sums are most of a film: emptying it leaves them as they were, and this is in time. */
    if (pixels->count[h][sample->pixel]++ == 0) sum[0] = sum[1] = sum[2] = 0.0f;
    for (int c = 0; c < 3; c++) sum[c] += sample->rgb[c];
}

/* From the list to the pixels. */
static void spread(struct rnd_film_tile *tile)
{
    memset(tile->pixels->count, 0, sizeof tile->pixels->count);
    for (uint32_t i = 0; i < tile->listed; i++) add_to_pixel(tile->pixels, &tile->list[i]);
    tile->spread = true;
}

static bool has_listed(const struct rnd_film_tile *tile, uint32_t pixel)
{
    for (uint32_t i = 0; i < tile->listed; i++)
        if (tile->list[i].pixel == pixel) return true;
    return false;
}

void rnd_film_add(const struct rnd_film *film, struct rnd_film_tile *tile, const struct rnd_sample *samples,
                  uint32_t count, const struct rnd_aim *aim, uint64_t now_ns)
{
    uint32_t added = 0;
    for (uint32_t i = 0; i < count; i++) added += samples[i].pixel != RND_TILE_PIXELS;
    pthread_mutex_lock(&tile->lock);
    if (!tile->spread && tile->listed + added > RND_FEW) spread(tile);
    for (uint32_t i = 0; i < count; i++) {
        const struct rnd_sample *s = &samples[i];
        if (s->pixel == RND_TILE_PIXELS) continue;
        const uint32_t x = s->pixel % RND_TILE, y = s->pixel / RND_TILE;
        float *block = tile->block[y / RND_BLOCK * (RND_TILE / RND_BLOCK) + x / RND_BLOCK];
        if (tile->spread) {
            tile->state.unvisited -= rnd_film_count(tile, s->pixel) == 0;
            add_to_pixel(tile->pixels, s);
        } else {
            tile->state.unvisited -= !has_listed(tile, s->pixel);
            tile->list[tile->listed++] = *s;
        }
        for (int c = 0; c < 3; c++) block[c] += s->rgb[c];
        block[3] += 1.0f;
    }
    tile->state.samples += added;
    tile->state.gaze_sequence = aim->sequence;
    tile->state.gaze_ns = aim->time_ns;
    tile->state.aimed_ns = now_ns;
    if (tile->spread && tile->state.samples >= tile->next_judgement) {
        rnd_judge(tile, film->error_bar);
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

/* Sums of radiance and counts of a tile at any level: RND_TILE x RND_TILE x 4. */
struct sums {
    float value[RND_TILE][RND_TILE][4];
};

/* Add a level-0 tile's part, scale pixels of it to one of the sums', from (left, top) of them on. */
static void add_tile(const struct rnd_film_tile *tile, int scale, int left, int top, struct sums *sums)
{
    if (scale >= RND_BLOCK) {
        const int per = scale / RND_BLOCK, n = RND_TILE / RND_BLOCK;
        for (int y = 0; y < n; y++)
            for (int x = 0; x < n; x++) {
                float *to = sums->value[top + y / per][left + x / per];
                for (int c = 0; c < 4; c++) to[c] += tile->block[y * n + x][c];
            }
        return;
    }
    for (uint32_t i = 0; !tile->spread && i < tile->listed; i++) {
        const int x = (int)tile->list[i].pixel % RND_TILE, y = (int)tile->list[i].pixel / RND_TILE;
        float *to = sums->value[top + y / scale][left + x / scale];
        for (int c = 0; c < 3; c++) to[c] += tile->list[i].rgb[c];
        to[3] += 1.0f;
    }
    const struct rnd_film_pixels *pixels = tile->pixels;
    for (int y = 0; tile->spread && y < RND_TILE; y++)
        for (int x = 0; x < RND_TILE; x++) {
            const int i = y * RND_TILE + x;
            float *to = sums->value[top + y / scale][left + x / scale];
            for (int h = 0; h < 2; h++) {
                if (pixels->count[h][i] == 0) continue;
                for (int c = 0; c < 3; c++) to[c] += pixels->half[h][i][c];
                to[3] += (float)pixels->count[h][i];
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
    to->luminance += from->luminance;
    to->converged &= from->converged;
    if (!newer) return;
    to->gaze_sequence = from->gaze_sequence;
    to->gaze_ns = from->gaze_ns;
    to->aimed_ns = from->aimed_ns;
}

/* Paths after which a pixel that stayed black is taken for black. Before, every light may just have been
 * hidden from the few points that its paths asked from, and black says no more than no path does. */
enum { SURE_PATHS = 64 };

static bool tells(const float sum[4])
{
    return sum[3] >= SURE_PATHS || (sum[3] > 0.0f && sum[0] + sum[1] + sum[2] > 0.0f);
}

/* Mean of the smallest square around each pixel, by powers of two, that tells something. */
static bool fill(const struct sums *sums, float *out_rgb)
{
    static const int top = 6; /* 2^6 = RND_TILE */
    _Static_assert(RND_TILE == 64, "the pyramid below is 64 wide");
    float pyramid[64 * 64 / 3 + 2][4]; /* levels 1..6, one behind the other */
    const float(*level[7])[4] = {(const float(*)[4])sums->value};
    float(*next)[4] = pyramid;
    for (int l = 1; l <= top; l++) {
        const int n = RND_TILE >> l;
        for (int i = 0; i < n * n; i++)
            for (int c = 0; c < 4; c++) {
                const float(*a)[4] = level[l - 1] + (i / n) * 2 * (2 * n) + (i % n) * 2;
                next[i][c] = a[0][c] + a[1][c] + a[2 * n][c] + a[2 * n + 1][c];
            }
        level[l] = (const float(*)[4])next;
        next += n * n;
    }
    if (level[top][0][3] == 0.0f) return false;
    for (int y = 0; y < RND_TILE; y++)
        for (int x = 0; x < RND_TILE; x++) {
            int l = 0;
            const float *s = sums->value[y][x];
            while (!tells(s) && l < top) {
                l++;
                s = level[l][(y >> l) * (RND_TILE >> l) + (x >> l)];
            }
            for (int c = 0; c < 3; c++) out_rgb[(y * RND_TILE + x) * 3 + c] = s[c] / s[3];
        }
    return true;
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
    struct sums sums = {0};
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
    return whole && fill(&sums, out_rgb);
}

/* Standard error of a pixel's luminance from its halves; 0 if one is empty. */
static float pixel_error(const struct rnd_film_tile *tile, int i)
{
    const struct rnd_film_pixels *pixels = tile->pixels;
    const uint32_t even = pixels->count[0][i], odd = pixels->count[1][i];
    if (odd == 0 || even == 0) return 0.0f;
    return 0.5f * fabsf(rnd_luminance(pixels->half[0][i]) / even - rnd_luminance(pixels->half[1][i]) / odd);
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
            float sum[3] = {0}, n = 0.0f;
            for (int h = 0; h < 2; h++)
                if (tile->pixels->count[h][i] > 0) {
                    n += (float)tile->pixels->count[h][i];
                    for (int c = 0; c < 3; c++) sum[c] += tile->pixels->half[h][i][c];
                }
            for (int c = 0; out_rgb && c < 3; c++) out_rgb[3 * to + c] = n > 0.0f ? sum[c] / n : 0.0f;
            if (out_samples) out_samples[to] = n;
            if (out_error) out_error[to] = pixel_error(tile, i);
        }
        pthread_mutex_unlock(&tile->lock);
    }
    pthread_mutex_unlock(&render->whole);
}

bool rnd_render_save(struct rnd_render *render, const char *path, char out_error[RND_ERROR_SIZE])
{
    const int width = render->film.width, height = render->film.height;
    const size_t count = (size_t)width * height;
    float *plane = malloc(count * 5 * sizeof *plane), *data = malloc(count * 5 * sizeof *data);
    bool ok = false;
    if (!plane || !data) {
        snprintf(out_error, RND_ERROR_SIZE, "%.200s: not enough memory", path);
    } else {
        float *samples = plane + 3 * count, *error = samples + count;
        rnd_render_resolve(render, plane, samples, error);
        const enum rnd_channel_type colour = rnd_exr_type(plane, 3 * count),
                                    spread = rnd_exr_type(error, count);
        const struct rnd_channel channel[5] = {
            {"R", colour}, {"G", colour}, {"B", colour}, {"samples", RND_FLOAT}, {"error", spread}};
        for (size_t i = 0; i < count; i++) {
            memcpy(&data[5 * i], &plane[3 * i], 3 * sizeof *data);
            data[5 * i + 3] = samples[i];
            data[5 * i + 4] = error[i];
        }
        ok = rnd_image_write_channels(path, width, height, 5, channel, data, true, out_error);
    }
    free(plane);
    free(data);
    return ok;
}
