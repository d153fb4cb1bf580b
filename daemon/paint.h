/* paint: the thread that adds batch after batch of paths to the film. Between two batches it takes up a new
 * position of the camera, a new scene, or textures that have been read. Each begins a new generation. */
#ifndef FOVEAD_DAEMON_PAINT_H
#define FOVEAD_DAEMON_PAINT_H

#include "gaze.h"

struct dmn_painter;

struct dmn_painter_options {
    struct rnd_render *render; /* render and gaze must outlive the painter */
    struct dmn_gaze *gaze;
    struct rnd_scene *scene; /* of the render */
    uint64_t pixels;         /* of the film */
    uint32_t tiles;          /* of its finest level */
    struct dmn_until until;
    bool virtual_clock;
    int threads;                     /* of the render */
    double batch_seconds;            /* to aim at, with the real clock and on an idle machine */
    void (*wake)(void *context);     /* called after every batch, from the painter's thread */
    void (*warn)(const char *lines); /* of textures that came late; from the painter's thread */
    void *context;
};

/* How much of the picture is done. All figures are of the present generation, except batches. */
struct dmn_work {
    uint64_t generation; /* from 1 */
    uint64_t asked;      /* the newest generation that was asked for: this one or the next */
    double camera[3];    /* its position, m */
    uint64_t paths, rays, batches, not_finite;
    double seconds;                              /* since the generation began; up to the end of painting,
                                                    if that has come */
    double paths_per_second;                     /* recently */
    double batch_seconds, gaze_to_batch_seconds; /* recent medians; 0: unknown */
    double share;                                /* of what --until asks, 0 to 1 */
    uint64_t now_ns;                             /* the virtual clock; with the real one, CLOCK_MONOTONIC */
    bool done;
};

/* NULL if memory is short or no thread can be made. */
struct dmn_painter *dmn_painter_start(const struct dmn_painter_options *options);
/* Any thread may call this. */
void dmn_painter_work(struct dmn_painter *painter, struct dmn_work *out_work);

/* Move the camera to a position (m), or, if relative, by so much from the position that it has or was given
 * last. Any thread may call this; of several moves before the next batch the newest wins. Returns the
 * generation that begins, with the camera's position in out_position; 0 if that is out of range. */
uint64_t dmn_painter_move(struct dmn_painter *painter, const double position[3], bool relative,
                          double out_position[3]);
/* Has the camera been moved by dmn_painter_move()? If so, out_position is its position. */
bool dmn_painter_moved(struct dmn_painter *painter, double out_position[3]);
/* Go on with another scene, and with its camera unless dmn_painter_move() has moved the camera. Waits until
 * the scene is in use. For one thread at a time. Returns the scene that is no longer in use: the former one,
 * or the new one if painting has ended. */
struct rnd_scene *dmn_painter_replace(struct dmn_painter *painter, struct rnd_scene *scene);

/* Finish the batch under way and end the thread. */
void dmn_painter_stop(struct dmn_painter *painter);
void dmn_painter_destroy(struct dmn_painter *painter); /* stops first; accepts NULL */

#endif
