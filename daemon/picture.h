/* picture: what is known of the picture that is rendered: its scene and generation, and how far each tile is,
 * for which gaze. For the loop's thread alone. */
#ifndef FOVEAD_DAEMON_PICTURE_H
#define FOVEAD_DAEMON_PICTURE_H

#include "pyramid.h"
#include "renderer.h"

/* What clients are told of the scene. */
struct dmn_scene_words {
    char line[1024];
    char refused[RND_ERROR_SIZE]; /* why the last edit was not taken; "": it was */
};

struct dmn_picture {
    struct dmn_scene_words scene;
    struct dmn_pyramid pyramid;
    uint64_t version;                     /* number of updates of the pyramid */
    uint64_t generation;                  /* of the pyramid; 0 before the first update */
    uint32_t tiles;                       /* of level 0; of them: */
    uint32_t visited, converged, settled; /* with more paths than the outline's; converged; settled for the
                                             gaze */
    float direction[3];                   /* of that gaze: unit, world */
    uint64_t gaze_sequence;               /* of the newest gaze that has paths in the tile where it looks */

    struct rnd_render *render; /* the rest is for picture.c alone */
    struct rnd_tile *known;    /* the tiles of level 0 as they were at the last update */
    uint32_t *changed;         /* room for the places of all of them */
    size_t outdated, part;     /* number of tiles that were last judged for another gaze, and the first of
                                  them */
};

/* The render must outlive the picture. False if memory is short. A picture that is all zero may be finished.
 */
bool dmn_picture_init(struct dmn_picture *picture, struct rnd_render *render, int width, int height);
void dmn_picture_finish(struct dmn_picture *picture);

/* Update the pyramid: tiles that have changed at once, and the others, if the gaze (unit, world) has moved,
 * in several updates. whole: all tiles now. */
void dmn_picture_update(struct dmn_picture *picture, const float gaze[3], bool whole);

#endif
