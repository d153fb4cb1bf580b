/* The gaze of one sample: which eyes to believe, and where they look together. */
#ifndef FOVEAD_TRACKER_GAZE_H
#define FOVEAD_TRACKER_GAZE_H

#include "tracker.h"

/* The combined gaze and its origin, where the sample has none: the mean of the eyes that are valid; one is
 * enough. True if it is that of two. */
bool trk_combine(struct trk_sample *sample);

/* A direction in the head, by the sample's head pose if it has one. */
void trk_to_world(const struct trk_sample *sample, const float head[3], float out_world[3]);

/* Are the lids, as far as the sample tells, less than half open? An eye that is seen, and of whose lid
 * nothing is told, is open. *out_known is false if the sample does not tell. */
bool trk_lids_closed(const struct trk_sample *sample, bool *out_known);

#endif
