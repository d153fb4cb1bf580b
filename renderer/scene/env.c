/* The environment map: read, weighed, and made into a table to draw from. */
#include "math/large_pages.h"
#include "scene/image_reader.h"
#include "scene/scene.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const float *texel(const struct rnd_env *env, int x, int y)
{
    const int w = env->width, h = env->height;
    return env->texel[(size_t)(y < 0 ? 0 : y >= h ? h - 1 : y) * w + (x + w) % w];
}

/* A texel's weight: mean luminance of the texels that its bilinear footprint touches, so that nothing that
 * can shine has no density, times the solid angle. */
static float weight_of(const struct rnd_env *env, int x, int y)
{
    float sum = 0.0f;
    for (int dy = -1; dy <= 1; dy++)
        for (int dx = -1; dx <= 1; dx++) sum += rnd_luminance(texel(env, x + dx, y + dy));
    return sum * rnd_row_weight(y, env->height);
}

/* The largest half: what clipped to infinity was at least as bright. And what weights can be summed up to. */
#define INFINITE_RADIANCE 65504.0f
#define MOST_RADIANCE     1e30f

/* A picture that becomes an environment map. */
struct filling {
    struct rnd_pixels_sink sink; /* first */
    struct rnd_env *env;
    size_t channels;
    bool too_large;
    size_t bad, first; /* texels that are no radiance, and the first of them */
    float first_value; /* of that texel */
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

/* Take the radiance of texels. What no radiance can be is clamped. */
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

static uint32_t region_of(const struct rnd_env *env, int x, int y)
{
    return rnd_env_region(env, ((float)x + 0.5f) / (float)env->width, ((float)y + 0.5f) / (float)env->height);
}

/* The texels of all regions. A map that has fewer than there are regions leaves some empty. */
static void divide(struct rnd_env *env)
{
    for (int y = 0; y < env->height; y++)
        for (int x = 0; x < env->width; x++) {
            struct rnd_env_region *r = &env->region[region_of(env, x, y)];
            if (r->texels++ == 0) r->x = x, r->y = y;
            r->width = x - r->x + 1;
        }
    for (int i = 1; i < RND_ENV_REGIONS; i++)
        env->region[i].first = env->region[i - 1].first + env->region[i - 1].texels;
}

/* The table of one region, and the weight of each of its texels in place of their density. */
static bool make_region(struct rnd_env *env, int number, float *weight, double *out_sum)
{
    const struct rnd_env_region *r = &env->region[number];
    float any = 0.0f;
    for (uint32_t i = 0; i < r->texels; i++) {
        const int x = r->x + (int)i % r->width, y = r->y + (int)i / r->width;
        any += weight[i] = env->texel[(size_t)y * env->width + x][3] = weight_of(env, x, y);
    }
    *out_sum = 0.0;
    if (!(any > 0.0f)) return true;
    struct rnd_alias alias;
    if (!rnd_alias_init(&alias, weight, r->texels)) return false;
    for (uint32_t i = 0; i < r->texels; i++) {
        const uint32_t other = alias.entry[i].other, x = other % r->width, y = other / r->width;
        env->entry[r->first + i] = (struct rnd_alias_entry){
            alias.entry[i].keep, (uint32_t)(r->y + (int)y) * (uint32_t)env->width + (uint32_t)r->x + x};
    }
    *out_sum = alias.sum;
    rnd_alias_finish(&alias);
    return true;
}

/* The tables, and in every texel the density with which they draw. */
static bool make_tables(struct rnd_env *env, bool *out_black)
{
    const size_t count = (size_t)env->width * env->height;
    double sum[RND_ENV_REGIONS], all = 0.0;
    divide(env);
    float *weight = malloc(count * sizeof *weight);
    env->entry = malloc(count * sizeof *env->entry);
    bool ok = weight && env->entry;
    if (!ok) goto end;
    rnd_use_large_pages(env->entry, count * sizeof *env->entry);
    for (int i = 0; ok && i < RND_ENV_REGIONS; i++) {
        ok = make_region(env, i, weight, &sum[i]);
        all += sum[i];
    }
    *out_black = !(all > 0.0);
    if (!ok || *out_black) goto end;
    const double scale = (double)count / (2.0 * M_PI * M_PI) / all; /* beyond a float for the darkest maps */
    for (size_t i = 0; i < count; i++) env->texel[i][3] = (float)((double)env->texel[i][3] * scale);
    for (int i = 0; i < RND_ENV_REGIONS; i++) env->weight[i] = (float)(sum[i] / all);
    ok = rnd_env_choose(env, env->weight, &env->by_weight);
end:
    free(weight);
    return ok;
}

bool rnd_env_choose(const struct rnd_env *env, const float probability[RND_ENV_REGIONS],
                    struct rnd_env_choice *out)
{
    struct rnd_alias alias;
    if (!rnd_alias_init(&alias, probability, RND_ENV_REGIONS)) return false;
    memcpy(out->entry, alias.entry, sizeof out->entry);
    for (int i = 0; i < RND_ENV_REGIONS; i++)
        out->factor[i] = env->weight[i] > 0.0f ? alias.probability[i] / env->weight[i] : 0.0f;
    rnd_alias_finish(&alias);
    return true;
}

bool rnd_env_load(struct rnd_scene *scene, const char *path, float azimuth_deg,
                  char out_warning[RND_ERROR_SIZE], char out_error[RND_ERROR_SIZE])
{
    struct rnd_env *env = scene->lights.env = calloc(1, sizeof *env);
    struct filling filling = {.sink = {begin, take_rows}, .env = env};
    char text[RND_ERROR_SIZE / 2] = "not enough memory";
    bool ok = false, black = false;
    *out_warning = '\0';
    if (env) {
        struct rnd_image_reader reader = rnd_scene_reader(scene);
        env->turn = -azimuth_deg / 360.0f;
        ok = rnd_image_read_apart(&reader, path, NULL, 0, RND_PIXELS_COLOUR, false, &filling.sink, text,
                                  sizeof text);
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
    ok = make_tables(env, &black) && !black;
    if (!ok)
        snprintf(out_error, RND_ERROR_SIZE, "%.200s: %s", path,
                 black ? "the environment map is black" : "not enough memory");
    return ok;
}

struct rnd_v3 rnd_env_radiance(const struct rnd_env *env, struct rnd_v3 direction, uint32_t *out_region,
                               float *out_pdf)
{
    float u, v;
    rnd_env_to_uv(env, direction, &u, &v);
    *out_region = rnd_env_region(env, u, v);
    const float *t = env->texel[rnd_env_texel(env, u, v, 0.5f, 0.5f)];
    *out_pdf = t[3] / fmaxf(sqrtf(direction.x * direction.x + direction.z * direction.z), 1e-6f);
    return rnd_v3(t[0], t[1], t[2]);
}
