/* picture.c: what a client has put together from its tiles.
 *
 * Every level keeps its own tiles, as half floats and only those that came, so a coarse tile that arrives
 * late hides nothing. Tiles nest: a tile of one level covers two by two of the next finer one, so the finest
 * level there is the same for all pixels of a level-0 tile, and the picture is resolved tile by tile.
 */
#include "internal.h"
#include "encoding/half.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    MAX_LEVELS = 17,     /* of a film PRO_MAX_WIDTH wide */
    MAX_TILES = 2 << 20, /* of a film, at all levels: limits the tables of tiles, which are allocated first */
    /* Coarse pixels that a row of finer ones in a tile can touch, and one at either end. */
    MAX_ROW = PRO_MAX_TILE / 2 + 3,
};

struct level {
    uint32_t width, height; /* pixels */
    uint32_t columns, rows; /* tiles */
    uint16_t **tiles;       /* columns x rows; NULL: not come; else tile_size x tile_size x RGB halves */
};

struct pro_picture {
    uint32_t tile_size, levels;
    uint64_t generation;
    struct level level[MAX_LEVELS];
};

static uint32_t divide_up(uint32_t number, uint32_t by)
{
    return (number + by - 1) / by;
}

static bool check(const Fovea__Welcome *film, char out_error[PRO_ERROR_SIZE])
{
    uint32_t width = film->width, height = film->height, tile = film->tile_size;
    if (width < 1 || height < 1 || width > PRO_MAX_WIDTH || height > PRO_MAX_WIDTH ||
        (uint64_t)width * height > PRO_MAX_PIXELS)
        return pro_fail(out_error, "the daemon says that its film has %u x %u pixels", width, height);
    if (tile < 1 || tile > PRO_MAX_TILE || width % tile != 0 || height % tile != 0)
        return pro_fail(out_error, "the daemon says that tiles of %u pixels make a film of %u x %u", tile,
                        width, height);
    uint32_t least = width < height ? width : height;
    if (film->levels < 1 || film->levels > MAX_LEVELS || least >> (film->levels - 1) == 0)
        return pro_fail(out_error, "the daemon says that a film of %u x %u has %u levels", width, height,
                        film->levels);
    return true;
}

struct pro_picture *pro_picture_create(const Fovea__Welcome *welcome, char out_error[PRO_ERROR_SIZE])
{
    if (!check(welcome, out_error)) return NULL;
    struct pro_picture *picture = calloc(1, sizeof *picture);
    if (!picture) goto short_of_memory;
    picture->tile_size = welcome->tile_size;
    picture->levels = welcome->levels;
    picture->generation = welcome->generation;
    uint64_t tiles = 0;
    for (uint32_t l = 0; l < picture->levels; l++) {
        struct level *level = &picture->level[l];
        level->width = divide_up(welcome->width, 1u << l);
        level->height = divide_up(welcome->height, 1u << l);
        level->columns = divide_up(level->width, picture->tile_size);
        level->rows = divide_up(level->height, picture->tile_size);
        uint64_t count = (uint64_t)level->columns * level->rows;
        tiles += count;
        if (tiles > MAX_TILES) {
            pro_fail(out_error, "the daemon says that a film of %u x %u is in tiles of %u pixels: too many",
                     welcome->width, welcome->height, picture->tile_size);
            goto fail;
        }
        level->tiles = calloc(count, sizeof *level->tiles);
        if (!level->tiles) goto short_of_memory;
    }
    return picture;

short_of_memory:
    pro_fail(out_error, "memory is short for a film of %u x %u", welcome->width, welcome->height);
fail:
    pro_picture_destroy(picture);
    return NULL;
}

static void clear(struct pro_picture *picture)
{
    for (uint32_t l = 0; l < picture->levels; l++) {
        struct level *level = &picture->level[l];
        size_t count = level->tiles ? (size_t)level->columns * level->rows : 0;
        for (size_t i = 0; i < count; i++) {
            free(level->tiles[i]);
            level->tiles[i] = NULL;
        }
    }
}

void pro_picture_destroy(struct pro_picture *picture)
{
    if (!picture) return;
    clear(picture);
    for (uint32_t l = 0; l < picture->levels; l++) free(picture->level[l].tiles);
    free(picture);
}

bool pro_picture_has_place(const struct pro_picture *picture, uint32_t level, uint32_t x, uint32_t y)
{
    return level < picture->levels && x < picture->level[level].columns && y < picture->level[level].rows;
}

bool pro_picture_put(struct pro_picture *picture, uint64_t generation, uint32_t level, uint32_t x, uint32_t y,
                     const float *rgb)
{
    if (generation < picture->generation) return true;
    if (generation > picture->generation) {
        clear(picture);
        picture->generation = generation;
    }
    size_t values = (size_t)picture->tile_size * picture->tile_size * 3;
    uint16_t **tile = &picture->level[level].tiles[(size_t)y * picture->level[level].columns + x];
    if (!*tile) *tile = malloc(values * sizeof **tile);
    if (!*tile) return false;
    for (size_t i = 0; i < values; i++) (*tile)[i] = half_from_float(rgb[i]);
    return true;
}

static const uint16_t *tile_at(const struct pro_picture *picture, uint32_t level, uint32_t x, uint32_t y)
{
    return picture->level[level].tiles[(size_t)y * picture->level[level].columns + x];
}

/* The finest level at which the level-0 tile (x, y) has come; the number of levels if there is none. */
static uint32_t finest(const struct pro_picture *picture, uint32_t x, uint32_t y)
{
    uint32_t level = 0;
    while (level < picture->levels && !tile_at(picture, level, x >> level, y >> level)) level++;
    return level;
}

double pro_picture_coverage(const struct pro_picture *picture)
{
    const struct level *film = &picture->level[0];
    uint64_t covered = 0;
    for (uint32_t y = 0; y < film->rows; y++)
        for (uint32_t x = 0; x < film->columns; x++) covered += finest(picture, x, y) < picture->levels;
    return (double)covered / ((double)film->columns * film->rows);
}

/* --- resolve --- */

static int32_t clamp(int32_t value, int32_t least, int32_t most)
{
    return value < least ? least : value > most ? most : value;
}

/* A tile of a level. */
struct home {
    uint32_t level, x, y;
};

/* Copy a row of count pixels of a level, from x0 on, around a home tile. u wraps, and v is clamped. A pixel
 * of a tile that has not come becomes the nearest pixel of the home tile. */
static void gather(const struct pro_picture *picture, const struct home *home, int32_t x0, int32_t y,
                   int32_t count, float *out_rgb)
{
    const uint32_t l = home->level;
    const struct level *level = &picture->level[l];
    int32_t size = (int32_t)picture->tile_size, width = (int32_t)level->width,
            height = (int32_t)level->height;
    int32_t left = (int32_t)home->x * size, right = (left + size < width ? left + size : width) - 1;
    int32_t top = (int32_t)home->y * size, bottom = (top + size < height ? top + size : height) - 1;
    y = clamp(y, 0, height - 1);
    for (int32_t i = 0; i < count; i++) {
        int32_t px = (x0 + i + width) % width, py = y;
        const uint16_t *tile = tile_at(picture, l, (uint32_t)(px / size), (uint32_t)(py / size));
        if (!tile) {
            tile = tile_at(picture, l, home->x, home->y);
            px = clamp(x0 + i, left, right);
            py = clamp(py, top, bottom);
        }
        const uint16_t *pixel = tile + ((size_t)(py % size) * (size_t)size + (size_t)(px % size)) * 3;
        for (int c = 0; c < 3; c++) out_rgb[3 * i + c] = half_to_float(pixel[c]);
    }
}

/* Fill the level-0 tile (x, y) from level l > 0. out_rgb is its first pixel in the film. */
static void interpolate(const struct pro_picture *picture, uint32_t l, uint32_t x, uint32_t y, float *out_rgb)
{
    const struct home home = {l, x >> l, y >> l};
    uint32_t size = picture->tile_size;
    size_t stride = (size_t)picture->level[0].width * 3;
    float scale = 1.0f / (float)(1u << l);
    float u0 = ((float)(x * size) + 0.5f) * scale - 0.5f, v0 = ((float)(y * size) + 0.5f) * scale - 0.5f;
    int32_t first = (int32_t)floorf(u0), row = INT32_MIN;
    int32_t count = (int32_t)floorf(u0 + (float)(size - 1) * scale) + 2 - first;
    float rows[2][MAX_ROW * 3], mixed[MAX_ROW * 3];
    for (uint32_t j = 0; j < size; j++) {
        float v = v0 + (float)j * scale, t = v - floorf(v);
        if ((int32_t)floorf(v) != row) {
            row = (int32_t)floorf(v);
            gather(picture, &home, first, row, count, rows[0]);
            gather(picture, &home, first, row + 1, count, rows[1]);
        }
        for (int32_t i = 0; i < 3 * count; i++) mixed[i] = rows[0][i] + t * (rows[1][i] - rows[0][i]);
        float *out = out_rgb + j * stride;
        for (uint32_t i = 0; i < size; i++) {
            float at = u0 + (float)i * scale - (float)first, s = at - floorf(at);
            const float *pair = mixed + 3 * (int32_t)at;
            for (int c = 0; c < 3; c++) out[3 * i + c] = pair[c] + s * (pair[3 + c] - pair[c]);
        }
    }
}

static void copy(const struct pro_picture *picture, const uint16_t *tile, float *out_rgb)
{
    size_t row = (size_t)picture->tile_size * 3, stride = (size_t)picture->level[0].width * 3;
    for (uint32_t j = 0; j < picture->tile_size; j++)
        for (size_t i = 0; i < row; i++) out_rgb[j * stride + i] = half_to_float(tile[j * row + i]);
}

static void blank(const struct pro_picture *picture, float *out_rgb)
{
    size_t row = (size_t)picture->tile_size * 3, stride = (size_t)picture->level[0].width * 3;
    for (uint32_t j = 0; j < picture->tile_size; j++) memset(out_rgb + j * stride, 0, row * sizeof *out_rgb);
}

void pro_picture_resolve(const struct pro_picture *picture, float *out_rgb)
{
    const struct level *film = &picture->level[0];
    size_t size = picture->tile_size;
    for (uint32_t y = 0; y < film->rows; y++) {
        for (uint32_t x = 0; x < film->columns; x++) {
            float *out = out_rgb + (y * size * film->width + x * size) * 3;
            uint32_t level = finest(picture, x, y);
            if (level == 0)
                copy(picture, tile_at(picture, 0, x, y), out);
            else if (level < picture->levels)
                interpolate(picture, level, x, y, out);
            else
                blank(picture, out);
        }
    }
}
