/* gaze: the gaze source that is in use, and the aim that follows from its samples.
 *
 * It reads the source, lets the tracker's attention decide what to aim at after each sample and each silence,
 * keeps the latest decisions for clients, and records the samples if somebody asks for that. Any thread may
 * call any function. Only one thread reads the source: that of dmn_gaze_start(), or with the virtual clock
 * the caller of dmn_gaze_advance(). dmn_gaze_record() and dmn_gaze_recentre() wait for the disk. */
#ifndef FOVEAD_DAEMON_GAZE_H
#define FOVEAD_DAEMON_GAZE_H

#include "daemon.h"
#include "recording.h"
#include "options.h"

struct dmn_gaze;

/* What a client is told after each sample, and after each decision that followed from silence. */
struct dmn_gaze_sample {
    uint64_t sequence, device_ns, sensor_ns, arrival_ns;
    float direction[3]; /* the gaze: unit, world; the last valid one if this sample has none */
    float head[4];      /* orientation, head to world */
    bool valid, has_head, frozen;
    struct trk_aim decision;
};

struct dmn_gaze_status {
    uint64_t samples, valid;
    float direction[3]; /* of the aim; forward before the first valid sample */
    bool frozen, ended;
    struct trk_status source;
    char recording[DMN_TEXT_SIZE];        /* the file; "": none */
    uint64_t recorded;                    /* samples in it */
    uint64_t lost;                        /* samples that are missing from it */
    bool recording_fails;                 /* the newest samples wait to be written */
    char recording_error[TRK_ERROR_SIZE]; /* why the last failed write failed; "": none has */
};

/* options->gaze may be NULL: the aim then stays forward. NULL and a line in out_error on failure. */
struct dmn_gaze *dmn_gaze_open(const struct dmn_options *options, char out_error[TRK_ERROR_SIZE]);
void dmn_gaze_close(struct dmn_gaze *gaze); /* accepts NULL; after dmn_gaze_stop() */

/* Read the source in a thread of its own, which calls wake(context) after each sample and decision. */
bool dmn_gaze_start(struct dmn_gaze *gaze, void (*wake)(void *context), void *context);
void dmn_gaze_stop(struct dmn_gaze *gaze);
/* With the virtual clock: take every sample up to now_ns. */
void dmn_gaze_advance(struct dmn_gaze *gaze, uint64_t now_ns);

/* The aim for the painter's next batch. Its sequence and time are those of the newest sample that it answers.
 * It becomes stale when the gaze leaves it. Valid as long as the gaze. */
void dmn_gaze_aim(struct dmn_gaze *gaze, struct rnd_aim *out_aim);
void dmn_gaze_status(struct dmn_gaze *gaze, struct dmn_gaze_status *out_status);

/* Take the oldest kept sample after number *cursor (numbers count from 1), and move the cursor to it. Cursor
 * 0 starts with the newest. False if there is none. */
bool dmn_gaze_next(struct dmn_gaze *gaze, uint64_t *cursor, struct dmn_gaze_sample *out_sample);
/* Is there a sample for dmn_gaze_next()? */
bool dmn_gaze_has_next(struct dmn_gaze *gaze, uint64_t cursor);

void dmn_gaze_freeze(struct dmn_gaze *gaze, bool frozen);
/* Pass a gaze direction of a client to the source. Only the pointer takes it. */
void dmn_gaze_push(struct dmn_gaze *gaze, const float direction[3]);
/* The view of the client that steers; NULL: none does. It is the viewport, in place of that of head or gaze,
 * and gaze at a screen goes through it. is_head: its orientation is a head pose, which is also that of an eye
 * tracker in a headset that tells none. Not for the virtual clock. */
void dmn_gaze_view(struct dmn_gaze *gaze, const struct trk_view *view_or_null, bool is_head);

/* The eyes look at target now (unit, world; NULL: the view's centre): turn all gaze accordingly. The rotation
 * of an eye tracker is kept for the next start. out_text says what was done, or why not. */
bool dmn_gaze_recentre(struct dmn_gaze *gaze, const float *target_or_null, char out_text[DMN_TEXT_SIZE]);

/* Record samples to a file from now on; path NULL: end the recording. One thread at a time. out_text says
 * what was done, or why not. */
bool dmn_gaze_record(struct dmn_gaze *gaze, const char *path_or_null, bool replace,
                     char out_text[DMN_TEXT_SIZE]);

#endif
