/* picture: what is known of the picture that is rendered: of which scene and generation it is, how far each
 * of its tiles is, and for which gaze. All of it belongs to the loop's thread. */
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
    uint64_t version;                     /* of the pyramid: counts its updates */
    uint64_t generation;                  /* that the pyramid is about; 0 before the first update */
    uint32_t tiles;                       /* of level 0; of them: */
    uint32_t visited, converged, settled; /* with paths beyond the outline's; good; good for the gaze */
    float direction[3];                   /* of that gaze: unit, world */
    uint64_t gaze_sequence;               /* of the newest gaze that has paths in the tile where it looks */

    struct rnd_render *render; /* the rest is for picture.c alone */
    struct rnd_tile *known;    /* the tiles of level 0 as they were at the last update */
    uint32_t *changed;         /* room for the places of all of them */
    size_t outdated, part;     /* tiles that were last updated for another gaze, the first of them at part */
};

/* The render must outlive the picture. False if memory is short. All zero may be finished. */
bool dmn_picture_init(struct dmn_picture *picture, struct rnd_render *render, int width, int height);
void dmn_picture_finish(struct dmn_picture *picture);

/* Take up what has become of the tiles since the last update: of those that have changed at once; of the
 * others, when the gaze (unit, world) has moved, part by part. whole: of all now. */
void dmn_picture_update(struct dmn_picture *picture, const float gaze[3], bool whole);

#endif
