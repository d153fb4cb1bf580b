/* glTF as files: how buffers and images are found, versions, extensions, and names that are printed to a
 * terminal. */
#include "renderer_gltf.h"

#include <sys/stat.h>

/* Write a square whose buffer is in the file with this name. */
static const char *with_buffer(const char *uri)
{
    static char text[4000];
    char named[300];
    snprintf(named, sizeof named, ",\"uri\":\"%s\"", uri);
    files_gltf_text(text, sizeof text, 1, node, shining, "", named);
    return files_text("named.gltf", text);
}

/* Buffers and images are found by the same rule. */
static void names(void **state)
{
    (void)state;
    static const struct {
        const char *file, *uri; /* as JSON writes it */
    } cases[] = {
        {"plain.bin", "plain.bin"},
        {"my scene.bin", "my%20scene.bin"},
        {"my scene.bin", "my scene.bin"},
        {"50%25.bin", "50%25.bin"},
        {"folder/a.bin", "folder\\\\a.bin"},
        {"folder/a.bin", "./folder/../folder/a.bin"},
        {"Upper.BIN", "upper.bin"},
        {"Folder2/Deep.bin", "folder2/deep.BIN"},
        {"base.bin", "C:\\\\work\\\\base.bin"},
        {"base.bin", "/nowhere/at/all/base.bin"},
        {"base.bin", "file:///nowhere/base.bin"},
        {"base.bin", "textures/gone/Base.bin"},
        {"b\xc3\xa4r.bin", "b%C3%A4r.bin"},
    };
    const struct files_square square = files_square(1);
    char error[RND_ERROR_SIZE];
    mkdir(files_path("folder"), 0700);
    mkdir(files_path("Folder2"), 0700);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        files_write(cases[i].file, &square, sizeof square);
        struct rnd_scene *scene = load_quietly(with_buffer(cases[i].uri));
        NEAR(scene->mesh[0].position[0], -1);
        assert_true(files_named(rnd_scene_info(scene), files_path(cases[i].file)));
        rnd_scene_destroy(scene);
        remove(files_path(cases[i].file));
    }
    for (size_t i = 0; i < sizeof cases / sizeof *cases;
         i++) { /* as images, whose format is recognised by their bytes */
        char file[64], more[400], uri[200];
        snprintf(file, sizeof file, "%.*s.png", (int)strlen(cases[i].file) - 4, cases[i].file);
        snprintf(uri, sizeof uri, "%.*s.png", (int)strlen(cases[i].uri) - 4, cases[i].uri);
        if (!files_image(files_path(file), 2, 2, (float[12]){1, 1, 1, 0, 0, 0, 1, 1, 1, 0, 0, 0}, false,
                         error))
            fail_msg("%s", error);
        snprintf(more, sizeof more, ",\"textures\":[{\"source\":0}],\"images\":[{\"uri\":\"%s\"}]", uri);
        struct rnd_scene *scene = load_quietly(files_gltf(
            "image.gltf", 1, node, "{\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0}}}", more));
        assert_int_equal(scene->texture[scene->material[0].map[RND_MAP_BASE].texture].levels, 2);
        assert_true(files_named(rnd_scene_info(scene), files_path(file)));
        rnd_scene_destroy(scene);
        remove(files_path(file));
    }
    assert_refused(with_buffer("gone.bin"), "buffers[0].uri: ");
    assert_refused(with_buffer("/etc/passwd"), "buffers[0].uri: ");
    assert_refused(with_buffer("folder"), "buffers[0].uri: ");
    assert_refused(with_buffer("data:,abc"), "buffers[0].uri: expected a data URI of base64");
    assert_refused(with_buffer("data:;base64,AAAA"), "buffers[0].byteLength: 92, but its URI holds 3 bytes");
    files_write("short.bin", &square, 91);
    assert_refused(with_buffer("short.bin"), "short.bin holds 91 bytes");
}

static void versions(void **state)
{
    (void)state;
    static char text[100000];
    FILE *file = fopen(files_gltf("good.gltf", 1, node, shining, ""), "rb");
    text[0] = '\xef', text[1] = '\xbb', text[2] = '\xbf';
    const size_t n = 3 + fread(text + 3, 1, sizeof text - 3, file);
    fclose(file);
    rnd_scene_destroy(
        load_warned(files_write("mark.gltf", text, n), "mark.gltf: begins with a byte order mark"));
    assert_refused(files_text("one.gltf", "{\"asset\":{\"version\":\"1.0\"},\"nodes\":{}}"),
                   "is glTF 1.0, expected 2.0");
    assert_refused(files_text("early.gltf", "{\"nodes\":{\"a\":{}}}"), "is glTF 1.0 as it seems");
    assert_refused(files_text("late.gltf", "{\"asset\":{\"version\":\"2.1\",\"minVersion\":\"2.1\"}}"),
                   "asset.minVersion");
    assert_refused(files_write("one.glb", "glTF\1\0\0\0\24\0\0\0\0\0\0\0\0\0\0\0", 20), "is glTF 1.0");

    /* The JSON is padded with zeros, an unknown chunk follows it, and the name ends as that of another
     * format. */
    file = fopen(files_glb("whole.glb", 1, node, shining, ""), "rb");
    const size_t all = fread(text, 1, sizeof text, file),
                 json = (size_t)(uint8_t)text[12] | (size_t)(uint8_t)text[13] << 8;
    fclose(file);
    memmove(text + 20 + json + 16, text + 20 + json, all - 20 - json);
    memset(text + 20 + json, 0, 4);
    text[12] = (char)((json + 4) & 255), text[13] = (char)((json + 4) >> 8);
    memcpy(text + 24 + json, "\4\0\0\0WHAT....", 12);
    rnd_scene_destroy(load_quietly(files_write("odd.bin", text, all + 16)));
}

/* Names from a file are printed to a terminal without their control characters, in errors and in warnings. */
static void printable(void **state)
{
    (void)state;
    static const float far[9] = {0, 0, 0, 1, 0, 0, 1e30f, 1, 0};
    const struct files_part parts[] = {{far, sizeof far, VEC3(3)}};
    const char *path = files_parts("far.gltf",
                                   "{\"attributes\":{\"POSITION\":0}}],\"name\":\"a\\u001b]0;"
                                   "b\\u0007\\u009b1m\\u007f\\n\\u00e4\",\"x\":[",
                                   node, "", "", parts, 1);
    const struct rnd_scene_options options = {
        .image_program = files_image_program(), .path = path, .env_path = files_env("env.exr", 1)};
    char error[RND_ERROR_SIZE];
    assert_null(rnd_scene_load(&options, error));
    if (!strstr(error, "mesh \"a ]0;b   1m  \xc3\xa4\" is not finite")) fail_msg("%s", error);
    struct rnd_scene *scene =
        load_warned(files_gltf("named.gltf", 1, node, shining, ",\"extensionsRequired\":[\"XX\\u001b[31m\"]"),
                    ": XX [31m is not known");
    rnd_scene_destroy(scene);
}

static void extensions(void **state)
{
    (void)state;
    struct rnd_scene *scene = load_warned(files_gltf("new.gltf", 1, node, shining,
                                                     ",\"extensionsUsed\":[\"XX_made_up\",\"KHR_texture_"
                                                     "transform\"],\"extensionsRequired\":[\"XX_made_up\"]"),
                                          "new.gltf: extensionsRequired[0]: XX_made_up is not known here");
    assert_string_equal(rnd_scene_info(scene)->unsupported, "XX_made_up");
    rnd_scene_destroy(scene);
    assert_refused(
        files_gltf("packed.gltf", 1, node, shining, ",\"extensionsRequired\":[\"EXT_meshopt_compression\"]"),
        "extensionsRequired[0]: EXT_meshopt_compression cannot be read: export");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(names),
        cmocka_unit_test(versions),
        cmocka_unit_test(extensions),
        cmocka_unit_test(printable),
    };
    return cmocka_run_group_tests_name("renderer_gltf_files", tests, files_setup, files_teardown);
}
