/* Small scenes for tests of the renderer: a directory for them, OBJ boxes, glTF with an embedded buffer, and
 * the mean radiance that a render shows in a cone of directions. */
#ifndef FOVEAD_TESTS_RENDERER_FILES_H
#define FOVEAD_TESTS_RENDERER_FILES_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <ftw.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "../sanitized.h"
#include "renderer.h"

/* --- files --- */

static char files_directory[64];
static struct rnd_image_program *files_image_program_started;

/* The program that reads pictures is slow to start, so all scenes of a test share one. */
static inline struct rnd_image_program *files_image_program(void)
{
    if (!files_image_program_started) files_image_program_started = rnd_image_program_create();
    return files_image_program_started;
}

static inline int files_setup(void **state)
{
    (void)state;
    strcpy(files_directory, "/tmp/fovead-test-XXXXXX");
    return mkdtemp(files_directory) ? 0 : -1;
}

static inline int files_remove(const char *path, const struct stat *status, int kind, struct FTW *where)
{
    (void)status, (void)kind, (void)where;
    return remove(path);
}

static inline int files_teardown(void **state)
{
    (void)state;
    rnd_image_program_destroy(files_image_program_started);
    files_image_program_started = NULL;
    return nftw(files_directory, files_remove, 8, FTW_DEPTH | FTW_PHYS);
}

/* The path of a file with this name. It is valid until the sixteenth call after this one. */
static inline const char *files_path(const char *name)
{
    static char path[16][512];
    static int next;
    char *to = path[next++ % 16];
    snprintf(to, sizeof path[0], "%s/%s", files_directory, name);
    return to;
}

static inline const char *files_write(const char *name, const void *bytes, size_t count)
{
    const char *path = files_path(name);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, count, file), count);
    assert_int_equal(fclose(file), 0);
    return path;
}

static inline const char *files_text(const char *name, const char *text)
{
    return files_write(name, text, strlen(text));
}

/* Append a chunk of a PNG: length, name, data, CRC-32 (ISO 3309). */
static inline size_t files_chunk(uint8_t *to, const char *name, const void *data, uint32_t count)
{
    uint32_t crc = ~0u;
    memcpy(to + 4, name, 4);
    memcpy(to + 8, data, count);
    for (uint32_t i = 4; i < 8 + count; i++) {
        crc ^= to[i];
        for (int k = 0; k < 8; k++) crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0);
    }
    crc = ~crc;
    for (int k = 0; k < 4; k++) {
        to[k] = (uint8_t)(count >> (24 - 8 * k));
        to[8 + count + (uint32_t)k] = (uint8_t)(crc >> (24 - 8 * k));
    }
    return 12 + count;
}

/* Write a PNG of 2 x 1 equal pixels into `out`, with 8 or 16 bits; all four channels have this value. gamma
 * is 100000 times the value of its gAMA chunk, or 0 for none. Returns the size, at most 128 bytes. */
static inline size_t files_png_bytes(uint8_t *out, int bits, unsigned value, uint32_t gamma)
{
    static const uint8_t signature[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    const uint8_t head[13] = {0, 0, 0, 2, 0, 0, 0, 1, (uint8_t)bits, 6},
                  exponent[4] = {(uint8_t)(gamma >> 24), (uint8_t)(gamma >> 16), (uint8_t)(gamma >> 8),
                                 (uint8_t)gamma};
    const int row = 1 + bits; /* its filter byte, then two pixels of four channels */
    uint32_t a = 1, b = 0;    /* Adler-32 of the row */
    uint8_t data[7 + 17 + 4] = {0x78, 1, 1, (uint8_t)row, 0, (uint8_t)~row, 0xff}; /* zlib: stored */
    for (int i = 1; i < row; i++) data[7 + i] = (uint8_t)(bits == 16 && i % 2 ? value >> 8 : value);
    for (int i = 0; i < row; i++) a = (a + data[7 + i]) % 65521, b = (b + a) % 65521;
    for (int k = 0; k < 4; k++) data[7 + row + k] = (uint8_t)((b << 16 | a) >> (24 - 8 * k));
    memcpy(out, signature, sizeof signature);
    size_t n = sizeof signature;
    n += files_chunk(out + n, "IHDR", head, sizeof head);
    if (gamma) n += files_chunk(out + n, "gAMA", exponent, sizeof exponent);
    n += files_chunk(out + n, "IDAT", data, (uint32_t)(11 + row));
    return n + files_chunk(out + n, "IEND", "", 0);
}

static inline const char *files_png(const char *name, int bits, unsigned value, uint32_t gamma)
{
    uint8_t bytes[128];
    return files_write(name, bytes, files_png_bytes(bytes, bits, value, gamma));
}

/* Like rnd_image_write(), but to a path. */
static inline bool files_image(const char *path, int width, int height, const float *rgb,
                               bool equirectangular, char out_error[RND_ERROR_SIZE])
{
    FILE *file = fopen(path, "wb");
    bool good;
    assert_non_null(file);
    good = rnd_image_write(file, path, width, height, rgb, equirectangular, out_error);
    return fclose(file) == 0 && good;
}

/* Write an environment map of constant radiance. */
static inline const char *files_env(const char *name, float radiance)
{
    enum { WIDTH = 32, HEIGHT = 16 };
    float rgb[WIDTH * HEIGHT * 3];
    char error[RND_ERROR_SIZE];
    const char *path = files_path(name);
    for (int i = 0; i < WIDTH * HEIGHT * 3; i++) rgb[i] = radiance;
    if (!files_image(path, WIDTH, HEIGHT, rgb, true, error)) fail_msg("%s", error);
    return path;
}

/* Append a closed box to the text of an OBJ. Its faces look outwards. */
static inline void files_box(char *text, size_t size, const char *material, const double low[3],
                             const double high[3])
{
    size_t n = strlen(text);
    n += (size_t)snprintf(text + n, size - n, "usemtl %s\n", material);
    for (int i = 0; i < 8; i++)
        n += (size_t)snprintf(text + n, size - n, "v %.9g %.9g %.9g\n", i & 1 ? high[0] : low[0],
                              i & 2 ? high[1] : low[1], i & 4 ? high[2] : low[2]);
    snprintf(text + n, size - n,
             "f -8 -6 -5 -7\nf -4 -3 -1 -2\nf -8 -7 -3 -4\nf -6 -2 -1 -5\nf -8 -4 -2 -6\nf -7 -5 -1 -3\n");
}

/* Encode at most 64 kB as base64. The text is valid until the next call. */
static inline const char *files_base64(const void *bytes, size_t count)
{
    static const char digit[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    static char text[90000];
    const uint8_t *b = bytes;
    size_t n = 0;
    assert_true(count <= 65536);
    for (size_t i = 0; i < count; i += 3) {
        const uint32_t three =
            (uint32_t)b[i] << 16 | (i + 1 < count ? b[i + 1] << 8 : 0) | (i + 2 < count ? b[i + 2] : 0);
        text[n++] = digit[three >> 18];
        text[n++] = digit[three >> 12 & 63];
        text[n++] = i + 1 < count ? digit[three >> 6 & 63] : '=';
        text[n++] = i + 2 < count ? digit[three & 63] : '=';
    }
    text[n] = 0;
    return text;
}

/* A square in the plane y = 0 that faces up, with sides of 2 half metres and texture coordinates from 0 to 1
 * along x and z: its vertices and indices. */
struct files_square {
    float vertex[20];
    uint16_t index[6];
};

static inline struct files_square files_square(float half)
{
    return (struct files_square){
        .vertex = {-half, 0, -half, -half, 0, half, half, 0, half, half, 0, -half, 0, 0, 0, 1, 1, 1, 1, 0},
        .index = {0, 1, 2, 0, 2, 3}};
}

/* Write the glTF of that square into text, and return its length. All parts are JSON: `nodes` name mesh 0,
 * the mesh has the first of `materials`, `more` is anything else and begins with a comma, and `uri` is the
 * key of the buffer's URI, which also begins with a comma, or "". */
static inline size_t files_gltf_text(char *text, size_t size, float half, const char *nodes,
                                     const char *materials, const char *more, const char *uri)
{
    return (size_t)snprintf(
        text, size,
        "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\n\"nodes\":[%s],\n"
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"TEXCOORD_0\":1},\"indices\":2,"
        "\"material\":0}]}],\n\"materials\":[%s],\n"
        "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\",\"min\":[%g,0,"
        "%g],"
        "\"max\":[%g,0,%g]},{\"bufferView\":1,\"componentType\":5126,\"count\":4,\"type\":\"VEC2\"},"
        "{\"bufferView\":2,\"componentType\":5123,\"count\":6,\"type\":\"SCALAR\"}],\n"
        "\"bufferViews\":[{\"buffer\":0,\"byteOffset\":0,\"byteLength\":48},"
        "{\"buffer\":0,\"byteOffset\":48,\"byteLength\":32},{\"buffer\":0,\"byteOffset\":80,\"byteLength\":"
        "12}],\n"
        "\"buffers\":[{\"byteLength\":92%s}]%s}\n",
        nodes, materials, -half, -half, half, half, uri, more);
}

/* Write it as .gltf with its buffer embedded as base64. */
static inline const char *files_gltf(const char *name, float half, const char *nodes, const char *materials,
                                     const char *more)
{
    static char text[600000], uri[400];
    const struct files_square square = files_square(half);
    snprintf(uri, sizeof uri, ",\"uri\":\"data:application/octet-stream;base64,%.200s\"",
             files_base64(&square, 92));
    files_gltf_text(text, sizeof text, half, nodes, materials, more, uri);
    return files_text(name, text);
}

/* Write it as .glb, whose second chunk is the buffer. */
static inline const char *files_glb(const char *name, float half, const char *nodes, const char *materials,
                                    const char *more)
{
    static char bytes[100000];
    const struct files_square square = files_square(half);
    size_t json = files_gltf_text(bytes + 20, sizeof bytes - 200, half, nodes, materials, more, "");
    while (json % 4) bytes[20 + json++] = ' ';
    const uint32_t head[5] = {0x46546c67, 2, (uint32_t)json + 20 + 8 + 92, (uint32_t)json, 0x4e4f534a},
                   chunk[2] = {92, 0x004e4942};
    memcpy(bytes, head, sizeof head);
    memcpy(bytes + 20 + json, chunk, sizeof chunk);
    memcpy(bytes + 28 + json, &square, 92);
    return files_write(name, bytes, 120 + json);
}

/* Write a room of 4 x 3 x 4 m around the origin with coloured walls, an emitter, a glossy box, a mirror and a
 * glass box. */
static inline const char *files_room(const char *name)
{
    static char text[8000];
    files_text("room.mtl",
               "newmtl wall\nKd 0.7 0.65 0.6\nnewmtl red\nKd 0.6 0.1 0.1\nnewmtl emitter\nKd 0 0 0\n"
               "Ke 12 11 9\nnewmtl glossy\nKd 0.2 0.3 0.5\nKs 0.5 0.5 0.5\nNs 60\nillum 2\n"
               "newmtl mirror\nKd 0 0 0\nKs 0.9 0.9 0.8\nillum 3\nnewmtl glass\nNi 1.5\nillum 7\n");
    strcpy(text, "mtllib room.mtl\n");
    files_box(text, sizeof text, "wall", (double[]){-2, -1.5, -2}, (double[]){2, 1.5, 2});
    files_box(text, sizeof text, "emitter", (double[]){-0.5, 1.4, -1.2}, (double[]){0.5, 1.45, -0.4});
    files_box(text, sizeof text, "red", (double[]){-1.9, -1.4, -1.9}, (double[]){-1.8, 1.4, 1.9});
    files_box(text, sizeof text, "glossy", (double[]){0.4, -1.5, -1.6}, (double[]){1.2, -0.6, -0.8});
    files_box(text, sizeof text, "mirror", (double[]){-1, -1, 1.8}, (double[]){1, 1, 1.85});
    files_box(text, sizeof text, "glass", (double[]){-0.9, -0.8, -1.3}, (double[]){-0.3, -0.1, -1});
    return files_text(name, text);
}

/* --- scenes and what they show --- */

static inline struct rnd_scene *files_load(const char *path, const char *env, const float *sun,
                                           const float *camera)
{
    struct rnd_scene_options options = {.path = path,
                                        .image_program = files_image_program(),
                                        .env_path = env,
                                        .has_sun = sun,
                                        .has_camera = camera};
    char error[RND_ERROR_SIZE];
    if (sun) memcpy(options.sun, sun, sizeof options.sun);
    for (int k = 0; camera && k < 3; k++) options.camera[k] = (double)camera[k];
    struct rnd_scene *scene = rnd_scene_load(&options, error);
    if (!scene) fail_msg("%s", error);
    return scene;
}

/* Does the scene list this file among its files? The file need not exist. */
static inline bool files_named(const struct rnd_scene_info *info, const char *path)
{
    struct stat file, other;
    const bool is_there = stat(path, &file) == 0;
    for (size_t at = 0; at < info->files_bytes; at += strlen(info->files + at) + 1) {
        const bool other_is_there = stat(info->files + at, &other) == 0;
        if (is_there && other_is_there && file.st_ino == other.st_ino && file.st_dev == other.st_dev)
            return true;
        if (!is_there && strcmp(info->files + at, path) == 0) return true;
    }
    return false;
}

static inline struct rnd_aim files_aim(double x, double y, double z)
{
    const double l = sqrt(x * x + y * y + z * z);
    return (struct rnd_aim){.gaze = {(float)(x / l), (float)(y / l), (float)(z / l)},
                            .view = {0, 0, 0, 1},
                            .fov = {1.5f, 1.5f},
                            .sequence = 1};
}

/* The tolerance of a mean over many paths: four times as large where files_radiance() traces fewer. */
static inline double files_off(double off)
{
    return SANITIZED ? 4.0 * off : off;
}

/* Render, and return the mean radiance of the pixels whose middle is in a cone around the gaze with a half
 * angle of cone_deg (180: everywhere). A sanitized build traces a sixteenth of the paths, but at least one
 * batch of 20,000. */
static inline double files_radiance(const struct rnd_scene *scene, const char *distribution, int max_bounces,
                                    uint32_t paths, const struct rnd_aim *aim, double cone_deg,
                                    float out_rgb[3])
{
    enum { WIDTH = 256, HEIGHT = 128, BATCH = 20000 };
    static float rgb[WIDTH * HEIGHT * 3], samples[WIDTH * HEIGHT];
    const struct rnd_render_options options = {.width = WIDTH,
                                               .height = HEIGHT,
                                               .seed = 7,
                                               .max_bounces = max_bounces,
                                               .distribution = rnd_distribution_find(distribution)};
    char error[RND_ERROR_SIZE];
    struct rnd_render *render = rnd_render_create(scene, &options, error);
    if (!render) fail_msg("%s", error);
    struct rnd_batch batch;
    if (SANITIZED) paths /= 16;
    for (uint32_t done = 0; done == 0 || done < paths; done += BATCH) {
        rnd_render_batch(render, aim, 0, BATCH, &batch);
        assert_int_equal(batch.not_finite, 0);
    }
    rnd_render_resolve(render, rgb, samples, NULL);
    rnd_render_destroy(render);
    double sum[3] = {0}, weight = 0.0;
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        const double azimuth = ((i % WIDTH + 0.5) / WIDTH - 0.5) * 2.0 * M_PI,
                     elevation = (0.5 - (i / WIDTH + 0.5) / HEIGHT) * M_PI;
        const double along = cos(elevation) * sin(azimuth) * aim->gaze[0] + sin(elevation) * aim->gaze[1] -
                             cos(elevation) * cos(azimuth) * aim->gaze[2];
        if (along < cos(cone_deg * M_PI / 180.0)) continue;
        for (int c = 0; c < 3; c++) sum[c] += (double)rgb[3 * i + c] * samples[i];
        weight += samples[i];
    }
    assert_true(weight > (SANITIZED ? 200 : 1000));
    for (int c = 0; out_rgb && c < 3; c++) out_rgb[c] = (float)(sum[c] / weight);
    return (0.2126 * sum[0] + 0.7152 * sum[1] + 0.0722 * sum[2]) / weight;
}

#endif
