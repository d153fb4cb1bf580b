/* mark: what is drawn over an equirectangular picture where the eye looks. A pure function. */
#ifndef FOVEAD_DAEMON_MARK_H
#define FOVEAD_DAEMON_MARK_H

#include <stdbool.h>
#include <stddef.h>

/* One step of a drawing: move the pen to a point, in pixels from the picture's top left corner. If down is
 * true the move draws a line, else nothing. */
struct dmn_stroke {
    float x, y;
    bool down;
};

enum { DMN_MARK_MOST = 256 };

/* A circle around the gaze (unit, world) of the size of the fovea, and a cross in its middle, as they are
 * on the sphere: the circle gets wide towards the poles, and goes on at the other side of the seam. Returns
 * how many strokes. */
size_t dmn_mark(const float gaze[3], int width, int height, struct dmn_stroke out[DMN_MARK_MOST]);

#endif
