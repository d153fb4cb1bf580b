/* gaze: the newest direction of the gaze, from whatever source, for whoever asks.
 *
 * It holds the last valid direction when the source loses the eye, stays where it was while frozen, and keeps
 * the last second of samples for clients. Any thread may call any function, except that one thread reads the
 * source: dmn_gaze_start()'s own, or with the virtual clock the caller of dmn_gaze_advance(). */
#ifndef FOVEAD_DAEMON_GAZE_H
#define FOVEAD_DAEMON_GAZE_H

#include "daemon.h"
#include "tracker.h"

struct dmn_gaze;

/* What a client is told of one sample. */
struct dmn_gaze_sample {
    uint64_t sequence, device_ns, arrival_ns;
    float direction[3]; /* unit, world; the last valid one if this sample has none */
    float head[4];      /* orientation, head to world */
    bool valid, has_head, frozen;
};

struct dmn_gaze_state {
    uint64_t samples, valid;
    float direction[3]; /* forward before the first valid sample */
    bool frozen, ended;
    const char *source; /* one line */
};

/* options->gaze may be NULL: the aim is then forward for ever. NULL and a line in out_error on failure. */
struct dmn_gaze *dmn_gaze_open(const struct dmn_options *options, char out_error[TRK_ERROR_SIZE]);
void dmn_gaze_close(struct dmn_gaze *gaze); /* accepts NULL; after dmn_gaze_stop() */

/* Read the source in a thread of its own; wake(context) is called after every sample. */
bool dmn_gaze_start(struct dmn_gaze *gaze, void (*wake)(void *context), void *context);
void dmn_gaze_stop(struct dmn_gaze *gaze);
/* The virtual clock: take every sample up to now_ns. */
void dmn_gaze_advance(struct dmn_gaze *gaze, uint64_t now_ns);

void dmn_gaze_aim(struct dmn_gaze *gaze, struct rnd_aim *out_aim);
void dmn_gaze_state(struct dmn_gaze *gaze, struct dmn_gaze_state *out_state);

/* The oldest kept sample after number *cursor (they count from 1), which moves on to it. Cursor 0 starts with
 * the newest. False if there is none. */
bool dmn_gaze_next(struct dmn_gaze *gaze, uint64_t *cursor, struct dmn_gaze_sample *out_sample);
/* Is there one? */
bool dmn_gaze_has_next(struct dmn_gaze *gaze, uint64_t cursor);

void dmn_gaze_freeze(struct dmn_gaze *gaze, bool frozen);
/* A gaze direction from a client, for the pointer source; others take no notice. */
void dmn_gaze_push(struct dmn_gaze *gaze, const float direction[3]);
/* The viewport that a client looks through, instead of head or gaze; NULL: none any more. */
void dmn_gaze_view(struct dmn_gaze *gaze, const float orientation[4], float fov_x, float fov_y);

#endif
