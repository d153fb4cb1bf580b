/* Running a reconstruction on a film: a row is given the tile, and what lies around it. */
#include "reconstruct/reconstruct.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

bool rnd_reconstructor_init(struct rnd_reconstructor *reconstructor, const struct rnd_reconstruction *row,
                            const struct rnd_film *film, const struct rnd_film *history)
{
    assert(row->radius >= 0 && row->radius <= RND_TILE);
    *reconstructor = (struct rnd_reconstructor){.film = film, .history = history};
    if (row->begin && !row->begin(film->width, film->height, &reconstructor->memory)) return false;
    reconstructor->row = row;
    return true;
}

void rnd_reconstructor_finish(struct rnd_reconstructor *reconstructor)
{
    if (reconstructor->row && reconstructor->row->end) reconstructor->row->end(reconstructor->memory);
    *reconstructor = (struct rnd_reconstructor){0};
}

/* --- windows of more than a tile's radiance --- */

/* Memory of a window, and of the tile of it that is being read. */
struct room {
    struct rnd_sums sums;
    float *tile_values; /* the tile's planes; NULL: none are asked for */
    float *values;      /* as the window has them */
    struct rnd_sum pixel[];
};

/* NULL if memory is short. */
static struct room *make_room(const struct rnd_reconstructor *reconstructor, const struct rnd_window *window)
{
    const size_t pixels = (size_t)window->side * (size_t)window->side,
                 channels = (size_t)reconstructor->film->planes.channels,
                 values = channels * (pixels + RND_TILE_PIXELS);
    struct room *room = malloc(sizeof *room + pixels * sizeof *room->pixel + values * sizeof *room->values);
    if (!room) return NULL;
    room->values = (float *)(room->pixel + pixels);
    room->tile_values = channels > 0 ? room->values + channels * pixels : NULL;
    return room;
}

/* Where a level's picture of width x height pixels goes on beyond its edges: (x, y), which is at most the
 * height away from it, becomes a pixel of the picture. */
static void wrap(int width, int height, int *x, int *y)
{
    if (*y < 0 || *y >= height) { /* over the pole */
        *y = *y < 0 ? -1 - *y : 2 * height - 1 - *y;
        *x += width / 2;
    }
    *x = (*x + 2 * width) % width;
}

/* Read the part of a window that lies dx tiles to the right of its own tile and dy below. All of it is of
 * one tile, since pictures are an even number of tiles across. False if that tile cannot be read, or is of
 * another generation. */
static bool read_part(const struct rnd_reconstructor *reconstructor, const struct rnd_window *window, int dx,
                      int dy, struct room *room, struct rnd_tile *state)
{
    const struct rnd_film *film = reconstructor->film;
    const int radius = reconstructor->row->radius, width = film->width >> window->level,
              height = film->height >> window->level, channels = film->planes.channels;
    const int left = dx < 0 ? 0 : radius + dx * RND_TILE, top = dy < 0 ? 0 : radius + dy * RND_TILE,
              right = dx > 0 ? window->side : radius + (dx + 1) * RND_TILE,
              bottom = dy > 0 ? window->side : radius + (dy + 1) * RND_TILE;
    const int first_x = window->x * RND_TILE - radius, first_y = window->y * RND_TILE - radius;
    struct rnd_tile other;
    int x = first_x + left, y = first_y + top;
    wrap(width, height, &x, &y);
    const bool whole = rnd_film_sums(film, window->level, x / RND_TILE, y / RND_TILE, &room->sums,
                                     room->tile_values, &other);
    if (dx == 0 && dy == 0) *state = other;
    if (!whole || other.generation != state->generation) return false;
    for (int i = 0; i < (right - left) * (bottom - top); i++) {
        const int to_x = left + i % (right - left), to_y = top + i / (right - left),
                  to = to_y * window->side + to_x;
        x = first_x + to_x;
        y = first_y + to_y;
        wrap(width, height, &x, &y);
        const int from = y % RND_TILE * RND_TILE + x % RND_TILE;
        room->pixel[to] = room->sums.pixel[from];
        if (room->tile_values)
            memcpy(room->values + to * channels, room->tile_values + from * channels,
                   (size_t)channels * sizeof *room->values);
    }
    return true;
}

static bool run_large(const struct rnd_reconstructor *reconstructor, struct rnd_window *window,
                      float *out_rgb, struct rnd_tile *out_state)
{
    struct room *room = make_room(reconstructor, window);
    *out_state = (struct rnd_tile){0};
    bool whole = room && read_part(reconstructor, window, 0, 0, room, out_state);
    for (int i = 0; whole && reconstructor->row->radius > 0 && i < 9; i++)
        if (i != 4) whole = read_part(reconstructor, window, i % 3 - 1, i / 3 - 1, room, out_state);
    if (whole) {
        window->camera = room->sums.camera;
        window->generation = out_state->generation;
        window->pixel = room->pixel;
        window->values = room->values;
        whole = reconstructor->row->run(reconstructor->memory, window, out_rgb);
    }
    free(room);
    return whole;
}

bool rnd_reconstruct(const struct rnd_reconstructor *reconstructor, int level, int x, int y, float *out_rgb,
                     struct rnd_tile *out_state)
{
    const struct rnd_reconstruction *row = reconstructor->row;
    const struct rnd_film *film = reconstructor->film;
    struct rnd_sums sums;
    struct rnd_window window = {.level = level,
                                .x = x,
                                .y = y,
                                .side = RND_TILE + 2 * row->radius,
                                .pixel = sums.pixel,
                                .planes = &film->planes,
                                .history = reconstructor->history};
    if (row->radius > 0 || row->planes) return run_large(reconstructor, &window, out_rgb, out_state);
    if (!rnd_film_sums(film, level, x, y, &sums, NULL, out_state)) return false;
    window.camera = sums.camera;
    window.generation = out_state->generation;
    return row->run(reconstructor->memory, &window, out_rgb);
}
