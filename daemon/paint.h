/* paint: the thread that adds batch after batch of paths to the film. */
#ifndef FOVEAD_DAEMON_PAINT_H
#define FOVEAD_DAEMON_PAINT_H

#include "gaze.h"

struct dmn_painter;

struct dmn_painter_options {
    struct rnd_render *render; /* these two must outlive the painter */
    struct dmn_gaze *gaze;
    uint64_t pixels; /* of the film */
    uint32_t tiles;  /* of its finest level */
    struct dmn_until until;
    bool virtual_clock;
    double batch_seconds;        /* aimed at with the real clock */
    void (*wake)(void *context); /* called after every batch, from the painter's thread */
    void *context;
};

/* How far the picture is. */
struct dmn_work {
    uint64_t paths, rays, batches, not_finite;
    double seconds;                              /* since painting began; until it ended, if it has */
    double paths_per_second;                     /* lately */
    double batch_seconds, gaze_to_batch_seconds; /* medians, lately; 0 before known */
    double share;                                /* of what --until asks, 0 to 1 */
    uint64_t now_ns;                             /* the virtual clock; with the real one, CLOCK_MONOTONIC */
    bool done;
};

/* NULL if memory is short or no thread can be made. */
struct dmn_painter *dmn_painter_start(const struct dmn_painter_options *options);
/* Any thread may ask. */
void dmn_painter_work(struct dmn_painter *painter, struct dmn_work *out_work);
/* Finish the batch under way and end the thread. */
void dmn_painter_stop(struct dmn_painter *painter);
void dmn_painter_destroy(struct dmn_painter *painter); /* accepts NULL; stops */

#endif
