/* Running a reconstruction on a film: a row is given the tile, and what lies around it. */
#include "reconstruct/reconstruct.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

bool rnd_reconstructor_init(struct rnd_reconstructor *reconstructor, const struct rnd_reconstruction *row,
                            const struct rnd_film *film)
{
    assert(row->radius >= 0 && row->radius <= RND_TILE);
    *reconstructor = (struct rnd_reconstructor){.film = film};
    if (row->begin && !row->begin(film->width, film->height, &reconstructor->memory)) return false;
    reconstructor->row = row;
    return true;
}

void rnd_reconstructor_finish(struct rnd_reconstructor *reconstructor)
{
    if (reconstructor->row && reconstructor->row->end) reconstructor->row->end(reconstructor->memory);
    *reconstructor = (struct rnd_reconstructor){0};
}

/* --- windows with a margin --- */

/* A window, and room for one of its tiles. */
struct room {
    struct rnd_sums sums;
    struct rnd_sum pixel[];
};

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

/* Copy the part of a window that lies dx tiles to the right and dy tiles below its own tile. All of it is of one
 * tile, since pictures are an even number of tiles across. False if that tile cannot be read, or is of another
 * generation. */
static bool take(const struct rnd_reconstructor *reconstructor, const struct rnd_window *window, int dx,
                 int dy, struct rnd_tile *state, struct room *room)
{
    const struct rnd_film *film = reconstructor->film;
    const int radius = reconstructor->row->radius, width = film->width >> window->level,
              height = film->height >> window->level;
    /* of the tile's edges, those that are in the window, from its corner */
    const int left = dx < 0 ? 0 : radius + dx * RND_TILE, top = dy < 0 ? 0 : radius + dy * RND_TILE,
              right = dx > 0 ? window->side : radius + (dx + 1) * RND_TILE,
              bottom = dy > 0 ? window->side : radius + (dy + 1) * RND_TILE;
    const int first_x = window->x * RND_TILE - radius, first_y = window->y * RND_TILE - radius;
    struct rnd_tile other;
    int x = first_x + left, y = first_y + top;
    wrap(width, height, &x, &y);
    if (!rnd_film_sums(film, window->level, x / RND_TILE, y / RND_TILE, &room->sums, &other)) return false;
    if (dx == 0 && dy == 0) *state = other;
    if (other.generation != state->generation) return false;
    for (int to_y = top; to_y < bottom; to_y++)
        for (int to_x = left; to_x < right; to_x++) {
            x = first_x + to_x;
            y = first_y + to_y;
            wrap(width, height, &x, &y);
            room->pixel[to_y * window->side + to_x] =
                room->sums.pixel[y % RND_TILE * RND_TILE + x % RND_TILE];
        }
    return true;
}

static bool with_margin(const struct rnd_reconstructor *reconstructor, struct rnd_window *window,
                        float *out_rgb, struct rnd_tile *out_state)
{
    const size_t pixels = (size_t)window->side * (size_t)window->side;
    struct room *room = malloc(sizeof *room + pixels * sizeof *room->pixel);
    *out_state = (struct rnd_tile){0};
    bool whole = room && take(reconstructor, window, 0, 0, out_state, room);
    for (int i = 0; whole && i < 9; i++)
        if (i != 4) whole = take(reconstructor, window, i % 3 - 1, i / 3 - 1, out_state, room);
    if (whole) {
        window->pixel = room->pixel;
        whole = reconstructor->row->run(reconstructor->memory, window, out_rgb);
    }
    free(room);
    return whole;
}

bool rnd_reconstruct(const struct rnd_reconstructor *reconstructor, int level, int x, int y, float *out_rgb,
                     struct rnd_tile *out_state)
{
    const struct rnd_reconstruction *row = reconstructor->row;
    struct rnd_sums sums;
    struct rnd_window window = {
        .level = level, .x = x, .y = y, .side = RND_TILE + 2 * row->radius, .pixel = sums.pixel};
    if (row->radius > 0) return with_margin(reconstructor, &window, out_rgb, out_state);
    return rnd_film_sums(reconstructor->film, level, x, y, &sums, out_state) &&
           row->run(reconstructor->memory, &window, out_rgb);
}
