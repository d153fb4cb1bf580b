/* gaze: the gaze of one sample, which is that of the eyes that can be trusted. Its public functions are in
 * tracker.h: trk_gaze_direction() and trk_world_direction(). */
#ifndef FOVEAD_TRACKER_GAZE_H
#define FOVEAD_TRACKER_GAZE_H

#include "tracker.h"

/* If the sample lacks the combined direction or origin, fill it in from the valid eyes: the mean of two, or
 * the value of one. Returns true if the direction is the mean of two. */
bool trk_combine(struct trk_sample *sample);

/* Turn a direction from the head frame to the world by the sample's head pose, if it has one. */
void trk_to_world(const struct trk_sample *sample, const float head[3], float out_world[3]);

/* Are all lids that the sample tells of less than half open? An eye that is seen, and whose openness is
 * unknown, counts as open. *out_known: does the sample tell the openness of an eye? */
bool trk_lids_closed(const struct trk_sample *sample, bool *out_known);

#endif
