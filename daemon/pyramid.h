/* pyramid: what is known of the film's tiles at every level. */
#ifndef FOVEAD_DAEMON_PYRAMID_H
#define FOVEAD_DAEMON_PYRAMID_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum {
    DMN_MAX_LEVELS = 16,
    DMN_OUTLINE_PATHS = 16, /* paths that rnd_render_outline() leaves in a tile of level 0 */
};

/* What is known of a tile at any level. */
struct dmn_tile {
    uint64_t samples;
    bool converged, settled;
    float error; /* of pixels of level 0, as rnd_tile has it */
};

struct dmn_level {
    int columns, rows;
    size_t first; /* index of its first tile */
};

/* The film's tiles at every level, finest first, row by row. */
struct dmn_pyramid {
    int levels;
    struct dmn_level level[DMN_MAX_LEVELS];
    size_t count;          /* tiles of all levels */
    struct dmn_tile *tile; /* count of them */
    float (*centre)[3];    /* directions of their middles */
    bool *stale;           /* tiles whose sums dmn_pyramid_update() must make anew */
};

/* levels as rnd_render_levels() gives it. False if memory is short. */
bool dmn_pyramid_init(struct dmn_pyramid *pyramid, int width, int height, int levels);
void dmn_pyramid_finish(struct dmn_pyramid *pyramid);
/* Set what is known of tiles of level 0, then sum up the changed ones level by level. */
void dmn_pyramid_set(struct dmn_pyramid *pyramid, size_t index, const struct dmn_tile *tile);
void dmn_pyramid_update(struct dmn_pyramid *pyramid);

/* Angle from the gaze to the nearest point of the circle around a tile, rad. Tiles are squares near the
 * equator and slivers near the poles. */
float dmn_pyramid_eccentricity(const struct dmn_pyramid *pyramid, int level, size_t index,
                               const float gaze[3]);

/* The finest level of at most so many pixels across, or the coarsest level if all are wider. widest 0: any.
 */
int dmn_pyramid_finest(const struct dmn_pyramid *pyramid, uint32_t widest);

/* Pixels of level 0 per degree, at the horizon. */
float dmn_pyramid_density(const struct dmn_pyramid *pyramid);

/* The tile of level 0 that the gaze falls into. */
size_t dmn_pyramid_at(const struct dmn_pyramid *pyramid, const float gaze[3]);

static inline size_t dmn_pyramid_index(const struct dmn_pyramid *pyramid, int level, int x, int y)
{
    return pyramid->level[level].first + (size_t)y * pyramid->level[level].columns + x;
}

/* One of the four tiles that (x, y) covers one level finer; false if it is outside the film. */
static inline bool dmn_pyramid_child(const struct dmn_pyramid *pyramid, int level, int *x, int *y, int child)
{
    *x = 2 * *x + (child & 1);
    *y = 2 * *y + (child >> 1);
    return *x < pyramid->level[level - 1].columns && *y < pyramid->level[level - 1].rows;
}

#endif
