/* paint: the thread that adds batch after batch of paths to the film. Between two of them it takes up what
 * has come meanwhile: another position of the camera, another scene, textures of the one that it has. Each
 * begins a new generation. */
#ifndef FOVEAD_DAEMON_PAINT_H
#define FOVEAD_DAEMON_PAINT_H

#include "gaze.h"

struct dmn_painter;

struct dmn_painter_options {
    struct rnd_render *render; /* these two must outlive the painter */
    struct dmn_gaze *gaze;
    struct rnd_scene *scene; /* of the render */
    uint64_t pixels;         /* of the film */
    uint32_t tiles;          /* of its finest level */
    struct dmn_until until;
    bool virtual_clock;
    int threads;                     /* of the render */
    double batch_seconds;            /* aimed at with the real clock, where nothing else computes */
    void (*wake)(void *context);     /* called after every batch, from the painter's thread */
    void (*warn)(const char *lines); /* of textures that came late; from the painter's thread */
    void *context;
};

/* How much of the picture is done: in the present generation, but for batches, which are of all. */
struct dmn_work {
    uint64_t generation; /* from 1 */
    uint64_t asked;      /* the newest one asked for: generation, or the next */
    double camera[3];    /* its position, m */
    uint64_t paths, rays, batches, not_finite;
    double seconds;                              /* since it began; until painting ended, if it has */
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

/* Move the camera to a position (m), or with relative by so much from where it is or was told to go. Any
 * thread may ask; of several moves before the next batch the newest wins. Returns the generation that this
 * begins, and the camera's position in it; 0 if there can be no camera. */
uint64_t dmn_painter_move(struct dmn_painter *painter, const double position[3], bool relative,
                          double out_position[3]);
/* Has the camera been moved so? Then where to. */
bool dmn_painter_moved(struct dmn_painter *painter, double out_position[3]);
/* Go on with another scene, and unless the camera has been moved with that scene's camera. Waits until the
 * scene is in use. One thread at a time. Returns the scene that is not in use any more: the former one, or if
 * painting has ended the new one. */
struct rnd_scene *dmn_painter_replace(struct dmn_painter *painter, struct rnd_scene *scene);

/* Finish the batch under way and end the thread. */
void dmn_painter_stop(struct dmn_painter *painter);
void dmn_painter_destroy(struct dmn_painter *painter); /* accepts NULL; stops */

#endif
