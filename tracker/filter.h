/* filter: the one-euro filter on the sphere. Its output is still while gaze is still, and quick when gaze
 * moves.
 *
 * Casiez, Roussel and Vogel 2012, "1 Euro Filter": a low-pass whose cut-off rises with speed. Here it steps
 * along the arc from the filtered to the measured direction, in the tangent plane, so that it is the same at
 * poles and seams. It is for fixations and pursuits; after a saccade it starts anew. */
#ifndef FOVEAD_TRACKER_FILTER_H
#define FOVEAD_TRACKER_FILTER_H

struct trk_filter {
    unsigned count;          /* samples since the last reset; 0: none yet */
    float raw[3];            /* the last measured direction */
    float value[3];          /* the filtered direction, unit */
    float velocity_deg_s[3]; /* low-passed; a tangent vector */
};

/* Move filter->value towards a measured direction (unit), dt_s after the last one. The first direction after
 * a reset is taken unchanged, whatever dt_s is. The next ones weigh at least as much as in a plain mean, so
 * that the noise of the first is soon forgotten. */
void trk_filter_step(struct trk_filter *filter, const float direction[3], double dt_s);

void trk_filter_reset(struct trk_filter *filter);

#endif
