/* gaze: the gaze of one sample. Which eyes are to be believed, and where do they look together? What others
 * may ask is in tracker.h: trk_gaze_direction(), trk_world_direction(). */
#ifndef FOVEAD_TRACKER_GAZE_H
#define FOVEAD_TRACKER_GAZE_H

#include "tracker.h"

/* Fill in the combined direction and origin where the sample has none: the mean of the eyes that are valid,
 * or that of one eye. True if the direction is the mean of two. */
bool trk_combine(struct trk_sample *sample);

/* Turn a direction in the head by the sample's head pose, if it has one. */
void trk_to_world(const struct trk_sample *sample, const float head[3], float out_world[3]);

/* Are all lids that the sample tells of less than half open? An eye that is seen, and whose openness is
 * unknown, is open. *out_known: does the sample tell the openness of any eye? */
bool trk_lids_closed(const struct trk_sample *sample, bool *out_known);

#endif
