/* Other programs read pictures and scenes: textures without their finest levels, large pictures, and
 * cancelled scenes. */
#include "renderer_files.h"

#include "import/textures.h"
#include "import/image_apart.h"
#include "import/image_packet.h"
#include "scene/scene.h"

#include <sys/socket.h>

/* A picture of noise. */
static const char *noise(const char *name, int width, int height)
{
    static float rgb[64 * 64 * 3];
    char error[RND_ERROR_SIZE];
    uint32_t state = 5;
    for (int i = 0; i < width * height * 3; i++) {
        state = state * 1664525u + 1013904223u;
        rgb[i] = (float)(state >> 8) * 0x1p-24f;
    }
    const char *path = files_path(name);
    if (!files_image(path, width, height, rgb, false, error)) fail_msg("%s", error);
    return path;
}

static struct rnd_image_reader reader(void)
{
    return (struct rnd_image_reader){.program = files_image_program(), .limits = {.mib = 1024}, .socket = -1};
}

static struct rnd_texture load(const char *path, enum rnd_pixels_use use, int skip)
{
    struct rnd_image_reader images = reader();
    struct rnd_texture texture = {.path = strdup(path), .use = use, .skip = skip};
    if (!rnd_texture_load(&texture, &images)) fail_msg("%s", texture.error);
    rnd_image_reader_finish(&images);
    return texture;
}

/* Levels that are kept are the same, bit for bit, as without a limit of memory. */
static void without_finest(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        int width, height;
    } pictures[] = {{"even.png", 64, 64}, {"odd.png", 37, 23},  {"odd.exr", 37, 23},
                    {"row.png", 64, 1},   {"three.exr", 3, 64}, {"column.png", 1, 50}};
    for (size_t i = 0; i < sizeof pictures / sizeof *pictures; i++)
        for (int use = RND_PIXELS_DATA; use <= RND_PIXELS_COLOUR; use++) {
            const char *path = noise(pictures[i].name, pictures[i].width, pictures[i].height);
            struct rnd_texture whole = load(path, (enum rnd_pixels_use)use, 0);
            for (int skip = 1; skip < whole.levels; skip++) {
                struct rnd_texture less = load(path, (enum rnd_pixels_use)use, skip);
                const size_t first = whole.level[skip].first,
                             count = whole.level[whole.levels - 1].first + 1 - first;
                assert_int_equal(less.levels, whole.levels - skip);
                assert_int_equal(less.level[0].width, whole.level[skip].width);
                assert_int_equal(less.level[0].height, whole.level[skip].height);
                assert_true(fabsf(less.log2_size - (whole.log2_size - (float)skip)) < 1e-5f);
                if (whole.bytes)
                    assert_memory_equal(less.bytes, whole.bytes + 4 * first, 4 * count);
                else
                    assert_memory_equal(less.floats, whole.floats + 4 * first, 4 * count * sizeof(float));
                rnd_texture_finish(&less);
            }
            rnd_texture_finish(&whole);
        }
}

/* The size of a picture, in a file or in memory, is read without its pixels. A file that is not a picture
 * gives one line. */
static void sizes(void **state)
{
    (void)state;
    struct rnd_image_reader images = reader();
    struct rnd_picture picture;
    char error[RND_ERROR_SIZE] = "";
    uint8_t bytes[128];
    const size_t count = files_png_bytes(bytes, 8, 128, 0);
    for (int turn = 0; turn < 2; turn++) {
        assert_true(rnd_image_size_apart(&images,
                                         &(struct rnd_pixels_file){.path = noise("odd.png", 37, 23),
                                                                   .use = RND_PIXELS_SRGB,
                                                                   .want_bytes = true},
                                         &picture, error, sizeof error));
        assert_int_equal(picture.width, 37);
        assert_int_equal(picture.height, 23);
        assert_true(picture.bytes);
        assert_true(rnd_image_size_apart(&images,
                                         &(struct rnd_pixels_file){.path = "inside.png",
                                                                   .memory = bytes,
                                                                   .count = count,
                                                                   .use = RND_PIXELS_SRGB,
                                                                   .want_bytes = true},
                                         &picture, error, sizeof error));
        assert_int_equal(picture.width, 2);
        assert_false(rnd_image_size_apart(
            &images,
            &(struct rnd_pixels_file){
                .path = files_text("text.png", "no picture"), .use = RND_PIXELS_SRGB, .want_bytes = true},
            &picture, error, sizeof error));
        assert_true(*error && !strchr(error, '\n'));
    }
    rnd_image_reader_finish(&images);
}

/* --- pictures of many packets, whose ends are not those of strips of rows --- */

/* A value that identifies its place, and is exact in half floats and in 8 bits. */
static float at(int x, int y, int c)
{
    return (float)((x * 31 + y * 17 + c * 5) % 256);
}

static const char *picture(const char *name, int width, int height, float scale)
{
    const char *path = files_path(name);
    float *rgb = malloc((size_t)width * (size_t)height * 3 * sizeof *rgb);
    char error[RND_ERROR_SIZE];
    assert_non_null(rgb);
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++)
            for (int c = 0; c < 3; c++)
                rgb[3 * ((size_t)y * (size_t)width + (size_t)x) + (size_t)c] = at(x, y, c) * scale;
    if (!files_image(path, width, height, rgb, false, error)) fail_msg("%s", error);
    free(rgb);
    return path;
}

/* An environment map of 1024 x 512 takes 6 MiB of floats, which is not a whole number of packets. */
static void large_environment(void **state)
{
    (void)state;
    static const int sizes[][2] = {{1024, 512}, {1000, 500}, {2047, 1023}, {64, 32}};
    for (int k = 0; k < 4; k++) {
        const int width = sizes[k][0], height = sizes[k][1];
        const char *env = picture("env.exr", width, height, 1.0f);
        const char *scene_path = files_gltf("floor.gltf", 1, "{\"mesh\":0}", "{}", "");
        struct rnd_scene *scene = files_load(scene_path, env, NULL, NULL);
        const struct rnd_env *map = scene->lights.env;
        size_t wrong = 0;
        assert_int_equal(map->width, width);
        assert_int_equal(map->height, height);
        for (int y = 0; y < height; y++)
            for (int x = 0; x < width; x++)
                for (int c = 0; c < 3; c++)
                    wrong += map->texel[(size_t)y * (size_t)width + (size_t)x][c] != at(x, y, c);
        assert_int_equal(wrong, 0);
        rnd_scene_destroy(scene);
    }
}

/* The same for textures, whose texels are bytes. */
static void large_texture(void **state)
{
    (void)state;
    static const int sizes[][2] = {{2048, 1024}, {2000, 1999}, {64, 64}};
    static const uint8_t wrap[2] = {0, 0};
    for (int k = 0; k < 3; k++) {
        const int width = sizes[k][0], height = sizes[k][1];
        picture("texture.png", width, height, 1.0f / 255.0f);
        const char *path = files_gltf(
            "floor.gltf", 1, "{\"mesh\":0}",
            "{\"emissiveFactor\":[1,1,1],\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0}}}",
            ",\"images\":[{\"uri\":\"texture.png\"}],\"textures\":[{\"source\":0}]");
        struct rnd_scene *scene = files_load(path, NULL, NULL, NULL);
        const struct rnd_texture *texture = &scene->texture[0];
        size_t wrong = 0, seen = 0;
        assert_int_equal(scene->texture_count, 1);
        assert_int_equal(texture->level[0].width, width);
        assert_int_equal(texture->level[0].height, height);
        for (int y = 0; y < height; y++)
            for (int x = 0; x < width; x += 7) {
                const struct rnd_texel t = rnd_texture_at(
                    texture, wrap, true, ((float)x + 0.5f) / (float)width, ((float)y + 0.5f) / (float)height);
                /* linear; the values were encoded as sRGB */
                wrong += !(fabsf(t.g - at(x, y, 1) / 255.0f) < 0.005f);
                seen++;
            }
        print_message("%d x %d: %zu of %zu wrong\n", width, height, wrong, seen);
        assert_int_equal(wrong, 0);
        rnd_scene_destroy(scene);
    }
}

/* --- a reading process that a hostile file has taken over --- */

struct counting {
    struct rnd_pixels_sink sink; /* first */
    int begun, rows;
};

static bool count_begin(struct rnd_pixels_sink *sink, const struct rnd_picture *picture)
{
    (void)picture;
    ((struct counting *)(void *)sink)->begun++;
    return true;
}

static bool count_rows(struct rnd_pixels_sink *sink, int first, int rows, const void *pixels)
{
    (void)first, (void)pixels;
    ((struct counting *)(void *)sink)->rows += rows;
    return true;
}

/* Read a picture when these packets have already arrived, followed by a byte that is no packet. */
static bool read_of(const enum rnd_image_packet *kind, const void *const *bytes, const size_t *count,
                    int packets, const atomic_bool *cancel, struct counting *out,
                    char out_error[RND_ERROR_SIZE])
{
    int pair[2];
    assert_int_equal(socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, pair), 0);
    for (int i = 0; i < packets; i++) assert_true(rnd_image_send(pair[1], kind[i], bytes[i], count[i], -1));
    assert_int_equal(write(pair[1], "?", 1), 1);
    struct rnd_image_reader images = reader();
    images.socket = pair[0];
    images.cancel[0] = cancel;
    *out = (struct counting){.sink = {count_begin, count_rows}};
    const bool ok = rnd_image_read_apart(&images,
                                         &(struct rnd_pixels_file){.path = noise("odd.png", 37, 23),
                                                                   .use = RND_PIXELS_SRGB,
                                                                   .want_bytes = true},
                                         &out->sink, out_error, RND_ERROR_SIZE);
    rnd_image_reader_finish(&images);
    close(pair[1]);
    return ok;
}

static void hostile(void **state)
{
    (void)state;
    static const atomic_bool no_more = true;
    static const float pixel[4] = {0};
    const struct rnd_picture one = {.width = 1, .height = 2, .channels = 4};
    const enum rnd_image_packet end[] = {RND_IMAGE_END}, begin[] = {RND_IMAGE_BEGIN, RND_IMAGE_DATA};
    const void *const nothing[] = {""}, *const half[] = {&one, pixel};
    const size_t none[] = {0}, sizes_of[] = {sizeof one, sizeof pixel};
    char error[RND_ERROR_SIZE] = "";
    struct counting got;
    /* An end without a beginning is not a picture. */
    assert_false(read_of(end, nothing, none, 1, NULL, &got, error));
    assert_int_equal(got.begun, 0);
    /* A process that ends in the middle of a picture is not replaced, because its picture has begun. */
    assert_false(read_of(begin, half, sizes_of, 2, NULL, &got, error));
    assert_int_equal(got.begun, 1);
    assert_int_equal(got.rows, 0);
    /* When the picture is no longer wanted, nothing that the process sends is read. */
    assert_false(read_of(begin, half, sizes_of, 2, &no_more, &got, error));
    assert_string_equal(error, "nobody wants it any more");
    assert_int_equal(got.begun, 0);
    /* If the process ends before the picture has begun, another process is asked. */
    assert_true(read_of(NULL, NULL, NULL, 0, NULL, &got, error));
    assert_int_equal(got.begun, 1);
    assert_int_equal(got.rows, 23);
}

/* --- data that is used many times --- */

enum { SIDE = 256, CORNERS = SIDE * SIDE, INDICES = 6 * (SIDE - 1) * (SIDE - 1), TIMES = 12 };

/* A glTF with this many meshes that all use the same bytes, a square of 130,050 triangles. */
static const char *square(int meshes)
{
    static float corner[CORNERS][3];
    static uint16_t index[INDICES];
    static char json[8192];
    const char *bin = files_path("square.bin");
    size_t n = 0, at = 0;
    for (int i = 0; i < CORNERS; i++) {
        corner[i][0] = (float)(i % SIDE);
        corner[i][2] = (float)(i / SIDE);
    }
    for (int y = 0; y + 1 < SIDE; y++)
        for (int x = 0; x + 1 < SIDE; x++)
            for (int k = 0; k < 6; k++)
                index[n++] = (uint16_t)((y + ("011100"[k] - '0')) * SIDE + x + ("000111"[k] - '0'));
    FILE *file = fopen(bin, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(corner, sizeof corner, 1, file), 1);
    assert_int_equal(fwrite(index, sizeof index, 1, file), 1);
    assert_int_equal(fclose(file), 0);
    at += (size_t)sprintf(
        json,
        "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"uri\":\"square.bin\",\"byteLength\":%zu}],"
        "\"bufferViews\":[{\"buffer\":0,\"byteLength\":%zu},"
        "{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu}],"
        "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":%d,\"type\":\"VEC3\","
        "\"min\":[0,0,0],\"max\":[255,0,255]},"
        "{\"bufferView\":1,\"componentType\":5123,\"count\":%d,\"type\":\"SCALAR\"}],"
        "\"materials\":[{\"emissiveFactor\":[1,1,1]}],\"meshes\":[",
        sizeof corner + sizeof index, sizeof corner, sizeof corner, sizeof index, CORNERS, INDICES);
    for (int m = 0; m < meshes; m++)
        at += (size_t)sprintf(json + at,
                              "%s{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1,"
                              "\"material\":0}]}",
                              m ? "," : "");
    at += (size_t)sprintf(json + at, "],\"nodes\":[");
    for (int m = 0; m < meshes; m++)
        at += (size_t)sprintf(json + at, "%s{\"mesh\":%d,\"translation\":[0,%d,0]}", m ? "," : "", m, m);
    at += (size_t)sprintf(json + at, "],\"scenes\":[{\"nodes\":[");
    for (int m = 0; m < meshes; m++) at += (size_t)sprintf(json + at, "%s%d", m ? "," : "", m);
    sprintf(json + at, "]}]}");
    return files_text("square.gltf", json);
}

/* A small file can make a large tree. */
static void large_trees(void **state)
{
    (void)state;
    char error[RND_ERROR_SIZE] = "";
    struct rnd_scene_options options = {
        .path = square(1), .image_program = files_image_program(), .reader_mib = 128};
    struct rnd_scene *scene = rnd_scene_load(&options, error);
    if (!scene) fail_msg("%s", error);
    assert_int_equal(scene->info.triangles, INDICES / 3);
    rnd_scene_destroy(scene);
    options.path = square(TIMES);
    assert_null(rnd_scene_load(&options, error));
    assert_non_null(strstr(error, "its triangles need more than 128 MiB in Embree's trees"));
    options.reader_mib = 4096;
    scene = rnd_scene_load(&options, error);
    if (!scene) fail_msg("%s", error);
    assert_int_equal(scene->info.triangles, TIMES * INDICES / 3);
    rnd_scene_destroy(scene);
}

/* --- the end --- */

/* A cancelled read does not read anything. */
static void cancelled(void **state)
{
    (void)state;
    static const atomic_bool no_more = true;
    char error[RND_ERROR_SIZE] = "";
    const struct rnd_scene_options options = {
        .path = files_room("room.obj"), .image_program = files_image_program(), .cancel = &no_more};
    struct rnd_image_reader images = reader();
    struct rnd_picture picture;
    images.cancel[0] = &no_more;
    assert_null(rnd_scene_load(&options, error));
    assert_non_null(strstr(error, "room.obj: "));
    rnd_image_size_apart(&images,
                         &(struct rnd_pixels_file){
                             .path = noise("odd.png", 37, 23), .use = RND_PIXELS_SRGB, .want_bytes = true},
                         &picture, error, sizeof error); /* must return, whatever the result */
    rnd_image_reader_finish(&images);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(without_finest),    cmocka_unit_test(sizes),
                                       cmocka_unit_test(large_environment), cmocka_unit_test(large_texture),
                                       cmocka_unit_test(hostile),           cmocka_unit_test(large_trees),
                                       cmocka_unit_test(cancelled)};
    return cmocka_run_group_tests(tests, files_setup, files_teardown);
}
