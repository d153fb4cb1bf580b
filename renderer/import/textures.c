/* Textures: added at import, read by several threads, and kept with mipmaps within a limit of memory. */
#include "import/textures.h"
#include "import/pictures.h"
#include "math/large_pages.h"
#include "math/srgb.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Most bytes of all textures with their mipmaps; beyond it they lose their finest levels. */
static const uint64_t CAP_BYTES = (uint64_t)2 << 30;

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

/* Make a level of width x height RGBA from the finer one: each texel is the mean of four; an odd last row or
 * column is left out. from has from_width texels per row. right: there is more than one column; down: more
 * than one row. */
static void halve(const struct rnd_texture *texture, const void *from, int from_width, bool down, void *to,
                  int width, int height)
{
    const size_t right = from_width > 1, below = down ? (size_t)from_width : 0;
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            const size_t i = 2 * (size_t)y * below + 2 * (size_t)x * right,
                         k = (size_t)y * (size_t)width + (size_t)x;
            const size_t at[4] = {4 * i, 4 * (i + right), 4 * (i + below), 4 * (i + right + below)};
            if (texture->floats) {
                const float *f = from;
                mean_floats((const float *const[4]){f + at[0], f + at[1], f + at[2], f + at[3]},
                            (float *)to + 4 * k);
            } else {
                const uint8_t *b = from;
                mean_bytes(texture->use != RND_PIXELS_DATA,
                           (const uint8_t *const[4]){b + at[0], b + at[1], b + at[2], b + at[3]},
                           (uint8_t *)to + 4 * k);
            }
        }
}

static size_t texel_bytes(const struct rnd_texture *texture)
{
    return texture->floats ? 4 * sizeof(float) : 4;
}

static uint8_t *level_at(const struct rnd_texture *texture, int level)
{
    uint8_t *memory = texture->floats ? (uint8_t *)texture->floats : texture->bytes;
    return memory + texture->level[level].first * texel_bytes(texture);
}

static void fill_levels(struct rnd_texture *texture)
{
    for (int l = 1; l < texture->levels; l++) {
        const struct rnd_level *from = &texture->level[l - 1], *to = &texture->level[l];
        halve(texture, level_at(texture, l - 1), from->width, from->height > 1, level_at(texture, l),
              to->width, to->height);
    }
}

/* --- the cap of memory --- */

static int half(int size)
{
    return size > 1 ? size / 2 : 1;
}

/* Bytes of a picture of that size with its mipmaps, without the finest ones. */
static uint64_t bytes_without(int width, int height, bool bytes, int skip)
{
    struct rnd_texture texture;
    for (; skip > 0; skip--) width = half(width), height = half(height);
    return lay_out(&texture, width, height) * (bytes ? 4 : 4 * sizeof(float));
}

/* Decide how many finest levels each measured texture loses, the largest first: the film can hardly show
 * their finest levels. */
static void plan(struct rnd_scene *scene)
{
    for (;;) {
        struct rnd_texture *largest = NULL;
        uint64_t all = 0, most = 0;
        for (uint32_t i = 0; i < scene->texture_count; i++) {
            struct rnd_texture *t = &scene->texture[i];
            if (t->measured.width == 0) continue;
            const uint64_t bytes =
                bytes_without(t->measured.width, t->measured.height, t->measured.bytes, t->skip);
            all += bytes;
            if (bytes > most) most = bytes, largest = t;
        }
        if (all <= CAP_BYTES) return;
        largest->skip++;
    }
}

void rnd_textures_sum(struct rnd_scene *scene)
{
    scene->info.texture_bytes = 0;
    for (uint32_t i = 0; i < scene->texture_count; i++) {
        const struct rnd_texture *t = &scene->texture[i];
        if (t->levels > 0) scene->info.texture_bytes += (t->level[t->levels - 1].first + 1) * texel_bytes(t);
    }
}

/* --- reading --- */

/* Note why a texture cannot be read. Returns false. */
static bool fail(struct rnd_texture *texture, const char *why)
{
    char text[RND_ERROR_SIZE];
    snprintf(text, sizeof text, "%.200s: %.200s", texture->path, why);
    texture->levels = 0;
    texture->error = strdup(text);
    return false;
}

/* A picture that becomes a texture. */
struct filling {
    struct rnd_pixels_sink sink; /* first */
    struct rnd_texture *texture;
    size_t channels;
    int width, height; /* of the file's picture */
    /* For a texture without its finest levels: [0] holds the rows that make one row of the texture, RGBA; [1]
     * is room for halving them. */
    uint8_t *band[2];
    bool changed;   /* the file has changed since it was measured */
    int rows, have; /* rows of a band: in all, and so far */
    int next;       /* the next row of the texture */
};

static bool begin(struct rnd_pixels_sink *sink, const struct rnd_picture *picture)
{
    struct filling *filling = (struct filling *)(void *)sink;
    struct rnd_texture *texture = filling->texture;
    const size_t texel = picture->bytes ? 4 : 4 * sizeof(float),
                 n = filling->channels = (size_t)picture->channels;
    int width = filling->width = picture->width, height = filling->height = picture->height;
    filling->changed = texture->measured.width > 0 &&
                       (texture->measured.width != width || texture->measured.height != height ||
                        texture->measured.bytes != picture->bytes);
    if (filling->changed) return false;
    if (texture->measured.width == 0) /* nothing was measured: there is only one */
        while (bytes_without(width, height, picture->bytes, texture->skip) > CAP_BYTES) texture->skip++;
    filling->rows = 1;
    for (int k = 0; k < texture->skip; k++) {
        if (height > 1) filling->rows *= 2;
        width = half(width);
        height = half(height);
    }
    const size_t count = lay_out(texture, width, height),
                 band = (size_t)filling->rows * (size_t)filling->width * texel;
    texture->log2_size = 0.5f * log2f((float)picture->width * (float)picture->height) - (float)texture->skip;
    texture->has_alpha = n == 2 || n >= 4;
    if (picture->bytes)
        texture->bytes = malloc(count * 4);
    else
        texture->floats = malloc(count * 4 * sizeof *texture->floats);
    rnd_use_large_pages(texture->floats, count * 4 * sizeof *texture->floats);
    rnd_use_large_pages(texture->bytes, count * 4);
    for (int i = 0; i < 2 && texture->skip > 0; i++)
        if (!(filling->band[i] = malloc(band))) return false;
    return texture->floats || texture->bytes;
}

/* Texels as RGBA; missing channels repeat the first, alpha is 1. */
static void to_rgba(const struct filling *filling, const void *pixels, size_t count, void *out)
{
    const size_t n = filling->channels, g = n >= 3 ? 1 : 0, b = 2 * g,
                 a = filling->texture->has_alpha ? (n == 2 ? 1 : 3) : 0;
    if (filling->texture->floats)
        for (size_t i = 0; i < count; i++) {
            const float *from = (const float *)pixels + n * i;
            float *to = (float *)out + 4 * i;
            to[0] = from[0], to[1] = from[g], to[2] = from[b], to[3] = a ? from[a] : 1.0f;
        }
    else
        for (size_t i = 0; i < count; i++) {
            const uint8_t *from = (const uint8_t *)pixels + n * i;
            uint8_t *to = (uint8_t *)out + 4 * i;
            to[0] = from[0], to[1] = from[g], to[2] = from[b], to[3] = a ? from[a] : 255;
        }
}

/* A row of the texture from a band that is full. */
static void take_band(struct filling *filling)
{
    const struct rnd_texture *texture = filling->texture;
    const size_t row = (size_t)texture->level[0].width * texel_bytes(texture);
    int width = filling->width, height = filling->height, rows = filling->rows;
    for (int k = 0; k < texture->skip; k++) {
        const bool down = height > 1;
        if (down) rows /= 2;
        halve(texture, filling->band[0], width, down, filling->band[1], half(width), rows);
        uint8_t *other = filling->band[0];
        filling->band[0] = filling->band[1];
        filling->band[1] = other;
        width = half(width);
        height = half(height);
    }
    memcpy(level_at(texture, 0) + (size_t)filling->next++ * row, filling->band[0], row);
    filling->have = 0;
}

static bool take_rows(struct rnd_pixels_sink *sink, int first, int rows, const void *pixels)
{
    struct filling *filling = (struct filling *)(void *)sink;
    const struct rnd_texture *texture = filling->texture;
    const size_t width = (size_t)filling->width, texel = texel_bytes(texture),
                 row = width * filling->channels * (texel / 4);
    if (texture->skip == 0) {
        to_rgba(filling, pixels, (size_t)rows * width, level_at(texture, 0) + (size_t)first * width * texel);
        return true;
    }
    for (int y = 0; y < rows && filling->next < texture->level[0].height; y++) {
        to_rgba(filling, (const uint8_t *)pixels + (size_t)y * row, width,
                filling->band[0] + (size_t)filling->have * width * texel);
        if (++filling->have == filling->rows) take_band(filling);
    }
    return true;
}

static struct rnd_pixels_file file_of(const struct rnd_texture *texture)
{
    return (struct rnd_pixels_file){.path = texture->path,
                                    .memory = texture->file,
                                    .count = texture->file_bytes,
                                    .use = texture->use,
                                    .want_bytes = true};
}

bool rnd_texture_load(struct rnd_texture *texture, struct rnd_image_reader *reader)
{
    struct filling filling = {.sink = {begin, take_rows}, .texture = texture};
    char text[RND_ERROR_SIZE / 2];
    if (texture->error) return false;
    const struct rnd_pixels_file file = file_of(texture);
    if (rnd_image_read_apart(reader, &file, &filling.sink, text, sizeof text)) {
        fill_levels(texture);
        free(filling.band[0]);
        free(filling.band[1]);
        return true;
    }
    free(filling.band[0]);
    free(filling.band[1]);
    free(texture->bytes);
    free(texture->floats);
    texture->bytes = NULL;
    texture->floats = NULL;
    return fail(texture, filling.changed ? "it is another file by now" : text);
}

/* Ask how large a picture is. */
static void measure(struct rnd_texture *texture, struct rnd_image_reader *reader)
{
    char text[RND_ERROR_SIZE / 2];
    struct rnd_picture picture;
    const struct rnd_pixels_file file = file_of(texture);
    if (!rnd_image_size_apart(reader, &file, &picture, text, sizeof text)) {
        fail(texture, text);
        return;
    }
    texture->measured.width = picture.width;
    texture->measured.height = picture.height;
    texture->measured.bytes = picture.bytes;
}

/* --- reading, in parallel --- */

struct loading {
    struct rnd_scene *scene;
    bool first;   /* only textures that are marked as first */
    bool measure; /* only measure, and read nothing */
    _Atomic uint32_t next;
};

static bool is_wanted(const struct rnd_texture *texture, const struct loading *loading)
{
    return texture->levels == 0 && !texture->error && texture->first >= loading->first;
}

static void *load_some(void *argument)
{
    struct loading *loading = argument;
    struct rnd_scene *scene = loading->scene;
    struct rnd_image_reader reader = rnd_scene_reader(scene);
    for (;;) {
        const uint32_t i = atomic_fetch_add(&loading->next, 1);
        if (i >= scene->texture_count || atomic_load(&scene->cancelled)) break;
        struct rnd_texture *texture = &scene->texture[i];
        if (!is_wanted(texture, loading)) continue;
        if (loading->measure)
            measure(texture, &reader);
        else
            rnd_texture_load(texture, &reader);
    }
    rnd_image_reader_finish(&reader);
    return NULL;
}

static void load_all(struct loading *loading)
{
    enum { MOST = 64 };
    const long threads = sysconf(_SC_NPROCESSORS_ONLN);
    pthread_t thread[MOST];
    int started = 0, count = 0;
    for (uint32_t i = 0; i < loading->scene->texture_count; i++)
        count += is_wanted(&loading->scene->texture[i], loading);
    if (count == 0) return;
    while (started < threads - 1 && started < MOST && started + 1 < count &&
           pthread_create(&thread[started], NULL, load_some, loading) == 0)
        started++;
    load_some(loading);
    while (started > 0) pthread_join(thread[--started], NULL);
}

void rnd_textures_load(struct rnd_scene *scene, bool first)
{
    struct loading measuring = {.scene = scene, .measure = true}, loading = {.scene = scene, .first = first};
    bool any = false;
    for (uint32_t i = 0; i < scene->texture_count; i++) any |= is_wanted(&scene->texture[i], &loading);
    if (any && !scene->textures_measured && scene->texture_count > 1) {
        load_all(&measuring);
        plan(scene);
        scene->textures_measured = true;
    }
    load_all(&loading);
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
