/* A batch: positions are drawn around the gaze, their paths traced in waves by all threads, and added to the
 * film.
 *
 * Which paths are traced, and in which order they reach a pixel, depends on the batches alone and not on the
 * threads: waves are cut from the sorted paths, and a tile's paths are added together, first drawn first, by
 * whoever finishes the last wave that has some of them. So the film is the same bit for bit with any number
 * of threads.
 */
#include "path/integrator.h"
#include "path/tape.h"
#include "film/converge.h"
#include "film/film.h"
#include "light/light.h"
#include "math/sampler.h"
#include "path/survey.h"
#include "path/trace.h"
#include "space/camera.h"

#include <stdlib.h>
#include <string.h>
#include <time.h>

enum {
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
} __attribute__((aligned(64))); /* aligned to cache lines, so that no two threads share one */

struct work {
    struct rnd_integrator *integrator;
    const struct rnd_aim *aim;
    uint64_t now_ns;
    uint32_t paths, part, waves, step; /* part: paths of a part of a wave */
    _Atomic uint32_t next;             /* the next turn */
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
static void trace_wave(struct rnd_integrator *integrator, struct rnd_worker *worker, uint32_t first,
                       uint32_t end)
{
    const uint32_t count = end - first;
    struct rnd_wave_io *io = &worker->io;
    for (uint32_t i = 0; i < count;) {
        const struct rnd_run *run = &integrator->places.run[integrator->places.run_of[first + i]];
        const uint32_t across = (uint32_t)integrator->film->across, left = run->tile % across * RND_TILE,
                       top = run->tile / across * RND_TILE;
        for (const uint32_t last = run->end < end ? run->end : end; first + i < last; i++) {
            const struct rnd_sample *sample = &integrator->places.sample[first + i];
            io->x[i] = left + sample->pixel % RND_TILE;
            io->y[i] = top + sample->pixel / RND_TILE;
            io->number[i] = sample->number;
        }
    }
    if (integrator->places.planes)
        io->plane_values = integrator->places.planes + (size_t)first * (size_t)io->planes->channels;
    worker->rays += rnd_trace(worker->tracer, &integrator->camera, integrator->media, io, count);
    worker->traced += count;
    for (uint32_t i = 0; i < count; i++) {
        const float r = io->radiance[0][i], g = io->radiance[1][i], b = io->radiance[2][i];
        const bool finite = isfinite(r + g + b);
        struct rnd_sample *sample = &integrator->places.sample[first + i];
        const struct rnd_film_pixels *pixels =
            &integrator->film->pixels[integrator->places.run[integrator->places.run_of[first + i]].tile];
        float *rgb = sample->rgb;
        __builtin_prefetch(&pixels->pixel[sample->pixel], 1);
        worker->not_finite += !finite;
        rgb[0] = finite ? r : 0.0f;
        rgb[1] = finite ? g : 0.0f;
        rgb[2] = finite ? b : 0.0f;
    }
}

/* A part of a wave is done. Add the tiles to the film whose last paths were in it. */
static void finish_part(const struct work *work, struct rnd_worker *worker, uint32_t first, uint32_t end)
{
    struct rnd_integrator *integrator = work->integrator;
    const uint64_t start = now_ns();
    for (uint32_t r = integrator->places.run_of[first]; r <= integrator->places.run_of[end - 1]; r++) {
        struct rnd_run *run = &integrator->places.run[r];
        if (atomic_fetch_sub_explicit(&run->left, 1, memory_order_acq_rel) != 1) continue;
        const struct rnd_film *film = integrator->film;
        const float *planes = integrator->places.planes;
        if (planes) planes += (size_t)run->first * (size_t)film->planes.channels;
        rnd_film_add(film, &film->tile[run->tile], integrator->places.sample + run->first, planes,
                     run->end - run->first, work->aim, work->now_ns);
    }
    worker->film_ns += now_ns() - start;
}

/* The k-th turn: part *out_part of so many parts of a wave; 0: there is no such turn. The last waves are
 * traced by halves and quarters, so that all threads end at about the same time. Waves are not taken in the
 * order of the tiles: what is left out after the aim has become stale then lies all over the sphere. */
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
    struct rnd_integrator *integrator = work->integrator;
    const uint64_t start = clock_ns(CLOCK_THREAD_CPUTIME_ID);
    for (uint32_t part, parts;;) {
        parts = parts_of(work, atomic_fetch_add_explicit(&work->next, 1, memory_order_relaxed), &part);
        if (parts == 0) break;
        const uint32_t first = part * work->part, last = first + parts * work->part,
                       end = last < work->paths ? last : work->paths;
        if (first >= end) continue;
        const atomic_bool *stale = work->aim->stale;
        if (stale && atomic_load_explicit(stale, memory_order_relaxed))
            for (uint32_t p = first; p < end; p++) integrator->places.sample[p].pixel = RND_TILE_PIXELS;
        else
            trace_wave(integrator, &integrator->worker[index], first, end);
        for (uint32_t from = first; from < end; from += work->part)
            finish_part(work, &integrator->worker[index], from,
                        from + work->part < end ? from + work->part : end);
    }
    integrator->worker[index].processor_ns = clock_ns(CLOCK_THREAD_CPUTIME_ID) - start;
}

static uint32_t divisor(uint32_t a, uint32_t b)
{
    return b == 0 ? a : divisor(b, a % b);
}

/* Cut the paths into waves. */
static void cut(struct work *work)
{
    struct rnd_integrator *integrator = work->integrator;
    /* Small batches have small waves, in a number that few or many threads can share evenly. */
    const uint32_t most = work->paths < 32 * RND_WAVE ? RND_WAVE / 2 : RND_WAVE;
    work->waves = (work->paths + most - 1) / most;
    if (work->waves > 2) work->waves = (work->waves + 3) / 4 * 4;
    work->part = (work->paths + PARTS * work->waves - 1) / (PARTS * work->waves);
    work->waves = (work->paths + PARTS * work->part - 1) / (PARTS * work->part);
    /* A step of about the golden section that has no common divisor with the number of waves. */
    work->step = (uint32_t)(0.618 * work->waves) | 1u;
    while (divisor(work->step, work->waves) != 1) work->step++;
    for (uint32_t r = 0; r < integrator->places.runs; r++) {
        struct rnd_run *run = &integrator->places.run[r];
        atomic_init(&run->left, (run->end - 1) / work->part - run->first / work->part + 1);
    }
}

/* --- batches --- */

/* Without the survey, which the first picture does not wait for. */
static void choose_evenly(struct rnd_integrator *integrator)
{
    const struct rnd_lights *lights = &integrator->scene->lights;
    int many = lights->env ? 2 : 0; /* its regions */
    for (int g = 0; g < RND_LIGHT_GROUPS; g++)
        many += lights->has[g] + (lights->emitters[g].by_power.count > 1);
    rnd_light_choose_evenly(lights, &integrator->choice);
    integrator->surveyed = many < 2;
}

static void survey(struct rnd_integrator *integrator)
{
    rnd_survey_lights(integrator->scene, &integrator->camera, integrator->pool, &integrator->choice);
    integrator->surveyed = true;
}

static void run(struct work *work, bool drawn, struct rnd_batch *out_batch)
{
    struct rnd_integrator *integrator = work->integrator;
    if (drawn && !integrator->surveyed) survey(integrator);
    const uint64_t start = now_ns();
    *out_batch = (struct rnd_batch){0};
    if (work->paths == 0 || !rnd_places_reserve(&integrator->places, work->paths))
        return; /* memory is short: a batch without paths */
    for (int i = 0; i < integrator->workers; i++) {
        struct rnd_worker *worker = &integrator->worker[i];
        worker->rays = worker->traced = worker->not_finite = worker->film_ns = worker->processor_ns = 0;
        rnd_tracer_reset(worker->tracer);
    }
    if (drawn)
        rnd_places_draw(&integrator->places, integrator->pool, work->aim, work->paths);
    else
        rnd_places_outline(&integrator->places, work->paths);
    cut(work);
    out_batch->place_seconds = 1e-9 * (double)(now_ns() - start);
    rnd_pool_run(integrator->pool, trace, work);

    for (int i = 0; i < integrator->workers; i++) {
        const struct rnd_worker *worker = &integrator->worker[i];
        out_batch->paths += worker->traced;
        out_batch->rays += worker->rays;
        out_batch->not_finite += worker->not_finite;
        out_batch->processor_seconds += 1e-9 * (double)worker->processor_ns;
        out_batch->film_seconds += 1e-9 * (double)worker->film_ns;
        rnd_tracer_stages(worker->tracer, out_batch);
    }
    integrator->film->paths += out_batch->paths;
    if (integrator->film->paths >= integrator->film->next_survey) rnd_film_survey(integrator->film);
    out_batch->seconds = 1e-9 * (double)(now_ns() - start);
}

void rnd_integrate(struct rnd_integrator *integrator, const struct rnd_aim *aim, uint64_t now_ns,
                   uint32_t paths, struct rnd_batch *out_batch)
{
    struct work work = {.integrator = integrator, .aim = aim, .now_ns = now_ns, .paths = paths};
    run(&work, true, out_batch);
}

void rnd_integrate_outline(struct rnd_integrator *integrator, const struct rnd_aim *aim, uint64_t now_ns,
                           struct rnd_batch *out_batch)
{
    struct work work = {.integrator = integrator,
                        .aim = aim,
                        .now_ns = now_ns,
                        .paths = rnd_places_of_outline(integrator->film)};
    run(&work, false, out_batch);
}

/* --- the same rays again --- */

static void play(void *context, int index)
{
    struct rnd_integrator *integrator = context;
    struct rnd_worker *worker = &integrator->worker[index];
    struct timespec start, end;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &start);
    worker->played = rnd_tape_play(worker->tape, integrator->scene->tree);
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &end);
    worker->play_seconds = (double)(end.tv_sec - start.tv_sec) + 1e-9 * (double)(end.tv_nsec - start.tv_nsec);
}

void rnd_integrate_twice(struct rnd_integrator *integrator, const struct rnd_aim *aim, uint32_t paths,
                         struct rnd_batch *out_batch, double *out_seconds)
{
    bool whole = true;
    for (int i = 0; i < integrator->workers; i++) {
        integrator->worker[i].tape = rnd_tape_create();
        rnd_tracer_tape(integrator->worker[i].tracer, integrator->worker[i].tape);
        whole = whole && integrator->worker[i].tape;
    }
    rnd_integrate(integrator, aim, 0, paths, out_batch);
    if (whole) rnd_pool_run_all(integrator->pool, play, integrator);
    *out_seconds = 0.0;
    for (int i = 0; i < integrator->workers; i++) {
        whole = whole && integrator->worker[i].played;
        *out_seconds += integrator->worker[i].play_seconds;
        rnd_tracer_tape(integrator->worker[i].tracer, NULL);
        rnd_tape_destroy(integrator->worker[i].tape);
    }
    if (!whole) *out_seconds = -1.0;
}

/* --- life --- */

static void go_to(struct rnd_integrator *integrator, const struct rnd_scene *scene,
                  const struct rnd_camera *camera)
{
    integrator->scene = scene;
    integrator->camera = *camera;
    integrator->media = rnd_media_at(scene, integrator->camera.position);
    choose_evenly(integrator);
}

bool rnd_integrator_init(struct rnd_integrator *integrator, const struct rnd_scene *scene,
                         const struct rnd_camera *camera, struct rnd_film *film,
                         const struct rnd_render_options *options)
{
    const size_t workers = (size_t)options->threads;
    *integrator = (struct rnd_integrator){.film = film, .workers = options->threads};
    const uint32_t seed = rnd_hash2((uint32_t)options->seed, (uint32_t)(options->seed >> 32));
    integrator->worker = aligned_alloc(64, workers * sizeof *integrator->worker);
    if (integrator->worker) memset(integrator->worker, 0, workers * sizeof *integrator->worker);
    integrator->pool = rnd_pool_create(options->threads);
    bool ok = rnd_places_init(&integrator->places, film, options->distribution, seed) && integrator->worker &&
              integrator->pool;
    for (size_t i = 0; ok && i < workers; i++) {
        integrator->worker[i].io.planes = &film->planes;
        ok = (integrator->worker[i].tracer =
                  rnd_tracer_create(scene, &integrator->choice, options->max_bounces, options->firefly,
                                    film->width, seed)) != NULL;
    }
    if (ok) go_to(integrator, scene, camera);
    return ok;
}

void rnd_integrator_finish(struct rnd_integrator *integrator)
{
    rnd_pool_destroy(integrator->pool);
    for (int i = 0; integrator->worker && i < integrator->workers; i++)
        rnd_tracer_destroy(integrator->worker[i].tracer);
    free(integrator->worker);
    rnd_places_finish(&integrator->places);
    rnd_light_choice_finish(&integrator->choice);
}

void rnd_integrator_restart(struct rnd_integrator *integrator, const struct rnd_scene *scene,
                            const struct rnd_camera *camera)
{
    for (int i = 0; i < integrator->workers; i++) rnd_tracer_scene(integrator->worker[i].tracer, scene);
    go_to(integrator, scene, camera);
    integrator->places.next_cell = 0;
}
