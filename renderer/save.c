/* Writes the film as a file, by means of fovead-image. */
#include "exr.h"
#include "film/channels.h"
#include "film/film.h"
#include "import/image_apart.h"
#include "render.h"
#include "rgb_rows.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

_Static_assert((int)RND_LAYOUT_CHANNELS >= (int)RND_MOST_CHANNELS, "a layout has no room for all channels");

static bool fail(const char *name, const char *why, char out_error[RND_ERROR_SIZE])
{
    snprintf(out_error, RND_ERROR_SIZE, "%.200s: %s", name, why);
    return false;
}

static bool write(struct rnd_render *render, FILE *file, const char *name, const struct rnd_layout *layout,
                  struct rnd_pixels_source *source, char out_error[RND_ERROR_SIZE])
{
    char text[RND_ERROR_SIZE / 2];
    if (rnd_image_write_apart(render->image_program, fileno(file), layout, source, text, sizeof text))
        return true;
    snprintf(out_error, RND_ERROR_SIZE, "%.200s: cannot be written: %s", name, text);
    return false;
}

/* --- all channels, as EXR --- */

/* The film as it was at one time. */
struct values {
    struct rnd_pixels_source source; /* first */
    const float *values;             /* the channels of a pixel side by side */
    size_t row;
};

static void fill_rows(struct rnd_pixels_source *source, int first, int count, float *out_pixels)
{
    const struct values *film = (const struct values *)(const void *)source;
    memcpy(out_pixels, film->values + (size_t)first * film->row,
           (size_t)count * film->row * sizeof *film->values);
}

static void read_channels(struct rnd_render *render, float *out)
{
    const struct rnd_film *film = &render->film;
    const size_t channels = (size_t)rnd_film_channels(film), row = RND_TILE * channels;
    float values[RND_TILE_PIXELS * RND_MOST_CHANNELS];
    pthread_mutex_lock(&render->whole);
    for (int t = 0; t < film->across * film->down; t++) {
        float *to =
            out + ((size_t)(t / film->across) * (size_t)film->width + (size_t)(t % film->across)) * row;
        pthread_mutex_lock(&film->tile[t].lock);
        rnd_film_read_channels(film, &film->tile[t], values);
        pthread_mutex_unlock(&film->tile[t].lock);
        for (size_t y = 0; y < RND_TILE; y++)
            memcpy(to + y * (size_t)film->width * channels, values + y * row, row * sizeof *values);
    }
    pthread_mutex_unlock(&render->whole);
}

/* Colours are all stored alike. */
static void lay_out(const struct rnd_film *film, const float *values, struct rnd_layout *out)
{
    const size_t pixels = (size_t)film->width * (size_t)film->height,
                 channels = (size_t)rnd_film_channels(film);
    *out = (struct rnd_layout){.width = film->width,
                               .height = film->height,
                               .channels = (int)channels,
                               .equirectangular = true,
                               .format = "exr"};
    for (size_t c = 0; c < channels; c++) {
        struct rnd_channel *channel = &out->channel[c];
        const size_t first = c < 3 ? 0 : c;
        bool floats;
        snprintf(channel->name, sizeof channel->name, "%s", rnd_film_channel(film, (int)c, &floats));
        channel->type = floats ? RND_FLOAT : rnd_exr_type(values + first, pixels, channels, c < 3 ? 3 : 1);
    }
}

static bool save_channels(struct rnd_render *render, FILE *file, const char *name,
                          char out_error[RND_ERROR_SIZE])
{
    const struct rnd_film *film = &render->film;
    const size_t row = (size_t)film->width * (size_t)rnd_film_channels(film);
    struct rnd_layout layout;
    float *values = malloc((size_t)film->height * row * sizeof *values);
    if (!values) return fail(name, "not enough memory", out_error);
    read_channels(render, values);
    lay_out(film, values, &layout);
    struct values source = {{fill_rows}, values, row};
    const bool ok = write(render, file, name, &layout, &source.source, out_error);
    free(values);
    return ok;
}

/* --- as a picture for displays --- */

/* What clients are shown, but black where there is nothing to show. */
static void read_picture(struct rnd_render *render, float *out_rgb)
{
    const struct rnd_film *film = &render->film;
    float rgb[RND_TILE_PIXELS * 3];
    struct rnd_tile state;
    pthread_mutex_lock(&render->whole);
    rnd_film_resolve(film, out_rgb, NULL, NULL); /* for tiles that are locked below */
    for (int t = 0; t < film->across * film->down; t++) {
        const int x = t % film->across, y = t / film->across;
        if (!rnd_reconstruct(&render->reconstructor, 0, x, y, rgb, &state)) continue;
        for (int i = 0; i < RND_TILE; i++)
            memcpy(out_rgb + 3 * ((size_t)(y * RND_TILE + i) * (size_t)film->width + (size_t)(x * RND_TILE)),
                   rgb + 3 * RND_TILE * i, 3 * RND_TILE * sizeof *rgb);
    }
    pthread_mutex_unlock(&render->whole);
}

static bool save_picture(struct rnd_render *render, FILE *file, const char *name,
                         const struct rnd_exposure *exposure, char out_error[RND_ERROR_SIZE])
{
    const int width = render->film.width, height = render->film.height;
    float *rgb = malloc((size_t)width * (size_t)height * 3 * sizeof *rgb);
    struct rnd_rgb_rows rows;
    if (!rgb) return fail(name, "not enough memory", out_error);
    read_picture(render, rgb);
    rnd_expose(exposure, rgb, width, height);
    const bool ok = rnd_rgb_rows_init(&rows, name, width, height, rgb, true, out_error) &&
                    write(render, file, name, &rows.layout, &rows.source, out_error);
    free(rgb);
    return ok;
}

bool rnd_render_save(struct rnd_render *render, FILE *file, const char *name,
                     const struct rnd_exposure *exposure, char out_error[RND_ERROR_SIZE])
{
    return rnd_is_exr(name) ? save_channels(render, file, name, out_error)
                            : save_picture(render, file, name, exposure, out_error);
}
