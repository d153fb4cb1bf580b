/* Textures: asked for at import, read by several threads, kept with their mipmaps under a cap of memory. */
#include "large_pages.h"
#include "scene/image_reader.h"
#include "scene/scene.h"
#include "scene/texture.h"
#include "scene/srgb.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Of all textures with their mipmaps; what is over it loses its finest levels. */
static const uint64_t CAP_BYTES = (uint64_t)2 << 30;

void rnd_texture_finish(struct rnd_texture *texture)
{
    free(texture->path);
    free(texture->error);
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

/* Mean of four texels of bytes, in linear light. */
static void mean_bytes(bool srgb, const uint8_t *const from[4], uint8_t to[4])
{
    for (int c = 0; c < 4; c++) {
        if (srgb && c < 3) {
            float sum = 0.0f;
            for (int k = 0; k < 4; k++) sum += rnd_srgb_decode(from[k][c]);
            to[c] = rnd_srgb_byte(0.25f * sum);
        } else {
            to[c] = (uint8_t)((from[0][c] + from[1][c] + from[2][c] + from[3][c] + 2) / 4);
        }
    }
}

static void mean_floats(const float *const from[4], float to[4])
{
    for (int c = 0; c < 4; c++) to[c] = 0.25f * (from[0][c] + from[1][c] + from[2][c] + from[3][c]);
}

/* Every level is the mean of the one above it; an odd last row or column is left out. */
static void fill_levels(struct rnd_texture *texture)
{
    for (int l = 1; l < texture->levels; l++) {
        const struct rnd_level *from = &texture->level[l - 1], *to = &texture->level[l];
        const size_t right = from->width > 1, down = from->height > 1 ? (size_t)from->width : 0;
        for (int y = 0; y < to->height; y++)
            for (int x = 0; x < to->width; x++) {
                const size_t i = from->first + 2 * (size_t)y * down + 2 * (size_t)x * right,
                             k = to->first + (size_t)y * to->width + x;
                const size_t at[4] = {4 * i, 4 * (i + right), 4 * (i + down), 4 * (i + right + down)};
                if (texture->floats) {
                    const float *f = texture->floats;
                    mean_floats((const float *const[4]){f + at[0], f + at[1], f + at[2], f + at[3]},
                                texture->floats + 4 * k);
                } else {
                    const uint8_t *b = texture->bytes;
                    mean_bytes(texture->use != RND_PIXELS_DATA,
                               (const uint8_t *const[4]){b + at[0], b + at[1], b + at[2], b + at[3]},
                               texture->bytes + 4 * k);
                }
            }
    }
}

/* --- reading --- */

/* Note why it cannot be read. */
static bool fail(struct rnd_texture *texture, const char *what, const char *why)
{
    char text[RND_ERROR_SIZE];
    snprintf(text, sizeof text, "%.200s: %s%.200s", texture->path, what, why);
    texture->levels = 0;
    texture->error = strdup(text);
    return false;
}

/* A picture that becomes a texture. */
struct filling {
    struct rnd_pixels_sink sink; /* first */
    struct rnd_texture *texture;
    size_t channels;
};

static bool begin(struct rnd_pixels_sink *sink, const struct rnd_picture *picture)
{
    struct filling *filling = (struct filling *)(void *)sink;
    struct rnd_texture *texture = filling->texture;
    const size_t count = lay_out(texture, picture->width, picture->height),
                 n = filling->channels = (size_t)picture->channels;
    texture->log2_size = 0.5f * log2f((float)picture->width * (float)picture->height);
    texture->has_alpha = n == 2 || n >= 4;
    if (picture->bytes)
        texture->bytes = malloc(count * 4);
    else
        texture->floats = malloc(count * 4 * sizeof *texture->floats);
    rnd_use_large_pages(texture->floats, count * 4 * sizeof *texture->floats);
    rnd_use_large_pages(texture->bytes, count * 4);
    return texture->floats || texture->bytes;
}

/* Rows of the first level from the file's pixels: RGBA; missing channels repeat the first, alpha is 1. */
static bool take_rows(struct rnd_pixels_sink *sink, int first, int rows, const void *pixels)
{
    const struct filling *filling = (const struct filling *)(const void *)sink;
    const struct rnd_texture *texture = filling->texture;
    const size_t width = (size_t)texture->level[0].width, count = (size_t)rows * width, n = filling->channels,
                 g = n >= 3 ? 1 : 0, b = 2 * g, a = texture->has_alpha ? (n == 2 ? 1 : 3) : 0;
    if (texture->floats)
        for (size_t i = 0; i < count; i++) {
            const float *from = (const float *)pixels + n * i;
            float *to = texture->floats + 4 * ((size_t)first * width + i);
            to[0] = from[0], to[1] = from[g], to[2] = from[b], to[3] = a ? from[a] : 1.0f;
        }
    else
        for (size_t i = 0; i < count; i++) {
            const uint8_t *from = (const uint8_t *)pixels + n * i;
            uint8_t *to = texture->bytes + 4 * ((size_t)first * width + i);
            to[0] = from[0], to[1] = from[g], to[2] = from[b], to[3] = a ? from[a] : 255;
        }
    return true;
}

bool rnd_texture_load(struct rnd_texture *texture, struct rnd_image_reader *reader)
{
    struct filling filling = {.sink = {begin, take_rows}, .texture = texture};
    char text[RND_ERROR_SIZE / 2];
    if (texture->error) return false;
    if (rnd_image_read_apart(reader, texture->path, texture->file, texture->file_bytes, texture->use, true,
                             &filling.sink, text, sizeof text)) {
        fill_levels(texture);
        return true;
    }
    free(texture->bytes);
    free(texture->floats);
    texture->bytes = NULL;
    texture->floats = NULL;
    return fail(texture, strncmp(text, "the reader", 10) == 0 ? "" : "not a readable image: ", text);
}

/* --- the cap of memory --- */

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

/* The largest textures first: what the film cannot show is lost before what it can. */
void rnd_textures_cap(struct rnd_scene *scene)
{
    for (;;) {
        struct rnd_texture *largest = NULL;
        scene->info.texture_bytes = 0;
        for (uint32_t i = 0; i < scene->texture_count; i++) {
            struct rnd_texture *texture = &scene->texture[i];
            if (texture->levels == 0) continue;
            scene->info.texture_bytes += bytes_of(texture);
            if (!largest || bytes_of(texture) > bytes_of(largest)) largest = texture;
        }
        if (scene->info.texture_bytes <= CAP_BYTES || !drop_finest(largest)) return;
    }
}

/* --- reading, in parallel --- */

struct loading {
    struct rnd_scene *scene;
    bool first;
    _Atomic uint32_t next;
};

static void *load_some(void *argument)
{
    struct loading *loading = argument;
    struct rnd_scene *scene = loading->scene;
    struct rnd_image_reader reader = rnd_scene_reader(scene);
    for (;;) {
        const uint32_t i = atomic_fetch_add(&loading->next, 1);
        if (i >= scene->texture_count || atomic_load(&scene->cancelled)) break;
        struct rnd_texture *texture = &scene->texture[i];
        if (texture->levels == 0 && texture->first >= loading->first) rnd_texture_load(texture, &reader);
    }
    rnd_image_reader_finish(&reader);
    return NULL;
}

void rnd_textures_load(struct rnd_scene *scene, bool first)
{
    enum { MOST = 64 };
    const long threads = sysconf(_SC_NPROCESSORS_ONLN);
    struct loading loading = {.scene = scene, .first = first};
    pthread_t thread[MOST];
    int started = 0, count = 0;
    for (uint32_t i = 0; i < scene->texture_count; i++)
        count +=
            scene->texture[i].levels == 0 && !scene->texture[i].error && scene->texture[i].first >= first;
    if (count == 0) return;
    while (started < threads - 1 && started < MOST && started + 1 < count &&
           pthread_create(&thread[started], NULL, load_some, &loading) == 0)
        started++;
    load_some(&loading);
    while (started > 0) pthread_join(thread[--started], NULL);
}

void rnd_textures_drop_unread(struct rnd_scene *scene, struct rnd_warnings *warnings)
{
    bool any = false;
    for (uint32_t i = 0; i < scene->texture_count; i++) {
        const struct rnd_texture *texture = &scene->texture[i];
        if (!texture->error) continue;
        any = true;
        if (scene->warnings.text && strstr(scene->warnings.text, texture->error)) continue;
        rnd_warn(warnings, "%s; the material's factor is used alone", texture->error);
    }
    for (uint32_t i = 0; any && i < scene->material_count; i++)
        for (int use = 0; use < RND_MAPS; use++) {
            int *texture = &scene->material[i].map[use].texture;
            if (*texture >= 0 && scene->texture[*texture].error) *texture = -1;
        }
}

/* --- looking --- */

struct rnd_texel rnd_texture_at(const struct rnd_texture *texture, const uint8_t wrap[2], bool nearest,
                                float u, float v)
{
    if (nearest) return rnd_texture_texel(texture, rnd_texture_pick(texture, wrap, u, v, 0, 0.5f, 0.5f));
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
