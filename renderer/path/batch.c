/* A batch: positions are drawn around the gaze, their paths traced in waves by all threads, and added to the
 * film.
 *
 * Which paths are traced, and in which order they reach a pixel, depends on the batches alone and not on the
 * threads: waves are cut from the sorted paths, and a tile's paths are added together, first drawn first, by
 * whoever finishes the last wave that has some of them. So the film is the same bit for bit with any number
 * of threads.
 */
#include "path/tape.h"
#include "light/light.h"
#include "path/trace.h"
#include "render.h"
#include "math/sampler.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

enum {
    MAX_THREADS = 1024,
    PARTS = 4, /* of a wave */
    LATE = 4,  /* waves of a batch, the last ones, that are traced by parts: two by halves, two by quarters */
};

struct rnd_worker {
    struct rnd_tracer *tracer;
    struct rnd_wave_io io;
    uint64_t rays, traced, not_finite, film_ns, processor_ns;
    struct rnd_tape *tape;
    bool played;
    double play_seconds;
} __attribute__((aligned(64))); /* no line of the cache is two threads' */

struct work {
    struct rnd_render *render;
    const struct rnd_aim *aim;
    uint64_t now_ns;
    uint32_t paths, part, waves, step; /* part: paths of a part of a wave */
    _Atomic uint32_t next;             /* turn that no thread has taken yet */
};

static uint64_t clock_ns(clockid_t clock)
{
    struct timespec t;
    clock_gettime(clock, &t);
    return (uint64_t)t.tv_sec * 1000000000 + (uint64_t)t.tv_nsec;
}

static uint64_t now_ns(void)
{
    return clock_ns(CLOCK_MONOTONIC);
}

/* --- waves --- */

/* Trace paths first to end of the sorted ones. */
static void trace_wave(struct rnd_render *render, struct rnd_worker *worker, uint32_t first, uint32_t end)
{
    const uint32_t count = end - first;
    struct rnd_wave_io *io = &worker->io;
    for (uint32_t i = 0; i < count;) {
        const struct rnd_run *run = &render->run[render->run_of[first + i]];
        const uint32_t across = (uint32_t)render->film.across, left = run->tile % across * RND_TILE,
                       top = run->tile / across * RND_TILE;
        for (const uint32_t last = run->end < end ? run->end : end; first + i < last; i++) {
            const struct rnd_sample *sample = &render->sample[first + i];
            io->x[i] = left + sample->pixel % RND_TILE;
            io->y[i] = top + sample->pixel / RND_TILE;
            io->number[i] = sample->number;
        }
    }
    worker->rays += rnd_trace(worker->tracer, render->eye, render->media, io, count);
    worker->traced += count;
    for (uint32_t i = 0; i < count; i++) {
        const float r = io->radiance[0][i], g = io->radiance[1][i], b = io->radiance[2][i];
        const bool finite = isfinite(r + g + b);
        struct rnd_sample *sample = &render->sample[first + i];
        const struct rnd_film_pixels *pixels =
            &render->film.pixels[render->run[render->run_of[first + i]].tile];
        float *rgb = sample->rgb;
        __builtin_prefetch(&pixels->pixel[sample->pixel], 1);
        worker->not_finite += !finite;
        rgb[0] = finite ? r : 0.0f;
        rgb[1] = finite ? g : 0.0f;
        rgb[2] = finite ? b : 0.0f;
    }
}

/* A part of a wave is done: add to the film the tiles of which it was the last. */
static void finish_part(const struct work *work, struct rnd_worker *worker, uint32_t first, uint32_t end)
{
    struct rnd_render *render = work->render;
    const uint64_t start = now_ns();
    for (uint32_t r = render->run_of[first]; r <= render->run_of[end - 1]; r++) {
        struct rnd_run *run = &render->run[r];
        if (atomic_fetch_sub_explicit(&run->left, 1, memory_order_acq_rel) != 1) continue;
        rnd_film_add(&render->film, &render->film.tile[run->tile], render->sample + run->first,
                     run->end - run->first, work->aim, work->now_ns);
    }
    worker->film_ns += now_ns() - start;
}

/* What is traced in turn k: from part *out_part on so many parts; 0: there is no such turn. The last waves go
 * by halves and then by quarters, so that threads end together. Waves are not taken in the order of the
 * tiles, so that what a stale aim leaves out is not always the lower half of the sphere. */
static uint32_t parts_of(const struct work *work, uint32_t k, uint32_t *out_part)
{
    const uint32_t whole = work->waves > LATE ? work->waves - LATE : 0, halved = whole + LATE / 2;
    uint32_t turn = k, within = 0, parts = PARTS;
    if (k >= whole) {
        const uint32_t late = k - whole, quarters = late - (late < LATE ? late : LATE);
        turn = late < LATE ? whole + late / 2 : halved + quarters / PARTS;
        within = late < LATE ? late % 2 * (PARTS / 2) : quarters % PARTS;
        parts = late < LATE ? PARTS / 2 : 1;
    }
    if (turn >= work->waves) return 0;
    *out_part = PARTS * (uint32_t)((uint64_t)turn * work->step % work->waves) + within;
    return parts;
}

/* Take turns until none is left; once the aim is stale, leave their paths out. */
static void trace(void *context, int index)
{
    struct work *work = context;
    struct rnd_render *render = work->render;
    const uint64_t start = clock_ns(CLOCK_THREAD_CPUTIME_ID);
    for (uint32_t part, parts;;) {
        parts = parts_of(work, atomic_fetch_add_explicit(&work->next, 1, memory_order_relaxed), &part);
        if (parts == 0) break;
        const uint32_t first = part * work->part, last = first + parts * work->part,
                       end = last < work->paths ? last : work->paths;
        if (first >= end) continue;
        const atomic_bool *stale = work->aim->stale;
        if (stale && atomic_load_explicit(stale, memory_order_relaxed))
            for (uint32_t p = first; p < end; p++) render->sample[p].pixel = RND_TILE_PIXELS;
        else
            trace_wave(render, &render->worker[index], first, end);
        for (uint32_t from = first; from < end; from += work->part)
            finish_part(work, &render->worker[index], from,
                        from + work->part < end ? from + work->part : end);
    }
    render->worker[index].processor_ns = clock_ns(CLOCK_THREAD_CPUTIME_ID) - start;
}

static uint32_t divisor(uint32_t a, uint32_t b)
{
    return b == 0 ? a : divisor(b, a % b);
}

/* Cut the paths into waves. */
static void cut(struct work *work)
{
    struct rnd_render *render = work->render;
    /* Small batches have small waves, and a number of them that few threads or many can share. */
    const uint32_t most = work->paths < 32 * RND_WAVE ? RND_WAVE / 2 : RND_WAVE;
    work->waves = (work->paths + most - 1) / most;
    if (work->waves > 2) work->waves = (work->waves + 3) / 4 * 4;
    work->part = (work->paths + PARTS * work->waves - 1) / (PARTS * work->waves);
    work->waves = (work->paths + PARTS * work->part - 1) / (PARTS * work->part);
    /* About the golden section of them apart, and all of them. */
    work->step = (uint32_t)(0.618 * work->waves) | 1u;
    while (divisor(work->step, work->waves) != 1) work->step++;
    for (uint32_t r = 0; r < render->runs; r++) {
        struct rnd_run *run = &render->run[r];
        atomic_init(&run->left, (run->end - 1) / work->part - run->first / work->part + 1);
    }
}

/* --- batches --- */

static bool reserve(struct rnd_render *render, uint32_t paths)
{
    if (paths <= render->capacity) return true;
    const size_t tiles = (size_t)render->film.across * (size_t)render->film.down;
    free(render->pixel);
    free(render->sample);
    free(render->run_of);
    free(render->run);
    render->pixel = malloc(paths * sizeof *render->pixel);
    render->sample = malloc(paths * sizeof *render->sample);
    render->run_of = malloc(paths * sizeof *render->run_of);
    render->run = malloc((tiles < paths ? tiles : paths) * sizeof *render->run);
    const bool ok = render->pixel && render->sample && render->run_of && render->run;
    render->capacity = ok ? paths : 0;
    return ok;
}

/* Until the lights have been surveyed, which the first picture does not wait for. */
static void choose_evenly(struct rnd_render *render)
{
    const struct rnd_lights *lights = &render->scene->lights;
    int many = lights->env ? 2 : 0; /* its regions */
    for (int g = 0; g < RND_LIGHT_GROUPS; g++) many += lights->has[g] + (lights->lamps[g].by_power.count > 1);
    rnd_light_choose_evenly(lights, &render->choice);
    render->surveyed = many < 2;
}

static void survey(struct rnd_render *render)
{
    rnd_survey_lights(render->scene, render->eye, render->pool, &render->choice);
    render->surveyed = true;
}

static void run(struct work *work, bool drawn, struct rnd_batch *out_batch)
{
    struct rnd_render *render = work->render;
    if (drawn && !render->surveyed) survey(render);
    const uint64_t start = now_ns();
    *out_batch = (struct rnd_batch){0};
    if (work->paths == 0 || !reserve(render, work->paths)) return; /* no memory: a batch without a path */
    for (int i = 0; i < render->workers; i++) {
        struct rnd_worker *worker = &render->worker[i];
        worker->rays = worker->traced = worker->not_finite = worker->film_ns = worker->processor_ns = 0;
        rnd_tracer_reset(worker->tracer);
    }
    rnd_place(render, work->aim, work->paths, drawn);
    cut(work);
    out_batch->place_seconds = 1e-9 * (double)(now_ns() - start);
    rnd_pool_run(render->pool, trace, work);

    for (int i = 0; i < render->workers; i++) {
        const struct rnd_worker *worker = &render->worker[i];
        out_batch->paths += worker->traced;
        out_batch->rays += worker->rays;
        out_batch->not_finite += worker->not_finite;
        out_batch->processor_seconds += 1e-9 * (double)worker->processor_ns;
        out_batch->film_seconds += 1e-9 * (double)worker->film_ns;
        rnd_tracer_stages(worker->tracer, out_batch);
    }
    render->film.paths += out_batch->paths;
    if (render->film.paths >= render->film.next_survey) rnd_film_survey(&render->film);
    out_batch->seconds = 1e-9 * (double)(now_ns() - start);
}

void rnd_render_batch(struct rnd_render *render, const struct rnd_aim *aim, uint64_t now_ns, uint32_t paths,
                      struct rnd_batch *out_batch)
{
    struct work work = {.render = render, .aim = aim, .now_ns = now_ns, .paths = paths};
    run(&work, true, out_batch);
}

void rnd_render_outline(struct rnd_render *render, const struct rnd_aim *aim, uint64_t now_ns,
                        struct rnd_batch *out_batch)
{
    const uint32_t cells =
        (uint32_t)(render->film.width / RND_OUTLINE) * (uint32_t)(render->film.height / RND_OUTLINE);
    struct work work = {.render = render, .aim = aim, .now_ns = now_ns, .paths = cells};
    run(&work, false, out_batch);
}

/* --- the same rays again --- */

static void play(void *context, int index)
{
    struct rnd_render *render = context;
    struct rnd_worker *worker = &render->worker[index];
    struct timespec start, end;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &start);
    worker->played = rnd_tape_play(worker->tape, render->scene->tree);
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &end);
    worker->play_seconds = (double)(end.tv_sec - start.tv_sec) + 1e-9 * (double)(end.tv_nsec - start.tv_nsec);
}

void rnd_render_retrace(struct rnd_render *render, const struct rnd_aim *aim, uint32_t paths,
                        struct rnd_batch *out_batch, double *out_seconds)
{
    bool whole = true;
    for (int i = 0; i < render->workers; i++) {
        render->worker[i].tape = rnd_tape_create();
        rnd_tracer_tape(render->worker[i].tracer, render->worker[i].tape);
        whole = whole && render->worker[i].tape;
    }
    rnd_render_batch(render, aim, 0, paths, out_batch);
    if (whole) rnd_pool_run_all(render->pool, play, render);
    *out_seconds = 0.0;
    for (int i = 0; i < render->workers; i++) {
        whole = whole && render->worker[i].played;
        *out_seconds += render->worker[i].play_seconds;
        rnd_tracer_tape(render->worker[i].tracer, NULL);
        rnd_tape_destroy(render->worker[i].tape);
    }
    if (!whole) *out_seconds = -1.0;
}

/* --- life --- */

static void go_to(struct rnd_render *render, const struct rnd_scene *scene, const double eye[3])
{
    for (int k = 0; k < 3; k++) render->eye[k] = (float)(eye[k] - scene->origin[k]);
    render->media = rnd_media_of_eye(scene, render->eye);
}

struct rnd_render *rnd_render_create(const struct rnd_scene *scene, const struct rnd_render_options *options,
                                     char out_error[RND_ERROR_SIZE])
{
    const int width = options->width, height = options->height;
    if (width < 2 * RND_TILE || width > RND_MAX_WIDTH || width % (2 * RND_TILE) != 0 || height * 2 != width) {
        snprintf(out_error, RND_ERROR_SIZE,
                 "film of %d x %d: expected a width that is a multiple of %d, at most %d, and half of it as "
                 "height",
                 width, height, 2 * RND_TILE, RND_MAX_WIDTH);
        return NULL;
    }
    long threads = options->threads > 0 ? options->threads : sysconf(_SC_NPROCESSORS_ONLN);
    threads = threads < 1 ? 1 : threads > MAX_THREADS ? MAX_THREADS : threads;
    struct rnd_render *render = calloc(1, sizeof *render);
    if (!render) goto no_memory;
    pthread_mutex_init(&render->whole, NULL);
    render->scene = scene;
    render->generation = 1;
    go_to(render, scene, scene->info.eye);
    render->distribution = options->distribution;
    render->seed = rnd_hash2((uint32_t)options->seed, (uint32_t)(options->seed >> 32));
    render->workers = (int)threads;
    render->worker = aligned_alloc(64, (size_t)threads * sizeof *render->worker);
    if (render->worker) memset(render->worker, 0, (size_t)threads * sizeof *render->worker);
    render->pool = rnd_pool_create((int)threads);
    const size_t tiles = (size_t)(width / RND_TILE) * (size_t)(height / RND_TILE);
    render->start = malloc((tiles + 1) * sizeof *render->start);
    bool ok = render->worker && render->pool && render->start;
    for (long i = 0; ok && i < threads; i++)
        ok = (render->worker[i].tracer = rnd_tracer_create(scene, &render->choice, options->max_bounces,
                                                           options->firefly, width, render->seed)) != NULL;
    if (ok &&
        rnd_film_init(&render->film, width, height, options->error_bar > 0.0f ? options->error_bar : 0.05f)) {
        choose_evenly(render);
        return render;
    }
no_memory:
    snprintf(out_error, RND_ERROR_SIZE, "film of %d x %d: not enough memory or threads", width, height);
    rnd_render_destroy(render);
    return NULL;
}

void rnd_render_destroy(struct rnd_render *render)
{
    if (!render) return;
    rnd_pool_destroy(render->pool);
    for (int i = 0; render->worker && i < render->workers; i++) rnd_tracer_destroy(render->worker[i].tracer);
    free(render->worker);
    free(render->pixel);
    free(render->sample);
    free(render->run_of);
    free(render->run);
    free(render->start);
    rnd_light_choice_finish(&render->choice);
    rnd_film_finish(&render->film);
    pthread_mutex_destroy(&render->whole);
    free(render);
}

int rnd_render_threads(const struct rnd_render *render)
{
    return render->workers;
}

/* Empty tiles first to end. */
static void empty(void *context, uint32_t first, uint32_t end)
{
    struct rnd_render *render = context;
    for (uint32_t t = first; t < end; t++)
        rnd_film_empty(&render->film, &render->film.tile[t], render->generation);
}

void rnd_render_restart(struct rnd_render *render, const struct rnd_scene *scene, const double eye[3])
{
    render->scene = scene;
    go_to(render, scene, eye);
    for (int i = 0; i < render->workers; i++) rnd_tracer_scene(render->worker[i].tracer, scene);
    choose_evenly(render);
    render->next_cell = 0;
    render->film.brightness = render->film.grain = 0.0f;
    render->film.paths = render->film.next_survey = 0;
    render->generation++;
    pthread_mutex_lock(&render->whole);
    rnd_pool_share(render->pool, (uint32_t)(render->film.across * render->film.down), 64, empty, render);
    pthread_mutex_unlock(&render->whole);
}
