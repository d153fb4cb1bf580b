/* The environment map: read, weighed, and made into a table to draw from. */
#include "large_pages.h"
#include "scene/image_io.h"
#include "scene/scene.h"

#include <stdio.h>
#include <stdlib.h>

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
    return sum * sinf((float)M_PI * (y + 0.5f) / env->height);
}

/* Take the radiance of every texel; false if one is not radiance. */
static bool take(struct rnd_env *env, const struct rnd_pixels *pixels, size_t *out_bad)
{
    const size_t count = (size_t)env->width * env->height, n = pixels->channels;
    for (size_t i = 0; i < count; i++)
        for (size_t c = 0; c < 3; c++) {
            const float value = pixels->floats[n * i + (n >= 3 ? c : 0)];
            if (!(value >= 0.0f && isfinite(value))) return *out_bad = i, false;
            env->texel[i][c] = value;
        }
    return true;
}

/* The table, and in every texel the density with which it draws. */
static bool make_table(struct rnd_env *env, bool *out_black)
{
    const size_t count = (size_t)env->width * env->height;
    float *weight = malloc(count * sizeof *weight), any = 0.0f;
    if (!weight) return false;
    for (size_t i = 0; i < count; i++)
        any += weight[i] = weight_of(env, (int)(i % env->width), (int)(i / env->width));
    *out_black = !(any > 0.0f);
    const bool ok = *out_black || rnd_alias_init(&env->alias, weight, (uint32_t)count);
    free(weight);
    if (!ok || *out_black) return ok;
    const float scale = (float)count / (float)(2.0 * M_PI * M_PI);
    for (size_t i = 0; i < count; i++) env->texel[i][3] = env->alias.probability[i] * scale;
    free(env->alias.probability);
    env->alias.probability = NULL;
    return true;
}

bool rnd_env_load(struct rnd_scene *scene, const char *path, float azimuth_deg,
                  char out_error[RND_ERROR_SIZE])
{
    struct rnd_env *env = calloc(1, sizeof *env);
    struct rnd_pixels pixels = {0};
    char text[RND_ERROR_SIZE / 2] = "not enough memory";
    size_t bad = 0;
    bool ok = false, black = false;
    if (!(scene->lights.env = env)) goto end;
    if (!rnd_pixels_read(path, NULL, 0, false, &pixels, text, sizeof text)) {
        snprintf(out_error, RND_ERROR_SIZE, "%.200s: not a readable environment map: %s", path, text);
        return false;
    }
    env->width = pixels.width;
    env->height = pixels.height;
    env->turn = -azimuth_deg / 360.0f;
    const size_t bytes = ((size_t)env->width * env->height * sizeof *env->texel + 63) & ~(size_t)63;
    env->texel = aligned_alloc(64, bytes);
    if (!env->texel) goto end;
    rnd_use_large_pages(env->texel, bytes);
    if (!take(env, &pixels, &bad)) {
        snprintf(text, sizeof text, "pixel %zu is negative or not finite: expected radiance", bad);
        goto end;
    }
    ok = make_table(env, &black) && !black;
    if (black) snprintf(text, sizeof text, "the environment map is black");
end:
    rnd_pixels_finish(&pixels);
    if (!ok) snprintf(out_error, RND_ERROR_SIZE, "%.200s: %s", path, text);
    return ok;
}

struct rnd_v3 rnd_env_radiance(const struct rnd_env *env, struct rnd_v3 direction, float *out_pdf)
{
    float u, v;
    rnd_env_to_uv(env, direction, &u, &v);
    const float *t = env->texel[rnd_env_texel(env, u, v, 0.5f, 0.5f)];
    *out_pdf = t[3] / fmaxf(sqrtf(direction.x * direction.x + direction.z * direction.z), 1e-6f);
    return rnd_v3(t[0], t[1], t[2]);
}
