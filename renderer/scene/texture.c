/* Textures: asked for at import, read by several threads, kept with their mipmaps under a cap of memory. */
#include "scene/texture.h"
#include "scene/scene.h"
#include "scene/srgb.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Of all textures with their mipmaps; what is over it loses its finest levels. */
static const uint64_t CAP_BYTES = (uint64_t)2 << 30;

int rnd_texture_add(struct rnd_scene *scene, const char *path, const void *memory, size_t count, bool srgb,
                    char out_error[RND_ERROR_SIZE])
{
    for (uint32_t i = 0; i < scene->texture_count; i++)
        if (scene->texture[i].srgb == srgb && strcmp(scene->texture[i].path, path) == 0) return (int)i;

    struct rnd_texture *grown = realloc(scene->texture, (scene->texture_count + 1) * sizeof *grown);
    if (grown) scene->texture = grown;
    struct rnd_texture texture = {.srgb = srgb, .path = strdup(path)};
    if (memory && (texture.file = malloc(count ? count : 1))) {
        memcpy(texture.file, memory, count);
        texture.file_bytes = count;
    }
    if (!grown || !texture.path || (memory && !texture.file)) {
        snprintf(out_error, RND_ERROR_SIZE, "%.200s: not enough memory", path);
        free(texture.path);
        free(texture.file);
        return -1;
    }
    scene->texture[scene->texture_count] = texture;
    return (int)scene->texture_count++;
}

void rnd_texture_finish(struct rnd_texture *texture)
{
    free(texture->path);
    free(texture->file);
    free(texture->bytes);
    free(texture->floats);
    *texture = (struct rnd_texture){0};
}

/* --- mipmaps --- */

/* Lay out the levels below width x height; returns the texels of all. */
static size_t lay_out(struct rnd_texture *texture, int width, int height)
{
    size_t count = 0;
    texture->levels = 0;
    for (int w = width, h = height;; w = w > 1 ? w / 2 : 1, h = h > 1 ? h / 2 : 1) {
        texture->level[texture->levels++] = (struct rnd_level){w, h, count};
        count += (size_t)w * h;
        if ((w == 1 && h == 1) || texture->levels == RND_MAX_LEVELS) return count;
    }
}

static float decode(const struct rnd_texture *texture, size_t i, int c)
{
    if (texture->floats) return texture->floats[4 * i + c];
    const uint8_t byte = texture->bytes[4 * i + c];
    return texture->srgb && c < 3 ? rnd_srgb_decode(byte) : byte / 255.0f;
}

static void encode(struct rnd_texture *texture, size_t i, int c, float value)
{
    if (texture->floats)
        texture->floats[4 * i + c] = value;
    else
        texture->bytes[4 * i + c] =
            (uint8_t)(255.0f * (texture->srgb && c < 3 ? rnd_srgb_encode(value) : value) + 0.5f);
}

/* Every level is the mean of the one above it, in linear light; an odd last row or column counts as twice. */
static void fill_levels(struct rnd_texture *texture)
{
    for (int l = 1; l < texture->levels; l++) {
        const struct rnd_level *from = &texture->level[l - 1], *to = &texture->level[l];
        for (int y = 0; y < to->height; y++)
            for (int x = 0; x < to->width; x++) {
                const int x0 = 2 * x, y0 = 2 * y, x1 = x0 + 1 < from->width ? x0 + 1 : x0,
                          y1 = y0 + 1 < from->height ? y0 + 1 : y0;
                const size_t a = from->first + (size_t)y0 * from->width,
                             b = from->first + (size_t)y1 * from->width;
                for (int c = 0; c < 4; c++)
                    encode(texture, to->first + (size_t)y * to->width + x, c,
                           0.25f * (decode(texture, a + x0, c) + decode(texture, a + x1, c) +
                                    decode(texture, b + x0, c) + decode(texture, b + x1, c)));
            }
    }
}

/* The first level from the file's pixels: RGBA; missing channels repeat the first, alpha is 1. */
static void take_pixels(struct rnd_texture *texture, const struct rnd_pixels *pixels)
{
    const size_t count = (size_t)pixels->width * pixels->height, n = pixels->channels;
    const size_t g = n >= 3 ? 1 : 0, b = 2 * g, a = n == 2 || n >= 4 ? (n == 2 ? 1 : 3) : 0;
    texture->has_alpha = a != 0;
    for (size_t i = 0; i < count; i++) {
        const size_t channel[4] = {n * i, n * i + g, n * i + b, n * i + a};
        for (int c = 0; c < 4; c++)
            if (texture->floats)
                texture->floats[4 * i + c] = c == 3 && !a ? 1.0f : pixels->floats[channel[c]];
            else
                texture->bytes[4 * i + c] = c == 3 && !a ? 255 : pixels->bytes[channel[c]];
    }
}

bool rnd_texture_load(struct rnd_texture *texture, char out_error[RND_ERROR_SIZE])
{
    struct rnd_pixels pixels;
    char text[RND_ERROR_SIZE / 2];
    if (!rnd_pixels_read(texture->path, texture->file, texture->file_bytes, true, &pixels, text,
                         sizeof text)) {
        snprintf(out_error, RND_ERROR_SIZE, "%.200s: not a readable image: %s", texture->path, text);
        return false;
    }
    free(texture->file);
    texture->file = NULL;
    const size_t count = lay_out(texture, pixels.width, pixels.height);
    texture->log2_size = 0.5f * log2f((float)pixels.width * (float)pixels.height);
    if (pixels.floats)
        texture->floats = malloc(count * 4 * sizeof *texture->floats);
    else
        texture->bytes = malloc(count * 4);
    const bool ok = texture->floats || texture->bytes;
    if (ok) take_pixels(texture, &pixels);
    rnd_pixels_finish(&pixels);
    if (ok) fill_levels(texture);
    if (!ok) snprintf(out_error, RND_ERROR_SIZE, "%.200s: not enough memory", texture->path);
    return ok;
}

/* Forget the finest level: the others move to the front of the memory. */
static bool drop_finest(struct rnd_texture *texture)
{
    if (texture->levels < 2) return false;
    const size_t texel = texture->floats ? 4 * sizeof(float) : 4, first = texture->level[1].first;
    const size_t all = texture->level[texture->levels - 1].first + 1;
    uint8_t *memory = texture->floats ? (uint8_t *)texture->floats : texture->bytes;
    memmove(memory, memory + first * texel, (all - first) * texel);
    uint8_t *less = realloc(memory, (all - first) * texel);
    if (less) memory = less;
    if (texture->floats)
        texture->floats = (float *)memory;
    else
        texture->bytes = memory;
    texture->levels--;
    texture->log2_size -= 1.0f;
    for (int l = 0; l < texture->levels; l++) {
        texture->level[l] = texture->level[l + 1];
        texture->level[l].first -= first;
    }
    return true;
}

static uint64_t bytes_of(const struct rnd_texture *texture)
{
    return (texture->level[texture->levels - 1].first + 1) * (texture->floats ? 4 * sizeof(float) : 4);
}

/* Under the cap, the largest textures first: what the film cannot show is lost before what it can. */
static void keep_cap(struct rnd_scene *scene)
{
    for (;;) {
        struct rnd_texture *largest = NULL;
        scene->info.texture_bytes = 0;
        for (uint32_t i = 0; i < scene->texture_count; i++) {
            struct rnd_texture *texture = &scene->texture[i];
            scene->info.texture_bytes += bytes_of(texture);
            if (!largest || bytes_of(texture) > bytes_of(largest)) largest = texture;
        }
        if (scene->info.texture_bytes <= CAP_BYTES || !drop_finest(largest)) return;
    }
}

/* --- reading, in parallel --- */

struct loading {
    struct rnd_scene *scene;
    _Atomic uint32_t next;
    _Atomic uint32_t failed; /* the lowest index that did: the same line whatever thread was first */
    char (*error)[RND_ERROR_SIZE];
};

static void *load_some(void *argument)
{
    struct loading *loading = argument;
    struct rnd_scene *scene = loading->scene;
    for (;;) {
        const uint32_t i = atomic_fetch_add(&loading->next, 1);
        if (i >= scene->texture_count) return NULL;
        if (scene->texture[i].levels > 0 || rnd_texture_load(&scene->texture[i], loading->error[i])) continue;
        uint32_t known = atomic_load(&loading->failed);
        while (i < known && !atomic_compare_exchange_weak(&loading->failed, &known, i)) continue;
    }
}

bool rnd_textures_load(struct rnd_scene *scene, int threads, char out_error[RND_ERROR_SIZE])
{
    enum { MOST = 64 };
    struct loading loading = {.scene = scene, .failed = UINT32_MAX};
    pthread_t thread[MOST];
    int started = 0;
    if (scene->texture_count == 0) return true;
    if (!(loading.error = calloc(scene->texture_count, sizeof *loading.error))) {
        snprintf(out_error, RND_ERROR_SIZE, "not enough memory for textures");
        return false;
    }
    while (started < threads - 1 && started < MOST && started + 1 < (int)scene->texture_count &&
           pthread_create(&thread[started], NULL, load_some, &loading) == 0)
        started++;
    load_some(&loading);
    while (started > 0) pthread_join(thread[--started], NULL);
    const uint32_t failed = atomic_load(&loading.failed);
    if (failed != UINT32_MAX) memcpy(out_error, loading.error[failed], RND_ERROR_SIZE);
    free(loading.error);
    if (failed == UINT32_MAX) keep_cap(scene);
    return failed == UINT32_MAX;
}

/* --- looking --- */

struct rnd_texel rnd_texture_bilinear(const struct rnd_texture *texture, const uint8_t wrap[2], float u,
                                      float v)
{
    struct rnd_texel sum = {0};
    const struct rnd_level *level = &texture->level[0];
    const float x = rnd_wrap(u, wrap[0]) * (float)level->width - 0.5f,
                y = rnd_wrap(v, wrap[1]) * (float)level->height - 0.5f;
    const float fx = x - floorf(x), fy = y - floorf(y);
    for (int i = 0; i < 4; i++) {
        const float weight = (i & 1 ? fx : 1.0f - fx) * (i >> 1 ? fy : 1.0f - fy);
        const struct rnd_texel t = rnd_texture_texel(
            texture, rnd_texel_index(level, wrap, (int)floorf(x) + (i & 1), (int)floorf(y) + (i >> 1)));
        sum.r += weight * t.r, sum.g += weight * t.g, sum.b += weight * t.b, sum.a += weight * t.a;
    }
    return sum;
}
