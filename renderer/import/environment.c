/* Reading an environment map. */
#include "import/environment.h"
#include "import/pictures.h"
#include "light/env.h"
#include "math/large_pages.h"

#include <stdio.h>
#include <stdlib.h>

/* The largest half float, in place of infinity: the clipped value was at least as large, and weights can
 * still be summed. */
#define INFINITE_RADIANCE 65504.0f
#define MOST_RADIANCE     1e30f

/* A picture that becomes an environment map. */
struct filling {
    struct rnd_pixels_sink sink; /* first */
    struct rnd_env *env;
    size_t channels;
    bool too_large;
    size_t bad, first; /* number of texels that are no radiance, and the index of the first */
    float first_value; /* of the first bad texel */
};

/* 16384 x 8192: 2 GiB of texels, and 1 GiB of tables. */
#define MOST_TEXELS ((int64_t)1 << 27)

static bool begin(struct rnd_pixels_sink *sink, const struct rnd_picture *picture)
{
    struct filling *filling = (struct filling *)(void *)sink;
    struct rnd_env *env = filling->env;
    filling->too_large = (int64_t)picture->width * picture->height > MOST_TEXELS;
    if (filling->too_large) return false;
    const size_t bytes =
        ((size_t)picture->width * (size_t)picture->height * sizeof *env->texel + 63) & ~(size_t)63;
    filling->channels = (size_t)picture->channels;
    env->width = picture->width;
    env->height = picture->height;
    env->texel = aligned_alloc(64, bytes);
    rnd_use_large_pages(env->texel, bytes);
    return env->texel;
}

/* Take the radiance of some rows, with values that no radiance can have clamped. */
static bool take_rows(struct rnd_pixels_sink *sink, int first_row, int rows, const void *pixels)
{
    struct filling *filling = (struct filling *)(void *)sink;
    struct rnd_env *env = filling->env;
    const size_t before = (size_t)first_row * (size_t)env->width, count = (size_t)rows * (size_t)env->width,
                 n = filling->channels;
    for (size_t i = 0; i < count; i++) {
        bool good = true;
        for (size_t c = 0; c < 3; c++) {
            const float value = ((const float *)pixels)[n * i + (n >= 3 ? c : 0)];
            const bool fits = value >= 0.0f && value <= MOST_RADIANCE;
            if (good && !fits && filling->bad == 0) filling->first = before + i, filling->first_value = value;
            good = good && fits;
            env->texel[before + i][c] = fits ? value : value > MOST_RADIANCE ? INFINITE_RADIANCE : 0.0f;
        }
        filling->bad += !good;
    }
    return true;
}

static void warn_of_clamped(const char *path, const struct filling *filling, char out_warning[RND_ERROR_SIZE])
{
    const size_t width = (size_t)filling->env->width;
    if (filling->bad == 0) return;
    snprintf(out_warning, RND_ERROR_SIZE,
             "%.200s: the pixel at x %zu, y %zu is %g, which is no radiance; pixels clamped to 0 to %g: %zu",
             path, filling->first % width, filling->first / width, (double)filling->first_value,
             (double)INFINITE_RADIANCE, filling->bad);
}

bool rnd_environment_read(struct rnd_scene *scene, const char *path, float azimuth_deg,
                          char out_warning[RND_ERROR_SIZE], char out_error[RND_ERROR_SIZE])
{
    struct rnd_env *env = scene->lights.env = calloc(1, sizeof *env);
    const struct rnd_pixels_file file = {.path = path, .use = RND_PIXELS_COLOUR};
    struct filling filling = {.sink = {begin, take_rows}, .env = env};
    char text[RND_ERROR_SIZE / 2] = "not enough memory";
    bool ok = false, black = false;
    *out_warning = '\0';
    if (env) {
        struct rnd_image_reader reader = rnd_scene_reader(scene);
        env->turn = -azimuth_deg / 360.0f;
        ok = rnd_image_read_apart(&reader, &file, &filling.sink, text, sizeof text);
        rnd_image_reader_finish(&reader);
    }
    if (filling.too_large) {
        snprintf(out_error, RND_ERROR_SIZE, "%.200s: more than %lld pixels, as 16384 x 8192 has", path,
                 (long long)MOST_TEXELS);
        return false;
    }
    if (!ok) {
        snprintf(out_error, RND_ERROR_SIZE, "%.200s: %s", path, text);
        return false;
    }
    warn_of_clamped(path, &filling, out_warning);
    ok = rnd_env_tables(env, &black) && !black;
    if (!ok)
        snprintf(out_error, RND_ERROR_SIZE, "%.200s: %s", path,
                 black ? "the environment map is black" : "not enough memory");
    return ok;
}
