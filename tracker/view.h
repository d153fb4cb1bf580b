/* view: points of a screen as directions, and back. What others may ask is in tracker.h:
 * trk_view_direction().
 *
 * Gaze at a screen is filtered and classified as seen from a desk: in degrees that the eye turns, before a
 * screen that stands still. Only its result goes through the view, so that a turn of the view is no movement
 * of the eye. The desk is a usual one, whatever the tracker knows of its own: 0.52 x 0.2925 m at 0.65 m. */
#ifndef FOVEAD_TRACKER_VIEW_H
#define FOVEAD_TRACKER_VIEW_H

#include "tracker.h"

/* The direction (unit) of a point (shares of the screen, from its top left corner) from the desk, and back.
 * A direction that does not meet the screen's plane has a point far off. */
void trk_desk_direction(const float point[2], float out_direction[3]);
void trk_desk_point(const float direction[3], float out_point[2]);

/* As trk_view_direction(), for a point beside the view that of the nearest one in it. */
void trk_view_nearest(const struct trk_view *view, const float point[2], float out_world[3]);

/* Does the view show that point of the screen? */
bool trk_view_shows(const struct trk_view *view, const float point[2]);

/* The point at which the view shows a direction (unit, world). False if it does not show it. */
bool trk_view_point(const struct trk_view *view, const float world[3], float out_point[2]);

#endif
