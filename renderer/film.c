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
    /* Fresh pages of the system are zero and cost nothing until a sample falls there. */
    const size_t tiles = (size_t)film->across * (size_t)film->down;
    film->tile = calloc(tiles, sizeof *film->tile);
    rnd_use_large_pages(film->tile, tiles * sizeof *film->tile);
    return film->tile != NULL;
}

void rnd_film_finish(struct rnd_film *film)
{
    free(film->tile);
    film->tile = NULL;
}

void rnd_film_empty(struct rnd_film_tile *tile, uint32_t generation)
{
    rnd_film_lock(tile);
    if (tile->state.samples > 0) {
        memset(tile->count, 0, sizeof tile->count);
        memset(tile->drawn, 0, sizeof tile->drawn);
        memset(tile->block, 0, sizeof tile->block);
    }
    tile->state = (struct rnd_tile){.generation = generation};
    tile->passed = false;
    rnd_film_unlock(tile);
}

void rnd_film_add(const struct rnd_film *film, struct rnd_film_tile *tile, const struct rnd_sample *samples,
                  uint32_t count, const struct rnd_aim *aim, uint64_t now_ns)
{
    rnd_film_lock(tile);
    if (tile->state.samples == 0) {
        tile->state.unvisited = RND_TILE_PIXELS;
        tile->state.error = INFINITY;
        tile->next_judgement = 2 * RND_TILE_PIXELS;
    }
    uint32_t added = 0;
    for (uint32_t i = 0; i < count; i++) {
        const struct rnd_sample *s = &samples[i];
        if (s->pixel == RND_TILE_PIXELS) continue;
        const uint32_t h = s->number & 1, x = s->pixel % RND_TILE, y = s->pixel / RND_TILE;
        float *sum = tile->half[h][s->pixel];
        float *block = tile->block[y / RND_BLOCK * (RND_TILE / RND_BLOCK) + x / RND_BLOCK];
        tile->state.unvisited -= rnd_film_count(tile, s->pixel) == 0;
        /* The half-sums are most of a film: emptying it leaves them as they were, and this is in time. */
        if (tile->count[h][s->pixel]++ == 0) sum[0] = sum[1] = sum[2] = 0.0f;
        for (int c = 0; c < 3; c++) {
            sum[c] += s->rgb[c];
            block[c] += s->rgb[c];
        }
        block[3] += 1.0f;
        added++;
    }
    tile->state.samples += added;
    tile->state.gaze_sequence = aim->sequence;
    tile->state.gaze_ns = aim->time_ns;
    tile->state.aimed_ns = now_ns;
    if (tile->state.samples >= tile->next_judgement) {
        rnd_judge(tile, film->error_bar);
        tile->next_judgement = tile->state.samples + tile->state.samples / 4;
    }
    rnd_film_unlock(tile);
}

/* --- reading --- */

int rnd_render_levels(const struct rnd_render *render)
{
    int levels = 1; /* the width is twice the height and so divides where the height does */
    while ((render->film.height >> levels) >= RND_TILE && (render->film.height >> levels) % RND_TILE == 0)
        levels++;
    return levels;
}

/* A tile's state, with the lock held. One that nothing has reached is still the zeros of fresh memory. */
static struct rnd_tile state_of(const struct rnd_film_tile *tile)
{
    struct rnd_tile state = tile->state;
    if (state.samples > 0) return state;
    state.unvisited = RND_TILE_PIXELS;
    state.error = INFINITY;
    return state;
}

void rnd_render_tiles(struct rnd_render *render, struct rnd_tile *out_tiles)
{
    const int count = render->film.across * render->film.down;
    for (int i = 0; i < count; i++) {
        struct rnd_film_tile *tile = &render->film.tile[i];
        rnd_film_lock(tile);
        out_tiles[i] = state_of(tile);
        rnd_film_unlock(tile);
    }
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
    for (int y = 0; y < RND_TILE; y++)
        for (int x = 0; x < RND_TILE; x++) {
            const int i = y * RND_TILE + x;
            float *to = sums->value[top + y / scale][left + x / scale];
            for (int h = 0; h < 2; h++) {
                if (tile->count[h][i] == 0) continue;
                for (int c = 0; c < 3; c++) to[c] += tile->half[h][i][c];
                to[3] += (float)tile->count[h][i];
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

bool rnd_render_read(struct rnd_render *render, int level, int x, int y, float *out_rgb,
                     struct rnd_tile *out_state)
{
    const struct rnd_film *film = &render->film;
    const int span =
        1 << level; /* level-0 tiles a side; from level 7 on, each is less than a pixel of the sums */
    struct sums sums = {0};
    struct rnd_tile state = {0};
    bool mixed = false; /* part of it was emptied meanwhile */
    for (int i = 0; i < span * span; i++) {
        const int dx = i % span, dy = i / span;
        struct rnd_film_tile *tile = &film->tile[(y * span + dy) * film->across + x * span + dx];
        rnd_film_lock(tile);
        const struct rnd_tile part = state_of(tile);
        if (part.samples > 0) add_tile(tile, span, dx * RND_TILE / span, dy * RND_TILE / span, &sums);
        merge_state(&state, &part, i == 0);
        rnd_film_unlock(tile);
        mixed |= part.generation != state.generation;
    }
    state.luminance /= (float)(span * span);
    if (out_state) *out_state = state;
    return !mixed && fill(&sums, out_rgb);
}

/* Standard error of a pixel's luminance from its halves; 0 if one is empty. */
static float pixel_error(const struct rnd_film_tile *tile, int i)
{
    const uint32_t even = tile->count[0][i], odd = tile->count[1][i];
    if (odd == 0 || even == 0) return 0.0f;
    return 0.5f * fabsf(rnd_luminance(tile->half[0][i]) / even - rnd_luminance(tile->half[1][i]) / odd);
}

void rnd_render_resolve(struct rnd_render *render, float *out_rgb, float *out_samples, float *out_error)
{
    const struct rnd_film *film = &render->film;
    pthread_mutex_lock(&render->whole);
    for (int t = 0; t < film->across * film->down; t++) {
        struct rnd_film_tile *tile = &film->tile[t];
        const int left = t % film->across * RND_TILE, top = t / film->across * RND_TILE;
        rnd_film_lock(tile);
        for (int i = 0; i < RND_TILE_PIXELS; i++) {
            const size_t to = (size_t)(top + i / RND_TILE) * film->width + left + i % RND_TILE;
            float sum[3] = {0}, n = 0.0f;
            for (int h = 0; h < 2; h++)
                if (tile->count[h][i] > 0) {
                    n += (float)tile->count[h][i];
                    for (int c = 0; c < 3; c++) sum[c] += tile->half[h][i][c];
                }
            for (int c = 0; out_rgb && c < 3; c++) out_rgb[3 * to + c] = n > 0.0f ? sum[c] / n : 0.0f;
            if (out_samples) out_samples[to] = n;
            if (out_error) out_error[to] = pixel_error(tile, i);
        }
        rnd_film_unlock(tile);
    }
    pthread_mutex_unlock(&render->whole);
}

bool rnd_render_save(struct rnd_render *render, const char *path, char out_error[RND_ERROR_SIZE])
{
    static const struct rnd_channel channel[5] = {
        {"R", RND_HALF}, {"G", RND_HALF}, {"B", RND_HALF}, {"samples", RND_FLOAT}, {"error", RND_HALF}};
    const int width = render->film.width, height = render->film.height;
    const size_t count = (size_t)width * height;
    float *plane = malloc(count * 5 * sizeof *plane), *data = malloc(count * 5 * sizeof *data);
    bool ok = false;
    if (!plane || !data) {
        snprintf(out_error, RND_ERROR_SIZE, "%.200s: not enough memory", path);
    } else {
        float *samples = plane + 3 * count, *error = samples + count;
        rnd_render_resolve(render, plane, samples, error);
        for (size_t i = 0; i < count; i++) {
            for (int c = 0; c < 3; c++)
                data[5 * i + c] = fminf(plane[3 * i + c], 65504.0f); /* largest half */
            data[5 * i + 3] = samples[i];
            data[5 * i + 4] = fminf(error[i], 65504.0f);
        }
        ok = rnd_image_write_channels(path, width, height, 5, channel, data, true, out_error);
    }
    free(plane);
    free(data);
    return ok;
}
