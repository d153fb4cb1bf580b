/* Writes the film as a file, by means of fovead-image. */
#include "exr.h"
#include "render.h"
#include "import/image_apart.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The film as it was at one time. */
struct snapshot {
    struct rnd_pixels_source source; /* first */
    const float *rgb, *samples, *error;
    int width;
};

static void fill_rows(struct rnd_pixels_source *source, int first, int count, float *out_pixels)
{
    const struct snapshot *film = (const struct snapshot *)(const void *)source;
    const size_t from = (size_t)first * (size_t)film->width, all = (size_t)count * (size_t)film->width;
    for (size_t i = from; i < from + all; i++, out_pixels += 5) {
        memcpy(out_pixels, &film->rgb[3 * i], 3 * sizeof *out_pixels);
        out_pixels[3] = film->samples[i];
        out_pixels[4] = film->error[i];
    }
}

bool rnd_render_save(struct rnd_render *render, FILE *file, const char *name, char out_error[RND_ERROR_SIZE])
{
    const int width = render->film.width, height = render->film.height;
    const size_t count = (size_t)width * (size_t)height;
    char text[RND_ERROR_SIZE / 2];
    float *rgb = malloc(count * 5 * sizeof *rgb);
    if (!rgb) {
        snprintf(out_error, RND_ERROR_SIZE, "%.200s: not enough memory", name);
        return false;
    }
    float *samples = rgb + 3 * count, *error = samples + count;
    rnd_render_resolve(render, rgb, samples, error);
    const enum rnd_channel_type colour = rnd_exr_type(rgb, 3 * count),
                                error_type = rnd_exr_type(error, count);
    const struct rnd_layout layout = {.width = width,
                                      .height = height,
                                      .channels = 5,
                                      .channel = {{"R", colour},
                                                  {"G", colour},
                                                  {"B", colour},
                                                  {"samples", RND_FLOAT},
                                                  {"error", error_type}},
                                      .equirectangular = true,
                                      .format = "exr"};
    struct snapshot film = {{fill_rows}, rgb, samples, error, width};
    const bool ok =
        rnd_image_write_apart(render->image_program, fileno(file), &layout, &film.source, text, sizeof text);
    free(rgb);
    if (!ok) snprintf(out_error, RND_ERROR_SIZE, "%.200s: cannot be written: %s", name, text);
    return ok;
}
