/* A batch: positions are drawn around the gaze, sorted by tile, traced, and added to the film.
 *
 * Which paths are traced, and in which order they reach a pixel, depends on the batches alone and not on the
 * threads: a tile's paths of one batch are traced and added by one thread, first drawn first. So the film is
 * the same bit for bit with any number of threads.
 */
#include "path/trace.h"
#include "render.h"
#include "sampler.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

enum {
    OUTLINE = 16, /* pixels a side of the cells of the first coarse picture */
    CHUNK = 64,   /* paths that a thread takes at a time, about */
    MAX_THREADS = 1024,
};

struct rnd_worker {
    struct rnd_tracer *tracer;
    uint64_t rays, not_finite;
    struct rnd_sample *sample; /* capacity of the batch */
    struct rnd_path path[RND_WAVE];
    uint32_t
        before[RND_TILE_PIXELS]; /* paths of this batch that a pixel has had so far; zero between tiles */
};

struct work {
    struct rnd_render *render;
    const struct rnd_aim *aim;
    uint64_t now_ns;
    uint32_t paths;
    bool drawn; /* positions come from the distribution, else from the cells of the outline */
    uint32_t chunks;
    _Atomic uint32_t next; /* chunk that no thread has taken yet */
};

static double seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* --- where --- */

static uint32_t pixel_index(const struct rnd_film *film, int x, int y)
{
    const uint32_t tile = (uint32_t)(y / RND_TILE * film->across + x / RND_TILE);
    return tile * RND_TILE_PIXELS + (uint32_t)(y % RND_TILE * RND_TILE + x % RND_TILE);
}

static void place_drawn(struct rnd_render *render, const struct rnd_aim *aim, uint32_t first, uint32_t end)
{
    enum { DRAW = 256 };
    const struct rnd_film *film = &render->film;
    float u[2 * DRAW];
    for (uint32_t i = first; i < end; i += DRAW) {
        const uint32_t n = end - i < DRAW ? end - i : DRAW;
        float *place = render->place + 3 * (size_t)i;
        for (uint32_t k = 0; k < n; k++) rnd_pair(render->seed, 0, render->next_place + i + k, u + 2 * k);
        render->distribution->sample(aim, n, u, place);
        for (uint32_t k = 0; k < n; k++) {
            float s, t;
            rnd_to_uv(rnd_vec(place + 3 * k), &s, &t);
            const int x = (int)(s * film->width), y = (int)(t * film->height);
            render->pixel[i + k] = pixel_index(film, x < film->width ? x : film->width - 1,
                                               y < film->height ? y : film->height - 1);
        }
    }
}

/* A random pixel of each cell. */
static void place_outline(struct rnd_render *render, uint32_t first, uint32_t end)
{
    const uint32_t across = (uint32_t)render->film.width / OUTLINE;
    for (uint32_t i = first; i < end; i++) {
        const uint32_t h = rnd_hash2(render->seed + 1, i);
        render->pixel[i] = pixel_index(&render->film, (int)(i % across * OUTLINE + h % OUTLINE),
                                       (int)(i / across * OUTLINE + h / OUTLINE % OUTLINE));
    }
}

static void place(void *context, int worker)
{
    const struct work *work = context;
    const uint64_t threads = (uint64_t)work->render->workers, paths = work->paths;
    const uint32_t first = (uint32_t)(paths * (unsigned)worker / threads);
    const uint32_t end = (uint32_t)(paths * ((unsigned)worker + 1u) / threads);
    if (work->drawn)
        place_drawn(work->render, work->aim, first, end);
    else
        place_outline(work->render, first, end);
}

/* Counting sort by tile; paths of a tile stay in the order in which they were drawn. */
static void sort(struct rnd_render *render, uint32_t paths)
{
    const uint32_t tiles = (uint32_t)(render->film.across * render->film.down);
    uint32_t *start = render->start;
    memset(start, 0, (tiles + 1) * sizeof *start);
    for (uint32_t i = 0; i < paths; i++) start[render->pixel[i] / RND_TILE_PIXELS + 1]++;
    for (uint32_t t = 0; t < tiles; t++) start[t + 1] += start[t];
    for (uint32_t i = 0; i < paths; i++) render->order[start[render->pixel[i] / RND_TILE_PIXELS]++] = i;
    memmove(start + 1, start, tiles * sizeof *start); /* each moved on to its end: the next one's start */
    start[0] = 0;
}

/* Cut the sorted paths where a tile ends into chunks of about CHUNK; returns their number. */
static uint32_t cut(struct rnd_render *render)
{
    const uint32_t tiles = (uint32_t)(render->film.across * render->film.down);
    uint32_t chunks = 0, begin = 0;
    render->chunk[0] = 0;
    for (uint32_t t = 1; t <= tiles; t++)
        if (render->start[t] - render->start[begin] >= CHUNK || t == tiles)
            render->chunk[++chunks] = begin = t;
    return chunks;
}

/* --- what --- */

/* Aim the next path of a pixel: its place within it and all that follows are its own random numbers. */
static void aim_path(const struct rnd_render *render, uint32_t tile, const struct rnd_sample *sample,
                     struct rnd_path *path)
{
    const uint32_t across = (uint32_t)render->film.across;
    const uint32_t x = tile % across * RND_TILE + sample->pixel % RND_TILE;
    const uint32_t y = tile / across * RND_TILE + sample->pixel / RND_TILE;
    const uint32_t pixel = y * (uint32_t)render->film.width + x;
    float u[2];
    path->seed = rnd_hash2(render->seed, 2 * pixel + (sample->number & 1));
    path->index = sample->number >> 1;
    path->origin = rnd_vec(render->eye);
    rnd_pair(path->seed, RND_DIMENSION_PIXEL, path->index, u);
    path->direction = rnd_from_uv(((float)x + u[0]) / (float)render->film.width,
                                  ((float)y + u[1]) / (float)render->film.height);
}

static void trace_wave(struct rnd_worker *worker, struct rnd_sample *samples, uint32_t count)
{
    worker->rays += rnd_trace(worker->tracer, worker->path, count);
    for (uint32_t i = 0; i < count; i++) {
        const vec3s rgb = worker->path[i].radiance;
        const bool finite = isfinite(rgb.x) && isfinite(rgb.y) && isfinite(rgb.z);
        worker->not_finite += !finite;
        for (int c = 0; c < 3; c++) samples[i].rgb[c] = finite ? rgb.raw[c] : 0.0f;
    }
}

/* A chunk: the paths of some neighbouring tiles, traced in waves and then added tile by tile. */
static void trace_chunk(const struct work *work, struct rnd_worker *worker, uint32_t first_tile,
                        uint32_t end_tile)
{
    struct rnd_render *render = work->render;
    const uint32_t *start = render->start;
    const uint32_t base = start[first_tile];
    uint32_t waiting = 0; /* paths of the wave that is being filled */
    for (uint32_t t = first_tile; t < end_tile; t++) {
        struct rnd_film_tile *tile = &render->film.tile[t];
        for (uint32_t i = start[t]; i < start[t + 1]; i++) {
            struct rnd_sample *sample = &worker->sample[i - base];
            sample->pixel = render->pixel[render->order[i]] % RND_TILE_PIXELS;
            /* No other thread writes these counts while this one has the tile. */
            sample->number = tile->count[sample->pixel] + worker->before[sample->pixel]++;
            aim_path(render, t, sample, &worker->path[waiting]);
            if (++waiting < RND_WAVE) continue;
            trace_wave(worker, sample + 1 - waiting, waiting);
            waiting = 0;
        }
        for (uint32_t i = start[t]; i < start[t + 1]; i++) worker->before[worker->sample[i - base].pixel] = 0;
    }
    trace_wave(worker, worker->sample + (start[end_tile] - base) - waiting, waiting);
    for (uint32_t t = first_tile; t < end_tile; t++)
        if (start[t + 1] > start[t])
            rnd_film_add(&render->film, &render->film.tile[t], worker->sample + start[t] - base,
                         start[t + 1] - start[t], work->aim, work->now_ns);
}

/* Take chunks until none is left. Where they begin depends on the batch alone. */
static void trace(void *context, int index)
{
    struct work *work = context;
    struct rnd_render *render = work->render;
    for (;;) {
        const uint32_t i = atomic_fetch_add_explicit(&work->next, 1, memory_order_relaxed);
        if (i >= work->chunks) break;
        trace_chunk(work, &render->worker[index], render->chunk[i], render->chunk[i + 1]);
    }
}

/* --- batches --- */

static bool reserve(struct rnd_render *render, uint32_t paths)
{
    if (paths <= render->capacity) return true;
    free(render->place);
    free(render->pixel);
    free(render->order);
    render->place = malloc(3 * (size_t)paths * sizeof *render->place);
    render->pixel = malloc(paths * sizeof *render->pixel);
    render->order = malloc(paths * sizeof *render->order);
    bool ok = render->place && render->pixel && render->order;
    for (int i = 0; i < render->workers; i++) {
        free(render->worker[i].sample);
        render->worker[i].sample = malloc(paths * sizeof *render->worker[i].sample);
        ok = ok && render->worker[i].sample;
    }
    render->capacity = ok ? paths : 0;
    return ok;
}

static void run(struct work *work, struct rnd_batch *out_batch)
{
    struct rnd_render *render = work->render;
    const double start = seconds();
    *out_batch = (struct rnd_batch){0};
    if (!reserve(render, work->paths)) return; /* no memory: a batch without a path */
    for (int i = 0; i < render->workers; i++) {
        struct rnd_worker *worker = &render->worker[i];
        worker->rays = worker->not_finite = 0;
    }
    rnd_pool_run(render->pool, place, work);
    sort(render, work->paths);
    work->chunks = cut(render);
    out_batch->place_seconds = seconds() - start;
    rnd_pool_run(render->pool, trace, work);

    out_batch->paths = work->paths;
    for (int i = 0; i < render->workers; i++) {
        out_batch->rays += render->worker[i].rays;
        out_batch->not_finite += render->worker[i].not_finite;
    }
    out_batch->seconds = seconds() - start;
}

void rnd_render_batch(struct rnd_render *render, const struct rnd_aim *aim, uint64_t now_ns, uint32_t paths,
                      struct rnd_batch *out_batch)
{
    struct work work = {.render = render, .aim = aim, .now_ns = now_ns, .paths = paths, .drawn = true};
    run(&work, out_batch);
    render->next_place += paths;
}

void rnd_render_outline(struct rnd_render *render, const struct rnd_aim *aim, uint64_t now_ns,
                        struct rnd_batch *out_batch)
{
    const uint32_t cells =
        (uint32_t)(render->film.width / OUTLINE) * (uint32_t)(render->film.height / OUTLINE);
    struct work work = {.render = render, .aim = aim, .now_ns = now_ns, .paths = cells};
    run(&work, out_batch);
}

/* --- life --- */

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
    memcpy(render->eye, scene->info.eye, sizeof render->eye);
    render->distribution = options->distribution;
    render->seed = rnd_hash2((uint32_t)options->seed, (uint32_t)(options->seed >> 32));
    render->workers = (int)threads;
    render->worker = calloc((size_t)threads, sizeof *render->worker);
    render->pool = rnd_pool_create((int)threads);
    const size_t tiles = (size_t)(width / RND_TILE) * (size_t)(height / RND_TILE);
    render->start = malloc((tiles + 1) * sizeof *render->start);
    render->chunk = malloc((tiles + 1) * sizeof *render->chunk);
    bool ok = render->worker && render->pool && render->start && render->chunk;
    for (long i = 0; ok && i < threads; i++)
        ok = (render->worker[i].tracer = rnd_tracer_create(scene, options->max_bounces)) != NULL;
    if (ok &&
        rnd_film_init(&render->film, width, height, options->error_bar > 0.0f ? options->error_bar : 0.05f))
        return render;
no_memory:
    snprintf(out_error, RND_ERROR_SIZE, "film of %d x %d: not enough memory or threads", width, height);
    rnd_render_destroy(render);
    return NULL;
}

void rnd_render_destroy(struct rnd_render *render)
{
    if (!render) return;
    rnd_pool_destroy(render->pool);
    for (int i = 0; render->worker && i < render->workers; i++) {
        free(render->worker[i].sample);
        rnd_tracer_destroy(render->worker[i].tracer);
    }
    free(render->worker);
    free(render->place);
    free(render->pixel);
    free(render->order);
    free(render->start);
    free(render->chunk);
    rnd_film_finish(&render->film);
    pthread_mutex_destroy(&render->whole);
    free(render);
}

/* One thread's share of the tiles. */
static void empty(void *context, int worker)
{
    struct rnd_render *render = context;
    const int tiles = render->film.across * render->film.down;
    const int first = (int)((int64_t)tiles * worker / render->workers);
    const int end = (int)((int64_t)tiles * (worker + 1) / render->workers);
    for (int t = first; t < end; t++) rnd_film_empty(&render->film.tile[t], render->generation);
}

void rnd_render_restart(struct rnd_render *render, const struct rnd_scene *scene, const float eye[3])
{
    render->scene = scene;
    memcpy(render->eye, eye, sizeof render->eye);
    for (int i = 0; i < render->workers; i++) rnd_tracer_scene(render->worker[i].tracer, scene);
    render->next_place = 0;
    render->generation++;
    pthread_mutex_lock(&render->whole);
    rnd_pool_run(render->pool, empty, render);
    pthread_mutex_unlock(&render->whole);
}
