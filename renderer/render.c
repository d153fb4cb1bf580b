/* A render: batches of paths go into a film, which is read, saved and begun anew. */
#include "render.h"
#include "film/channels.h"
#include "film/converge.h"
#include "film/film.h"
#include "import/image_program.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { MAX_THREADS = 1024 };

struct rnd_render *rnd_render_create(const struct rnd_scene *scene, const struct rnd_render_options *options,
                                     char out_error[RND_ERROR_SIZE])
{
    const struct rnd_reconstruction *row =
        options->reconstruction ? options->reconstruction : rnd_reconstruction_at(0);
    struct rnd_render_options chosen = *options;
    const int width = options->width, height = options->height;
    if (width < 2 * RND_TILE || width > RND_MAX_WIDTH || width % (2 * RND_TILE) != 0 || height * 2 != width) {
        snprintf(out_error, RND_ERROR_SIZE,
                 "film of %d x %d: expected a width that is a multiple of %d, at most %d, and half of it as "
                 "height",
                 width, height, 2 * RND_TILE, RND_MAX_WIDTH);
        return NULL;
    }
    const long threads = options->threads > 0 ? options->threads : sysconf(_SC_NPROCESSORS_ONLN);
    chosen.threads = (int)(threads < 1 ? 1 : threads > MAX_THREADS ? MAX_THREADS : threads);
    struct rnd_render *render = calloc(1, sizeof *render);
    if (!render) goto no_memory;
    pthread_mutex_init(&render->whole, NULL);
    render->generation = 1;
    render->image_program = rnd_image_program_share(scene->image_program);
    render->material = scene->material;
    const struct rnd_camera camera = rnd_camera_at(scene->info.camera, scene->origin);
    const float error_bar = options->error_bar > 0.0f ? options->error_bar : 0.05f;
    uint32_t planes = row->planes | options->planes;
    if (planes & RND_PLANE(POSITION)) planes |= RND_PLANE(COVERAGE); /* see film/channels.c */
    if (rnd_film_init(&render->film, width, height, error_bar, planes, &camera) &&
        (!row->keeps_history || rnd_film_init(&render->history, width, height, error_bar, planes, &camera)) &&
        rnd_reconstructor_init(&render->reconstructor, row, &render->film,
                               row->keeps_history ? &render->history : NULL) &&
        rnd_integrator_init(&render->integrator, scene, &camera, &render->film, &chosen))
        return render;
no_memory:
    snprintf(out_error, RND_ERROR_SIZE, "film of %d x %d: not enough memory or threads", width, height);
    rnd_render_destroy(render);
    return NULL;
}

void rnd_render_destroy(struct rnd_render *render)
{
    if (!render) return;
    rnd_integrator_finish(&render->integrator);
    rnd_reconstructor_finish(&render->reconstructor);
    rnd_film_finish(&render->film);
    rnd_film_finish(&render->history);
    rnd_image_program_destroy(render->image_program);
    pthread_mutex_destroy(&render->whole);
    free(render);
}

int rnd_render_threads(const struct rnd_render *render)
{
    return render->integrator.workers;
}

/* --- history: the film of a former camera --- */

static void forget(struct rnd_render *render)
{
    rnd_film_restart(&render->history, NULL, &render->integrator.camera, 0, render->integrator.pool);
}

/* The present film is better once it has as many paths. */
static void compare(struct rnd_render *render)
{
    if (render->history.paths > 0 && render->film.paths >= render->history.paths) forget(render);
}

/* --- paths --- */

void rnd_render_batch(struct rnd_render *render, const struct rnd_aim *aim, uint64_t now_ns, uint32_t paths,
                      struct rnd_batch *out_batch)
{
    rnd_integrate(&render->integrator, aim, now_ns, paths, out_batch);
    compare(render);
}

void rnd_render_outline(struct rnd_render *render, const struct rnd_aim *aim, uint64_t now_ns,
                        struct rnd_batch *out_batch)
{
    rnd_integrate_outline(&render->integrator, aim, now_ns, out_batch);
    compare(render);
}

void rnd_render_retrace(struct rnd_render *render, const struct rnd_aim *aim, uint32_t paths,
                        struct rnd_batch *out_batch, double *out_seconds)
{
    rnd_integrate_twice(&render->integrator, aim, paths, out_batch, out_seconds);
    compare(render);
}

void rnd_render_restart(struct rnd_render *render, const struct rnd_scene *scene, const double position[3])
{
    struct rnd_film *film = &render->film, *history = &render->history;
    const struct rnd_camera camera = rnd_camera_at(position, scene->origin);
    const bool edited = scene != render->integrator.scene || scene->material != render->material;
    rnd_integrator_restart(&render->integrator, scene, &camera);
    render->material = scene->material;
    render->generation++;
    if (edited && history->paths > 0) forget(render);
    const bool keep = history->tile && !edited && film->paths > history->paths;
    pthread_mutex_lock(&render->whole);
    rnd_film_restart(film, keep ? history : NULL, &camera, render->generation, render->integrator.pool);
    pthread_mutex_unlock(&render->whole);
}

/* --- the film --- */

int rnd_render_levels(const struct rnd_render *render)
{
    int levels = 1; /* the width is twice the height and so divides where the height does */
    while ((render->film.height >> levels) >= RND_TILE && (render->film.height >> levels) % RND_TILE == 0)
        levels++;
    return levels;
}

void rnd_render_tiles(struct rnd_render *render, struct rnd_tile *out_tiles)
{
    const int count = render->film.across * render->film.down;
    for (int i = 0; i < count; i++) rnd_film_state(&render->film.tile[i], &out_tiles[i]);
}

uint32_t rnd_render_published(struct rnd_render *render, struct rnd_tile *tiles, uint32_t *out_index)
{
    return rnd_film_published(&render->film, tiles, out_index);
}

bool rnd_tile_settled(const struct rnd_render *render, const struct rnd_tile *tile, int x, int y,
                      const float gaze[3])
{
    return rnd_film_settled(&render->film, tile, x, y, gaze);
}

bool rnd_render_read(struct rnd_render *render, int level, int x, int y, float *out_rgb,
                     struct rnd_tile *out_state)
{
    struct rnd_tile state;
    return rnd_reconstruct(&render->reconstructor, level, x, y, out_rgb, out_state ? out_state : &state);
}

void rnd_render_resolve(struct rnd_render *render, float *out_rgb, float *out_samples, float *out_error)
{
    pthread_mutex_lock(&render->whole);
    rnd_film_resolve(&render->film, out_rgb, out_samples, out_error);
    pthread_mutex_unlock(&render->whole);
}

const char *rnd_render_channel(const struct rnd_render *render, int index)
{
    bool floats;
    return index < rnd_film_channels(&render->film) ? rnd_film_channel(&render->film, index, &floats) : NULL;
}

bool rnd_render_read_channels(struct rnd_render *render, int x, int y, float *out_values,
                              struct rnd_tile *out_state)
{
    struct rnd_film_tile *tile = &render->film.tile[y * render->film.across + x];
    if (!rnd_film_lock_soon(tile)) return false;
    rnd_film_read_channels(&render->film, tile, out_values);
    if (out_state) *out_state = tile->state;
    pthread_mutex_unlock(&tile->lock);
    return true;
}
