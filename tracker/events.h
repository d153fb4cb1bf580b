/* What the eye is doing: fixation, saccade, pursuit. One classifier serves the live stream and recorded logs.
 *
 * By velocity, with hysteresis (I-VT: Salvucci and Goldberg 2000). A saccade is a quick turn of the eye in
 * its socket that takes gaze in the world along: the lesser of both speeds counts. So an eye that holds its
 * target while the head turns fixates (the vestibulo-ocular reflex: quick in the head, still in the world),
 * and so does one that the head carries along. Speeds are differences of means over a few samples, and
 * thresholds rise with the noise that the classifier measures while the eye is still.
 */
#ifndef FOVEAD_TRACKER_EVENTS_H
#define FOVEAD_TRACKER_EVENTS_H

#include "tracker.h"

enum { TRK_PAST = 128 }; /* samples looked back on: 128 ms at a kilohertz */

struct trk_past {
    uint64_t time_ns;
    float head[3], world[3]; /* gaze direction in the head and in the world, unit */
};

/* All fields are for reading, by trk_classify()'s caller. */
struct trk_classifier {
    struct trk_past past[TRK_PAST]; /* sample number n is at n % TRK_PAST */
    uint64_t count;                 /* valid samples since it began anew */
    uint64_t interval_ns;           /* between them, usually */

    enum trk_state state; /* TRK_FIXATION, TRK_SACCADE or TRK_PURSUIT */
    uint64_t since_ns;    /* device time at which the state was entered */
    uint64_t steady_ns;   /* when the slope was last on the state's side of pursuit's threshold */
    double noise_deg;     /* standard deviation of an axis, measured */
    uint64_t noises_seen; /* how often */

    float from[3];    /* the last saccade: where it set out, unit, world; */
    float peak_deg_s; /* and its peak velocity so far */
};

void trk_classifier_init(struct trk_classifier *classifier);

/* Take the gaze of one sample at time_ns (device time, later than the last one's): unit directions in the
 * head and in the world, the same where there is no head pose. Returns classifier->state. After a gap too
 * long to bridge it begins anew, with a fixation; the noise it has measured is kept. */
enum trk_state trk_classify(struct trk_classifier *classifier, uint64_t time_ns, const float head[3],
                            const float world[3]);

/* How long nothing may be seen and be no event at all, a blink, and how much of what is seen before and after
 * a blink is the lid's doing. Tobii XR Ocumen bridges 75 ms; blinks of one protocol last up to 900 ms;
 * reading times are taken without 75 ms before and 150 ms after. */
#define TRK_BRIDGED_NS       UINT64_C(75000000)
#define TRK_LONGEST_BLINK_NS UINT64_C(900000000)
#define TRK_BEFORE_BLINK_NS  UINT64_C(75000000)
#define TRK_AFTER_BLINK_NS   UINT64_C(150000000)

/* A jump shorter than this is none: fixational movement and noise. */
#define TRK_LEAST_JUMP_DEG 1.0f
/* Fixations nearer to each other than this, with nothing seen in between, are one (Tobii XR Ocumen). */
#define TRK_MERGED_DEG 3.0f
/* The shortest fixation (Tobii XR Ocumen). */
#define TRK_LEAST_FIXATION_NS UINT64_C(100000000)

#endif
