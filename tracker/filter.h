/* The one-euro filter on the sphere: still while gaze is still, quick when it moves.
 *
 * Casiez, Roussel and Vogel 2012, "1 Euro Filter": a low-pass whose cut-off rises with speed. Here its step
 * goes along the arc from the filtered to the measured direction, in the tangent plane, so that it is the
 * same at the poles and across any seam. It is for fixation and pursuit: a saccade begins it anew.
 */
#ifndef FOVEAD_TRACKER_FILTER_H
#define FOVEAD_TRACKER_FILTER_H

struct trk_filter {
    unsigned count;          /* samples since it began; 0: nothing yet */
    float raw[3];            /* the last measured direction */
    float value[3];          /* the filtered direction, unit */
    float velocity_deg_s[3]; /* low-passed: a tangent vector */
};

/* Take a measured direction (unit), dt_s after the last one, and move filter->value. The first one after a
 * reset is taken as it is, and dt_s not looked at; the next ones weigh at least as much as in a plain mean,
 * so that the noise of the first is soon forgotten. */
void trk_filter_step(struct trk_filter *filter, const float direction[3], double dt_s);

void trk_filter_reset(struct trk_filter *filter);

#endif
