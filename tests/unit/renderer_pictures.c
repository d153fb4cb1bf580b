/* Pictures that the reader's program sends in many packets are whole and in their places. */
#include "renderer_files.h"
#include "scene/scene.h"

/* A value that tells where it is, exact in half floats and in 8 bits. */
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

/* An environment map of 1024 x 512 is 6 MiB of floats, which no round number of packets makes. */
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

/* The same of textures, whose texels are bytes. */
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
                /* linear from sRGB, to which values were encoded */
                wrong += !(fabsf(t.g - at(x, y, 1) / 255.0f) < 0.005f);
                seen++;
            }
        print_message("%d x %d: %zu of %zu wrong\n", width, height, wrong, seen);
        assert_int_equal(wrong, 0);
        rnd_scene_destroy(scene);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(large_environment), cmocka_unit_test(large_texture)};
    return cmocka_run_group_tests_name("renderer_pictures", tests, files_setup, files_teardown);
}
