/* Write glTF files from parts, each with a buffer, a view and an accessor of its own. */
#ifndef FOVEAD_TESTS_RENDERER_PARTS_H
#define FOVEAD_TESTS_RENDERER_PARTS_H

#include "renderer_files.h"

#include "import/image_io.h"
#include "scene/scene.h"

/* Print a measured value, and check that it is near the expected one. */
static inline void assert_within(const char *what, double value, double expected, double relative)
{
    print_message("%-52s %.5f of %.5f: %+.3f %%\n", what, value, expected, 100.0 * (value / expected - 1.0));
    assert_true(fabs(value / expected - 1.0) < files_off(relative));
}

/* Pixels in memory. */
struct files_floats {
    struct rnd_pixels_source source; /* first */
    const float *data;
    size_t row; /* values */
};

static inline void files_rows(struct rnd_pixels_source *source, int first, int count, float *out_pixels)
{
    const struct files_floats *floats = (const struct files_floats *)(const void *)source;
    memcpy(out_pixels, floats->data + (size_t)first * floats->row,
           (size_t)count * floats->row * sizeof *out_pixels);
}

/* Write a picture of any channels: like rnd_pixels_write(), but to a path. */
static inline void files_pixels(const char *path, const char *format, int width, int height, int channels,
                                const struct rnd_channel *channel, const float *data)
{
    struct rnd_layout layout = {.width = width, .height = height, .channels = channels};
    struct files_floats floats = {{files_rows}, data, (size_t)width * (size_t)channels};
    char error[RND_ERROR_SIZE];
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    strcpy(layout.format, format);
    memcpy(layout.channel, channel, (size_t)channels * sizeof *channel);
    if (!rnd_pixels_write(file, &layout, &floats.source, error, sizeof error)) fail_msg("%s", error);
    assert_int_equal(fclose(file), 0);
}

/* Write an OBJ of one box with this material, which is named m. */
static inline const char *files_box_scene(const char *name, const char *material, const double low[3],
                                          const double high[3])
{
    char text[2000], file[64];
    snprintf(file, sizeof file, "%s.mtl", name);
    files_text(file, material);
    snprintf(text, sizeof text, "mtllib %s\n", file);
    files_box(text, sizeof text, "m", low, high);
    snprintf(file, sizeof file, "%s.obj", name);
    return files_text(file, text);
}

#define NEAR(a, b) assert_float_equal(a, b, 1e-4)

/* Part i has buffer, view and accessor i. `accessor` holds the accessor's keys except the view; if it is
 * NULL, neither this part nor a later one has an accessor. */
struct files_part {
    const void *bytes;
    size_t size;
    const char *accessor;
};

static const float files_corners[12] = {-1, 0, -1, -1, 0, 1, 1, 0, 1, 1, 0, -1},
                   files_uvs[8] = {0, 0, 0, 1, 1, 1, 1, 0};
static const uint16_t files_two[6] = {0, 1, 2, 0, 2, 3};

#define FILES_SQUARE                                                                                         \
    {files_corners, sizeof files_corners,                                                                    \
     "\"componentType\":5126,\"count\":4,\"type\":\"VEC3\",\"min\":[-1,0,-1],"                               \
     "\"max\":[1,0,1]"},                                                                                     \
        {files_uvs, sizeof files_uvs, "\"componentType\":5126,\"count\":4,\"type\":\"VEC2\""},               \
    {                                                                                                        \
        files_two, sizeof files_two, "\"componentType\":5123,\"count\":6,\"type\":\"SCALAR\""                \
    }

/* A diffuse material of albedo 1/2. */
#define FILES_GREY                                                                                           \
    "{\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.5,0.5,0.5,1],\"metallicFactor\":0},"                  \
    "\"extensions\":{\"KHR_materials_specular\":{\"specularFactor\":0}}}"

/* The primitives of two meshes, which are the square with the first and with the second material. */
static const char files_two_squares[] =
    "{\"attributes\":{\"POSITION\":0},\"indices\":2,\"material\":0}]},{\"primitives\":["
    "{\"attributes\":{\"POSITION\":0},\"indices\":2,\"material\":1}";

static const char files_primitive[] =
    "{\"attributes\":{\"POSITION\":0,\"TEXCOORD_0\":1},\"indices\":2,\"material\":0}";

static inline const char *files_parts(const char *name, const char *primitive, const char *nodes,
                                      const char *materials, const char *more, const struct files_part *part,
                                      size_t count)
{
    static char text[1100000], list[3][200000]; /* large enough for all parts */
    size_t n[3] = {0};
    for (size_t i = 0; i < count; i++) {
        const char *comma = i ? "," : "";
        n[0] += (size_t)snprintf(list[0] + n[0], sizeof list[0] - n[0],
                                 "%s{\"byteLength\":%zu,\"uri\":\"data:application/octet-stream;base64,%s\"}",
                                 comma, part[i].size, files_base64(part[i].bytes, part[i].size));
        n[1] += (size_t)snprintf(list[1] + n[1], sizeof list[1] - n[1],
                                 "%s{\"buffer\":%zu,\"byteLength\":%zu}", comma, i, part[i].size);
        if (part[i].accessor)
            n[2] += (size_t)snprintf(list[2] + n[2], sizeof list[2] - n[2], "%s{\"bufferView\":%zu,%s}",
                                     comma, i, part[i].accessor);
    }
    snprintf(text, sizeof text,
             "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[%s],"
             "\"meshes\":[{\"primitives\":[%s]}],\"materials\":[%s],\"buffers\":[%s],\"bufferViews\":[%s],"
             "\"accessors\":[%s]%s}",
             nodes, primitive, materials, list[0], list[1], list[2], more);
    return files_text(name, text);
}

#endif
