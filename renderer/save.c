/* Writes the film as a file, by means of fovead-image. */
#include "exr.h"
#include "film/channels.h"
#include "import/image_apart.h"
#include "render.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

_Static_assert((int)RND_LAYOUT_CHANNELS >= (int)RND_MOST_CHANNELS, "a layout has no room for all channels");

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

bool rnd_render_save(struct rnd_render *render, FILE *file, const char *name, char out_error[RND_ERROR_SIZE])
{
    const struct rnd_film *film = &render->film;
    const size_t row = (size_t)film->width * (size_t)rnd_film_channels(film);
    char text[RND_ERROR_SIZE / 2];
    struct rnd_layout layout;
    float *values = malloc((size_t)film->height * row * sizeof *values);
    if (!values) {
        snprintf(out_error, RND_ERROR_SIZE, "%.200s: not enough memory", name);
        return false;
    }
    read_channels(render, values);
    lay_out(film, values, &layout);
    struct values source = {{fill_rows}, values, row};
    const bool ok = rnd_image_write_apart(render->image_program, fileno(file), &layout, &source.source, text,
                                          sizeof text);
    free(values);
    if (!ok) snprintf(out_error, RND_ERROR_SIZE, "%.200s: cannot be written: %s", name, text);
    return ok;
}
