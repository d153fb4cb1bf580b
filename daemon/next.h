/* next: which tiles a client is sent next. Pure functions: what is known of tiles in, places out. */
#ifndef FOVEAD_DAEMON_NEXT_H
#define FOVEAD_DAEMON_NEXT_H

#include "pyramid.h"

struct dmn_place {
    int level, x, y;
    size_t index; /* in the pyramid */
    float rank;   /* lower goes first */
};

/* The tiles that a client should be sent next, best first, at most limit of them; returns how many.
 * sent (pyramid->count of them) says what each tile was when it was last sent to this client; samples 0 if
 * never. No tile is finer than the level finest.
 *  1. Tiles of places that have no picture yet, the coarsest level first, so that nothing stays black.
 *  2. The other coarse tiles, of the whole sphere.
 *  3. By distance from the gaze: finer tiles with enough paths per pixel; and tiles that were sent and since
 *     then have half as many paths again (where the eye would not see the difference, four times as many), or
 *     have converged or settled.
 * A tile is not sent again if finer ones hide it, or could replace it at once. */
size_t dmn_next(const struct dmn_pyramid *pyramid, const struct dmn_tile *sent, const float gaze[3],
                int finest, size_t limit, struct dmn_place *out_places);

/* The tile that the client sees at the gaze: the finest that it was sent. False if it has nothing new. */
bool dmn_seen_at(const struct dmn_pyramid *pyramid, const struct dmn_tile *sent, const float gaze[3],
                 int finest, struct dmn_place *out_place);

#endif
