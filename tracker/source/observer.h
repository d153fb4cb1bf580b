/* observer: a synthetic observer. It models how eyes and head move while a person looks around in a panorama,
 * and what a headset's tracker measures of that. Every number follows from the seed.
 *
 * Fixations follow one another over the sphere, joined by saccades on the main sequence. When a saccade would
 * turn the eye far in its socket, the head moves too, and the eye turns back against it. Drift,
 * microsaccades, blinks, and the tracker's noise, bias and drop-outs are added. */
#ifndef FOVEAD_TRACKER_OBSERVER_H
#define FOVEAD_TRACKER_OBSERVER_H

#include "tracker.h"

enum { TRK_OBSERVER_HZ = 120 };

/* A time in which the tracker sees no eye. */
struct trk_spell {
    double start_s, length_s;
};

struct trk_observer {
    uint64_t random; /* state of the random number generator */
    uint64_t tick;   /* samples so far */
    uint64_t rate_hz;
    double noise_s2s_deg, bias_rms_deg;

    /* Gaze in the world. During a saccade it moves from `fixation` along `tangent` (both unit, at a right
     * angle). */
    bool is_saccade;
    double phase_start_s, phase_end_s; /* of this fixation or saccade */
    float fixation[3], tangent[3];
    double amplitude_deg;
    uint64_t saccade_number; /* so far */
    double offset_deg[2];    /* drift and microsaccades, to the right of and above the fixation */
    double sweep;            /* +1 while exploring to the right, -1 to the left */

    /* Head: yaw to the left and pitch upwards, each as a critically damped second-order system. */
    double head_deg[2], head_speed[2], head_target_deg[2];

    struct trk_spell blink, dropout;
    double bias_deg[2]; /* of the calibration */
    double pupil_mm;
};

void trk_observer_init(struct trk_observer *observer, uint64_t seed);

/* The same with another rate, noise (deg rms from sample to sample in the combined gaze, which is twice the
 * standard deviation of each axis) and calibration bias (deg rms). TRK_OBSERVER_HZ, 0.2 and 0.7 give the same
 * as trk_observer_init(). */
void trk_observer_init_with(struct trk_observer *observer, uint64_t seed, uint64_t rate_hz,
                            double noise_s2s_deg, double bias_rms_deg);

/* What the observer really did at the time of the latest sample. */
struct trk_truth {
    float direction[3];      /* true gaze without noise and bias: unit, world */
    bool is_hidden;          /* the tracker sees no eye */
    bool is_blink;           /* it sees none because the lid is down */
    bool is_saccade;         /* what follows is about this saccade; all 0 without one */
    uint64_t saccade_number; /* counts from 1 */
    double onset_s, end_s;   /* when it first and last exceeds 30 deg/s; s of device time */
    double amplitude_deg;
    float landing[3]; /* unit, world */
};

void trk_observer_truth(const struct trk_observer *observer, struct trk_truth *out_truth);

/* The next sample, of rate_hz per second. arrival_ns is device_ns; sequence counts from 1. */
void trk_observer_next(struct trk_observer *observer, struct trk_sample *out_sample);

/* How far a saccade of this amplitude has moved t seconds after its start, in degrees. This is the closed
 * form of Dai, Selesnick, Rizzo, Rucker and Hudson 2016; its peak velocity is 600 (1 - exp(-amplitude / 6))
 * deg/s. */
double trk_saccade_deg(double amplitude_deg, double t_s);

/* How long a saccade of this amplitude takes, in seconds, including its slow start and end. */
double trk_saccade_s(double amplitude_deg);

#endif
