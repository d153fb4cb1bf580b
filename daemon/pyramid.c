/* What is known of the film's tiles at every level. Levels form a tree: a tile at level n covers four at
 * level n - 1. */
#include <math.h>
#include <stdlib.h>

#include "numbers.h"
#include "pyramid.h"
#include "renderer.h"

/* A tile at the edge of a level may be filled only in part. */
static int tiles_of(int pixels, int level)
{
    int side = RND_TILE << level;

    return (pixels + side - 1) / side;
}

bool dmn_pyramid_init(struct dmn_pyramid *pyramid, int width, int height, int levels)
{
    *pyramid = (struct dmn_pyramid){.levels = levels};
    if (levels < 1 || levels > DMN_MAX_LEVELS) return false;
    for (int i = 0; i < levels; i++) {
        struct dmn_level *level = &pyramid->level[i];

        level->columns = tiles_of(width, i);
        level->rows = tiles_of(height, i);
        level->first = pyramid->count;
        pyramid->count += (size_t)level->columns * level->rows;
    }
    pyramid->tile = calloc(pyramid->count, sizeof(*pyramid->tile));
    pyramid->centre = calloc(pyramid->count, sizeof(*pyramid->centre));
    pyramid->stale = calloc(pyramid->count, sizeof(*pyramid->stale));
    if (!pyramid->tile || !pyramid->centre || !pyramid->stale) {
        dmn_pyramid_finish(pyramid);
        return false;
    }
    for (int i = 0; i < levels; i++) {
        const struct dmn_level *level = &pyramid->level[i];
        float side = (float)(RND_TILE << i);

        for (int y = 0; y < level->rows; y++)
            for (int x = 0; x < level->columns; x++)
                rnd_direction(((x + 0.5f) * side / width * 2 - 1) * (float)M_PI,
                              (0.5f - fminf((y + 0.5f) * side / height, 1)) * (float)M_PI,
                              pyramid->centre[level->first + (size_t)y * level->columns + x]);
    }
    return true;
}

void dmn_pyramid_finish(struct dmn_pyramid *pyramid)
{
    free(pyramid->tile);
    free(pyramid->centre);
    free(pyramid->stale);
    *pyramid = (struct dmn_pyramid){0};
}

static bool same(const struct dmn_tile *a, const struct dmn_tile *b)
{
    return a->samples == b->samples && a->converged == b->converged && a->settled == b->settled &&
           a->error == b->error;
}

/* The sum of the tiles that it covers one level finer. */
static struct dmn_tile sum_of(const struct dmn_pyramid *pyramid, int level, int x, int y)
{
    struct dmn_tile sum = {.converged = true, .settled = true};

    for (int child = 0; child < 4; child++) {
        const struct dmn_tile *in;
        int column = x, row = y;

        if (!dmn_pyramid_child(pyramid, level, &column, &row, child)) continue;
        in = &pyramid->tile[dmn_pyramid_index(pyramid, level - 1, column, row)];
        sum.samples += in->samples;
        sum.converged &= in->converged;
        sum.settled &= in->settled;
        sum.error = fmaxf(sum.error, in->error);
    }
    return sum;
}

/* Mark the tile that covers (x, y) one level coarser: its sums must be made anew. */
static void mark_parent(struct dmn_pyramid *pyramid, int level, int x, int y)
{
    if (level + 1 < pyramid->levels)
        pyramid->stale[dmn_pyramid_index(pyramid, level + 1, x / 2, y / 2)] = true;
}

void dmn_pyramid_set(struct dmn_pyramid *pyramid, size_t index, const struct dmn_tile *tile)
{
    int columns = pyramid->level[0].columns;

    if (same(&pyramid->tile[index], tile)) return;
    pyramid->tile[index] = *tile;
    mark_parent(pyramid, 0, (int)index % columns, (int)index / columns);
}

void dmn_pyramid_update(struct dmn_pyramid *pyramid)
{
    for (int l = 1; l < pyramid->levels; l++)
        for (int y = 0; y < pyramid->level[l].rows; y++)
            for (int x = 0; x < pyramid->level[l].columns; x++) {
                size_t index = dmn_pyramid_index(pyramid, l, x, y);

                if (!pyramid->stale[index]) continue;
                pyramid->stale[index] = false;
                pyramid->tile[index] = sum_of(pyramid, l, x, y);
                mark_parent(pyramid, l, x, y);
            }
}

float dmn_pyramid_eccentricity(const struct dmn_pyramid *pyramid, int level, size_t index,
                               const float gaze[3])
{
    const float *centre = pyramid->centre[index];
    float cosine = centre[0] * gaze[0] + centre[1] * gaze[1] + centre[2] * gaze[2];
    float radius = (float)(M_SQRT1_2 * M_PI) / pyramid->level[level].rows;

    return fmaxf(0, acosf(fmaxf(-1, fminf(1, cosine))) - radius);
}

int dmn_pyramid_finest(const struct dmn_pyramid *pyramid, uint32_t widest)
{
    uint32_t width = (uint32_t)(pyramid->level[0].columns * RND_TILE);
    int level = 0;

    while (widest && level < pyramid->levels - 1 && width >> level > widest) level++;
    return level;
}

float dmn_pyramid_density(const struct dmn_pyramid *pyramid)
{
    return (float)(pyramid->level[0].columns * RND_TILE) / 360.0f;
}

size_t dmn_pyramid_at(const struct dmn_pyramid *pyramid, const float gaze[3])
{
    const struct dmn_level *level = &pyramid->level[0];
    double yaw_deg, pitch_deg;
    int x, y;

    dmn_angles(gaze, &yaw_deg, &pitch_deg);
    x = (int)((0.5 + yaw_deg / 360) * level->columns);
    y = (int)((0.5 - pitch_deg / 180) * level->rows);

    if (x >= level->columns) x = 0; /* the seam */
    if (y >= level->rows) y = level->rows - 1;
    return (size_t)y * level->columns + x;
}
