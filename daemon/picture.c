/* What is known of the picture that is rendered. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "picture.h"

/* When the gaze has moved, tiles without new paths are judged in so many parts, one in each update. */
enum { GAZE_PARTS = 16 };

bool dmn_picture_init(struct dmn_picture *picture, struct rnd_render *render, int width, int height)
{
    const struct dmn_level *level = &picture->pyramid.level[0];

    picture->render = render;
    if (!dmn_pyramid_init(&picture->pyramid, width, height, rnd_render_levels(render))) return false;
    picture->tiles = (uint32_t)(level->columns * level->rows);
    picture->known = calloc(picture->tiles, sizeof(*picture->known));
    picture->changed = calloc(picture->tiles, sizeof(*picture->changed));
    return picture->known && picture->changed;
}

void dmn_picture_finish(struct dmn_picture *picture)
{
    dmn_pyramid_finish(&picture->pyramid);
    free(picture->known);
    free(picture->changed);
}

/* If a new generation has begun, count tiles of the former one as empty, and return true. */
static bool drop_former(struct dmn_picture *picture, uint32_t changes)
{
    uint64_t newest = picture->generation;

    for (uint32_t i = 0; i < changes; i++)
        if (picture->known[picture->changed[i]].generation > newest)
            newest = picture->known[picture->changed[i]].generation;
    if (newest == picture->generation) return false;
    picture->generation = newest;
    for (uint32_t i = 0; i < picture->tiles; i++)
        if (picture->known[i].generation != newest)
            picture->known[i] = (struct rnd_tile){
                .unvisited = RND_TILE * RND_TILE, .error = INFINITY, .sure_error = INFINITY};
    return true;
}

/* Update a tile. */
static void take_tile(struct dmn_picture *picture, size_t i)
{
    const struct rnd_tile *known = &picture->known[i];
    int columns = picture->pyramid.level[0].columns;
    struct dmn_tile now = {known->samples, known->converged,
                           rnd_tile_settled(picture->render, known, (int)i % columns, (int)i / columns,
                                            picture->direction),
                           known->error},
                    before = picture->pyramid.tile[i];

    picture->visited += (now.samples > DMN_OUTLINE_PATHS) - (before.samples > DMN_OUTLINE_PATHS);
    picture->converged += now.converged - before.converged;
    picture->settled += now.settled - before.settled;
    dmn_pyramid_set(&picture->pyramid, i, &now);
}

void dmn_picture_update(struct dmn_picture *picture, const float gaze[3], bool whole)
{
    size_t part = picture->tiles / GAZE_PARTS + 1;
    uint32_t changes = rnd_render_published(picture->render, picture->known, picture->changed);

    whole |= drop_former(picture, changes);
    if (memcmp(picture->direction, gaze, sizeof(picture->direction))) picture->outdated = picture->tiles;
    memcpy(picture->direction, gaze, sizeof(picture->direction));
    for (uint32_t i = 0; i < changes; i++) take_tile(picture, picture->changed[i]);
    if (whole || part > picture->outdated) part = whole ? picture->tiles : picture->outdated;
    for (size_t i = 0; i < part; i++) take_tile(picture, (picture->part + i) % picture->tiles);
    picture->part = (picture->part + part) % picture->tiles;
    picture->outdated = whole ? 0 : picture->outdated - part;
    dmn_pyramid_update(&picture->pyramid);
    picture->gaze_sequence = picture->known[dmn_pyramid_at(&picture->pyramid, gaze)].gaze_sequence;
    picture->version++;
}
