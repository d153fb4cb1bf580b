/* events: classifies what the eye does as fixation, saccade or pursuit. One classifier serves the live stream
 * and recorded logs.
 *
 * It is based on velocity, with hysteresis (I-VT: Salvucci and Goldberg 2000). In a saccade the eye turns
 * quickly in its socket, and gaze moves quickly in the world, so the lower of the two speeds decides. An eye
 * that holds its target while the head turns (vestibulo-ocular reflex) is quick in the head but still in the
 * world: it fixates. An eye that the head carries along is still in the head, so it makes no saccade either.
 * Speeds are differences of means over a few samples. The thresholds rise with the noise that the classifier
 * measures while the eye is still. */
#ifndef FOVEAD_TRACKER_EVENTS_H
#define FOVEAD_TRACKER_EVENTS_H

#include "tracker.h"

enum { TRK_PAST = 128 }; /* samples that are kept: 128 ms at 1 kHz */

struct trk_past {
    uint64_t time_ns;
    float head[3], world[3]; /* gaze direction in the head and in the world, unit */
};

/* The caller of trk_classify() may read every field. */
struct trk_classifier {
    struct trk_past past[TRK_PAST]; /* sample number n is at index n % TRK_PAST */
    uint64_t count;                 /* valid samples since the last new start */
    uint64_t interval_ns;           /* usual time between them */

    enum trk_state state; /* TRK_FIXATION, TRK_SACCADE or TRK_PURSUIT */
    uint64_t since_ns;    /* device time at which the state was entered */
    uint64_t steady_ns;   /* when the slope was last on this state's side of the threshold of pursuit */
    double noise_deg;     /* measured standard deviation of each axis */
    uint64_t noises_seen; /* how often it was measured */

    float from[3];    /* where the last saccade began: unit, world */
    float peak_deg_s; /* highest speed of the last saccade so far */
};

void trk_classifier_init(struct trk_classifier *classifier);

/* Classify the gaze of one sample at time_ns (device time, later than the last sample's): unit directions in
 * the head and in the world, which are equal without a head pose. Returns classifier->state. After a gap that
 * is too long to bridge, the classifier starts anew with a fixation, but keeps the noise that it has
 * measured. */
enum trk_state trk_classify(struct trk_classifier *classifier, uint64_t time_ns, const float head[3],
                            const float world[3]);

/* How long the eyes may be unseen without an event; how long a blink may last; and how long before and after
 * a blink the lid disturbs the gaze. Tobii XR Ocumen bridges 75 ms; blinks of one protocol last up to 900 ms;
 * reading times exclude 75 ms before and 150 ms after a blink. */
#define TRK_BRIDGED_NS       UINT64_C(75000000)
#define TRK_LONGEST_BLINK_NS UINT64_C(900000000)
#define TRK_BEFORE_BLINK_NS  UINT64_C(75000000)
#define TRK_AFTER_BLINK_NS   UINT64_C(150000000)

/* A shorter jump is fixational movement or noise. */
#define TRK_LEAST_JUMP_DEG 1.0f
/* Two fixations with only unseen eyes between them are one if they are nearer to each other than this (Tobii
 * XR Ocumen). */
#define TRK_MERGED_DEG 3.0f
/* The shortest fixation (Tobii XR Ocumen). */
#define TRK_LEAST_FIXATION_NS UINT64_C(100000000)

#endif
