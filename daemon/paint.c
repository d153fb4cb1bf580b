/* The thread that adds batch after batch of paths to the film. */
#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "paint.h"

enum {
    FIRST_PATHS = 2048, /* of the first batch: short on any machine */
    LEAST_PATHS = 256,
    MOST_PATHS = 1 << 20,
    VIRTUAL_PATHS = 4096,
    JUDGE_EVERY = 32, /* batches between two checks whether all tiles have converged */
};
/* On an idle machine a batch takes SLOWER_ALONE times the processor time of each of its threads. On a busy
 * one it may take up to MOST_LONGER times batch_seconds. */
static const double SLOWER_ALONE = 1.3, MOST_LONGER = 8, LEAST_OF_BATCH = 0.5;
static const uint64_t VIRTUAL_STEP_NS = 5000000;
static const uint64_t LATELY_NS = 500000000;

/* Figures of the last half second, gathered by the painter alone. */
struct lately {
    uint64_t since_ns, paths;
    struct dmn_histogram batch, gaze_to_batch;
};

struct dmn_painter {
    struct dmn_painter_options options;
    struct rnd_tile *tiles;
    pthread_t thread;
    bool started;
    atomic_bool stop;
    struct lately lately;
    uint64_t began_ns;
    uint64_t gaze_ns, aimed_ns; /* of the aim: when its gaze arrived, when the first batch with it began */
    uint32_t converged;
    bool reading; /* textures are being read, and the picture lacks them */

    pthread_mutex_t lock; /* of all that follows */
    struct dmn_work work; /* written by the painter's thread alone, which reads it without the lock */
    bool due, moved;      /* a new generation is due; a client has moved the camera */
    double camera[3];     /* its position in the generation that is due, else in the present one */
    struct rnd_scene *next, *former; /* the scene that waits to be used, or NULL; the one that was in use
                                        before */
    pthread_cond_t changed;          /* next is in use, or never will be */
};

/* When the first batch with this aim began; now_ns if this is the first. The latency of gaze is measured
 * there: at later batches it would include how long the eye has rested. */
static uint64_t first_aimed_ns(struct dmn_painter *painter, const struct rnd_aim *aim, uint64_t now_ns)
{
    if (aim->time_ns == painter->gaze_ns && painter->aimed_ns) return painter->aimed_ns;
    if (aim->time_ns && now_ns >= aim->time_ns)
        dmn_histogram_add(&painter->lately.gaze_to_batch, (double)(now_ns - aim->time_ns) * 1e-9);
    painter->gaze_ns = aim->time_ns;
    return painter->aimed_ns = now_ns;
}

static void note_lately(struct dmn_painter *painter, const struct rnd_batch *batch, struct dmn_work *work)
{
    struct lately *lately = &painter->lately;
    uint64_t now_ns = dmn_now_ns(), passed_ns = now_ns - lately->since_ns;

    lately->paths += batch->paths;
    dmn_histogram_add(&lately->batch, batch->seconds);
    if (passed_ns < LATELY_NS) return;
    work->paths_per_second = (double)lately->paths / ((double)passed_ns * 1e-9);
    work->batch_seconds = dmn_histogram_quantile(&lately->batch, 0.5);
    if (lately->gaze_to_batch.count)
        work->gaze_to_batch_seconds = dmn_histogram_quantile(&lately->gaze_to_batch, 0.5);
    memset(lately, 0, sizeof(*lately));
    lately->since_ns = now_ns;
}

static bool gaze_ended(struct dmn_painter *painter)
{
    struct dmn_gaze_status gaze;

    dmn_gaze_status(painter->options.gaze, &gaze);
    return gaze.ended;
}

static void judge(struct dmn_painter *painter)
{
    painter->converged = 0;
    rnd_render_tiles(painter->options.render, painter->tiles);
    for (uint32_t i = 0; i < painter->options.tiles; i++) painter->converged += painter->tiles[i].converged;
}

/* Count a batch. True when the render is done. */
static bool book(struct dmn_painter *painter, const struct rnd_batch *batch, uint64_t now_ns)
{
    const struct dmn_painter_options *options = &painter->options;
    struct dmn_progress progress = {.pixels = options->pixels, .tiles = options->tiles};
    struct dmn_work work = painter->work; /* written by this thread alone */

    work.paths += batch->paths;
    work.rays += batch->rays;
    work.not_finite += batch->not_finite;
    work.batches++;
    work.seconds = (double)(dmn_now_ns() - painter->began_ns) * 1e-9;
    work.now_ns = now_ns;
    note_lately(painter, batch, &work);
    if (options->until.kind == DMN_UNTIL_CONVERGED && work.batches % JUDGE_EVERY == 0) judge(painter);
    progress.paths = work.paths;
    progress.seconds = options->virtual_clock ? (double)now_ns * 1e-9 : work.seconds;
    progress.converged = painter->converged;
    progress.gaze_ended = options->until.kind == DMN_UNTIL_END && gaze_ended(painter);
    work.share = dmn_until_share(&options->until, &progress);
    pthread_mutex_lock(&painter->lock);
    painter->work = work;
    pthread_mutex_unlock(&painter->lock);
    options->wake(options->context);
    return work.share >= 1;
}

/* Processor time that each thread should spend on the next batch. slower is the time that the last batch took
 * over the processor time of each thread. On an idle machine a batch takes batch_seconds. On a busy machine
 * it is longer, since it ends by waiting for its last thread; but not too long, since a moved gaze waits for
 * its end. Below LEAST_OF_BATCH of batch_seconds it would be mostly overhead. */
static double aimed_seconds(const struct dmn_painter_options *options, double slower)
{
    double longer = slower * slower / (SLOWER_ALONE * SLOWER_ALONE);

    return options->batch_seconds * fmax(fmin(fmax(longer, 1), MOST_LONGER) / slower, LEAST_OF_BATCH);
}

/* Paths of the next batch: as many as take about the wanted processor time, and no more than --until still
 * needs. Wall time would not do: beside other work batches would become ever shorter, until they mostly
 * waited for their last thread to run. */
static uint32_t next_paths(const struct dmn_painter *painter, uint32_t paths, const struct rnd_batch *last)
{
    const struct dmn_painter_options *options = &painter->options;

    if (options->virtual_clock)
        paths = VIRTUAL_PATHS;
    else if (last->processor_seconds > 0 && last->paths > 0) {
        double seconds = last->processor_seconds / options->threads;
        /* A batch that was cut short counts with the paths that it traced. */
        double change =
            aimed_seconds(options, last->seconds / seconds) / seconds * (double)last->paths / paths;

        /* Go half of the way, and at most double: one slow batch must not set the pace. */
        change = change > 2 ? 2 : change < 0.5 ? 0.5 : change;
        paths = (uint32_t)(paths * (1 + (change - 1) / 2));
        paths = paths < LEAST_PATHS ? LEAST_PATHS : paths > MOST_PATHS ? MOST_PATHS : paths;
    }
    if (options->until.kind == DMN_UNTIL_PATHS) {
        double left = options->until.amount * (double)options->pixels - (double)painter->work.paths;

        if (left < paths) paths = left < 1 ? 1 : (uint32_t)(left + 0.5);
    }
    return paths;
}

/* Begin a new generation, if one is due. */
static bool restart(struct dmn_painter *painter)
{
    const char *warnings;
    const enum rnd_textures textures = rnd_scene_take_textures(painter->options.scene, &warnings);
    struct dmn_work *work = &painter->work;
    struct rnd_scene *next;
    bool due;

    painter->reading = textures == RND_TEXTURES_READING;
    painter->options.warn(warnings);
    pthread_mutex_lock(&painter->lock);
    due = painter->due || textures == RND_TEXTURES_CAME;
    next = painter->next;
    if (due) {
        painter->due = false;
        work->generation++;
        work->paths = work->rays = work->not_finite = 0;
        work->seconds = work->share = 0;
        memcpy(work->camera, painter->camera, sizeof(work->camera));
    }
    pthread_mutex_unlock(&painter->lock);
    if (!due) return false;
    painter->began_ns = dmn_now_ns();
    painter->converged = 0;
    rnd_render_restart(painter->options.render, next ? next : painter->options.scene, work->camera);
    if (!next) return true;
    pthread_mutex_lock(&painter->lock);
    painter->former = painter->options.scene;
    painter->options.scene = next;
    painter->next = NULL;
    pthread_cond_broadcast(&painter->changed);
    pthread_mutex_unlock(&painter->lock);
    return true;
}

static void *paint(void *argument)
{
    struct dmn_painter *painter = argument;
    const struct dmn_painter_options *options = &painter->options;
    uint64_t virtual_ns = 0;
    uint32_t paths = FIRST_PATHS;
    struct rnd_batch batch = {0};
    bool done = false, first = true;

    painter->began_ns = painter->lately.since_ns = dmn_now_ns();
    for (; !done && !atomic_load(&painter->stop); first = false) {
        struct rnd_aim aim;
        uint64_t aimed_ns;

        first |= restart(painter);
        if (options->virtual_clock) dmn_gaze_advance(options->gaze, virtual_ns);
        dmn_gaze_aim(options->gaze, &aim);
        aimed_ns = first_aimed_ns(painter, &aim, options->virtual_clock ? virtual_ns : dmn_now_ns());
        if (first) {
            rnd_render_outline(options->render, &aim, aimed_ns, &batch);
        } else {
            paths = next_paths(painter, paths, &batch);
            rnd_render_batch(options->render, &aim, aimed_ns, paths, &batch);
            virtual_ns += VIRTUAL_STEP_NS;
        }
        /* A picture that lacks textures never fulfils --until. */
        done = book(painter, &batch, options->virtual_clock ? virtual_ns : dmn_now_ns()) && !painter->reading;
        if (first) batch.processor_seconds = 0; /* it tells nothing about later batches */
    }
    pthread_mutex_lock(&painter->lock);
    painter->work.done = true;
    pthread_cond_broadcast(&painter->changed);
    pthread_mutex_unlock(&painter->lock);
    options->wake(options->context);
    return NULL;
}

struct dmn_painter *dmn_painter_start(const struct dmn_painter_options *options)
{
    struct dmn_painter *painter = calloc(1, sizeof(*painter));

    if (!painter) return NULL;
    painter->options = *options;
    painter->work.generation = 1;
    memcpy(painter->camera, rnd_scene_info(options->scene)->camera, sizeof(painter->camera));
    memcpy(painter->work.camera, painter->camera, sizeof(painter->work.camera));
    pthread_mutex_init(&painter->lock, NULL);
    pthread_cond_init(&painter->changed, NULL);
    painter->tiles = calloc(options->tiles, sizeof(*painter->tiles));
    painter->started = painter->tiles && !pthread_create(&painter->thread, NULL, paint, painter);
    if (!painter->started) {
        dmn_painter_destroy(painter);
        return NULL;
    }
    return painter;
}

void dmn_painter_work(struct dmn_painter *painter, struct dmn_work *out_work)
{
    pthread_mutex_lock(&painter->lock);
    *out_work = painter->work;
    out_work->asked = out_work->generation + painter->due;
    pthread_mutex_unlock(&painter->lock);
    if (!painter->options.virtual_clock) out_work->now_ns = dmn_now_ns();
}

uint64_t dmn_painter_move(struct dmn_painter *painter, const double position[3], bool relative,
                          double out_position[3])
{
    uint64_t generation = 0;

    pthread_mutex_lock(&painter->lock);
    for (int i = 0; i < 3; i++) out_position[i] = position[i] + (relative ? painter->camera[i] : 0);
    if (dmn_camera_is_in_range(out_position)) {
        memcpy(painter->camera, out_position, sizeof(painter->camera));
        painter->due = painter->moved = true;
        generation = painter->work.generation + 1;
    }
    pthread_mutex_unlock(&painter->lock);
    return generation;
}

bool dmn_painter_moved(struct dmn_painter *painter, double out_position[3])
{
    bool moved;

    pthread_mutex_lock(&painter->lock);
    moved = painter->moved;
    memcpy(out_position, painter->camera, sizeof(painter->camera));
    pthread_mutex_unlock(&painter->lock);
    return moved;
}

struct rnd_scene *dmn_painter_replace(struct dmn_painter *painter, struct rnd_scene *scene)
{
    pthread_mutex_lock(&painter->lock);
    painter->next = scene;
    painter->due = true;
    if (!painter->moved) memcpy(painter->camera, rnd_scene_info(scene)->camera, sizeof(painter->camera));
    while (painter->next && !painter->work.done) pthread_cond_wait(&painter->changed, &painter->lock);
    if (!painter->next) scene = painter->former;
    painter->next = NULL;
    pthread_mutex_unlock(&painter->lock);
    return scene;
}

void dmn_painter_stop(struct dmn_painter *painter)
{
    if (!painter->started) return;
    atomic_store(&painter->stop, true);
    pthread_join(painter->thread, NULL);
    painter->started = false;
}

void dmn_painter_destroy(struct dmn_painter *painter)
{
    if (!painter) return;
    dmn_painter_stop(painter);
    free(painter->tiles);
    pthread_cond_destroy(&painter->changed);
    pthread_mutex_destroy(&painter->lock);
    free(painter);
}
