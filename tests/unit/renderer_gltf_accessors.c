/* Numbers in glTF: all ways to write the same numbers give the same result, and an error names the place of
 * the fault in the file. */
#include "renderer_gltf.h"

/* Texture coordinates (0, 1/2), (1/2, 1) ... in every component type, packed and with a stride of 8. */
static void components(void **state)
{
    (void)state;
    static const float floats[8] = {0, 1, 0, 1, 1, 0, 1, 0};
    static const uint8_t bytes[8] = {0, 255, 0, 255, 255, 0, 255, 0}, plain[8] = {0, 1, 0, 1, 1, 0, 1, 0};
    static const int8_t signed_bytes[8] = {0, 127, 0, 127, 127, 0, 127, -0};
    static const uint16_t words[8] = {0, 65535, 0, 65535, 65535, 0, 65535, 0};
    static const int16_t signed_words[8] = {0, 32767, 0, 32767, 32767, 0, 32767, 0};
    static const uint16_t strided[16] = {0, 65535, 7, 7, 0, 65535, 7, 7, 65535, 0, 7, 7, 65535, 0, 7, 7};
#define UVS(component) "\"componentType\":" #component ",\"count\":4,\"type\":\"VEC2\",\"normalized\":true"
    const struct files_part uvs[] = {
        {floats, sizeof floats, UVS(5126)},
        {bytes, sizeof bytes, UVS(5121)},
        {signed_bytes, sizeof signed_bytes, UVS(5120)},
        {words, sizeof words, UVS(5123)},
        {signed_words, sizeof signed_words, UVS(5122)},
        {plain, sizeof plain, "\"componentType\":5121,\"count\":4,\"type\":\"VEC2\""},
        {strided, sizeof strided, UVS(5123)},
    };
    for (size_t i = 0; i < sizeof uvs / sizeof *uvs; i++) {
        const struct files_part parts[] = {{files_corners, sizeof files_corners, VEC3(4)},
                                           uvs[i],
                                           {files_two, sizeof files_two, SCALARS(5123, 6)}};
        char *path = (char *)(uintptr_t)files_parts("uv.gltf", files_primitive, node, "{}", "", parts, 3);
        if (i == 6) {
            static char text[100000];
            FILE *file = fopen(path, "rb");
            const size_t n = fread(text, 1, sizeof text - 1, file);
            fclose(file);
            text[n] = 0;
            char *view = strstr(text, "{\"buffer\":1,");
            assert_non_null(view);
            memmove(view + 27, view + 12, strlen(view + 12) + 1);
            memcpy(view, "{\"byteStride\":8,\"buffer\":1,", 27);
            path = (char *)(uintptr_t)files_text("uv.gltf", text);
        }
        struct rnd_scene *scene = load_quietly(path);
        for (int k = 0; k < 8; k++) NEAR(scene->mesh[0].uv[0][k], floats[k]);
        rnd_scene_destroy(scene);
    }
}

/* Positions as integers (KHR_mesh_quantization), and indices of every width. */
static void quantized(void **state)
{
    (void)state;
    static const int16_t corners[16] = {-1, 0, -1, 9, -1, 0, 1, 9, 1, 0, 1, 9, 1, 0, -1, 9};
    static const int8_t halves[12] = {-127, 0, -127, -127, 0, 127, 127, 0, 127, 127, 0, -127};
    static const uint8_t two8[6] = {0, 1, 2, 0, 2, 3};
    static const uint32_t two32[6] = {0, 1, 2, 0, 2, 3};
    const struct files_part positions[3] = {
        {files_corners, sizeof files_corners, VEC3(4)},
        {corners, sizeof corners, "\"componentType\":5122,\"count\":4,\"type\":\"VEC4\""},
        {halves, sizeof halves, "\"componentType\":5120,\"count\":4,\"type\":\"VEC3\",\"normalized\":true"}};
    const struct files_part indices[3] = {{files_two, sizeof files_two, SCALARS(5123, 6)},
                                          {two8, sizeof two8, SCALARS(5121, 6)},
                                          {two32, sizeof two32, SCALARS(5125, 6)}};
    for (int i = 0; i < 3; i++) {
        const struct files_part parts[] = {
            positions[i],
            {files_uvs, sizeof files_uvs, "\"componentType\":5126,\"count\":4,\"type\":\"VEC2\""},
            indices[i]};
        const char *path =
            files_parts("q.gltf", files_primitive, node, "{}",
                        ",\"extensionsUsed\":[\"KHR_mesh_quantization\"],\"extensionsRequired\":["
                        "\"KHR_mesh_quantization\"]",
                        parts, 3);
        if (i == 1) { /* a position has three numbers, not four */
            assert_refused(path, "meshes[0].primitives[0].attributes.POSITION: expected an accessor of VEC3");
            continue;
        }
        struct rnd_scene *scene = load_quietly(path);
        assert_int_equal(scene->mesh[0].triangles, 2);
        for (int k = 0; k < 12; k++) NEAR(scene->mesh[0].position[k], files_corners[k]);
        assert_int_equal(scene->mesh[0].index[1][2], 3);
        rnd_scene_destroy(scene);
    }
}

/* Sparse elements of an accessor with bytes, of one without, and of an animation. */
static void sparse(void **state)
{
    (void)state;
    static const uint8_t which[2] = {1, 3};
    static const float values[6] = {-5, 1, 5, 5, 1, -5}, times[1] = {0}, moves[3] = {9, 9, 9},
                       moved[3] = {0, 7, 0};
    static const uint16_t first[1] = {0};
#define SPARSE(count, component, indices, values)                                                            \
    ",\"sparse\":{\"count\":" #count ",\"indices\":{\"bufferView\":" #indices                                \
    ",\"componentType\":" #component "},\"values\":{\"bufferView\":" #values "}}"
    struct files_part parts[] = {
        {files_corners, sizeof files_corners, VEC3(4) SPARSE(2, 5121, 3, 4)},
        {files_uvs, sizeof files_uvs, "\"componentType\":5126,\"count\":4,\"type\":\"VEC2\""},
        {files_two, sizeof files_two, SCALARS(5123, 6)},
        {which, sizeof which, SCALARS(5121, 2)},
        {values, sizeof values, VEC3(2)},
        {times, sizeof times, SCALARS(5126, 1)},
        {moves, sizeof moves, VEC3(1) SPARSE(1, 5123, 7, 8)},
        {first, sizeof first, SCALARS(5123, 1)},
        {moved, sizeof moved, VEC3(1)}};
    static const char animation[] =
        ",\"animations\":[{\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,\"path\":\"translation\"}}],"
        "\"samplers\":[{\"input\":5,\"output\":6}]}]";
    struct rnd_scene *scene =
        files_load(files_parts("sparse.gltf", files_primitive, node, "{}", animation, parts, 9),
                   files_env("env.exr", 1), NULL, NULL);
    const float *p = scene->mesh[0].position;
    NEAR(p[0], -1), NEAR(p[1], 7), NEAR(p[3], -5), NEAR(p[4], 8), NEAR(p[5], 5), NEAR(p[6], 1), NEAR(p[9], 5);
    rnd_scene_destroy(scene);

    /* A sparse accessor without a view of its own: the views of all later accessors move down by one. */
    static const float all[12] = {-1, 0, -1, -1, 0, 1, 1, 0, 1, 1, 0, -1};
    static const uint8_t each[4] = {0, 1, 2, 3};
    const struct files_part over[] = {
        {files_two, sizeof files_two, SCALARS(5123, 6)},
        {each, sizeof each, SCALARS(5121, 4) "},{" VEC3(4) SPARSE(4, 5121, 1, 2)},
        {all, sizeof all, VEC3(4)}};
    scene = load_quietly(files_parts("over.gltf",
                                     "{\"attributes\":{\"POSITION\":2},\"indices\":0,\"material\":0}", node,
                                     "{}", "", over, 3));
    for (int k = 0; k < 12; k++) NEAR(scene->mesh[0].position[k], all[k]);
    rnd_scene_destroy(scene);

    parts[3].bytes = (const uint8_t[2]){3, 1};
    assert_refused(files_parts("falls.gltf", files_primitive, node, "{}", "", parts, 9),
                   "accessors[0].sparse.indices: number 1 is 1: expected rising");
    parts[3].bytes = (const uint8_t[2]){1, 4};
    assert_refused(files_parts("beyond.gltf", files_primitive, node, "{}", "", parts, 9),
                   "accessors[0].sparse.indices: number 1 is 4: expected rising ones below 4");
}

/* Accessors and views that refer to bytes beyond the end. */
static void wrong_accessors(void **state)
{
    (void)state;
    static const struct {
        const char *accessor, *words;
    } cases[] = {
        {"\"componentType\":5126,\"count\":5,\"type\":\"VEC3\"", "accessors[0].count: 5 of 12 bytes"},
        {"\"componentType\":5126,\"count\":-1,\"type\":\"VEC3\"",
         "accessors[0].count: expected a whole number"},
        {"\"componentType\":5126,\"count\":1e30,\"type\":\"VEC3\"",
         "accessors[0].count: expected a whole number"},
        {"\"componentType\":5126,\"count\":\"4\",\"type\":\"VEC3\"",
         "accessors[0].count: expected a whole number"},
        {"\"componentType\":5126,\"type\":\"VEC3\"", "accessors[0].count: expected a whole number"},
        {"\"componentType\":5124,\"count\":4,\"type\":\"VEC3\"", "accessors[0].componentType: expected"},
        {"\"componentType\":5126,\"count\":4,\"type\":\"MAT4\"", "accessors[0].type: expected"},
        {"\"componentType\":5126,\"count\":4", "accessors[0].type: expected"},
        {"\"componentType\":5126,\"count\":4,\"type\":\"VEC2\"",
         "attributes.POSITION: expected an accessor of VEC3"},
        {"\"componentType\":5126,\"count\":4,\"type\":\"VEC3\",\"byteOffset\":4",
         "accessors[0].count: 4 of 12 bytes"},
        {"\"componentType\":5126,\"count\":4,\"type\":\"VEC3\",\"bufferView\":9",
         "accessors[0].bufferView: expected the index"},
        {"\"componentType\":5126,\"count\":2,\"type\":\"VEC3\"",
         "indices: number 2 is vertex 2: expected one below 2"},
        {"\"componentType\":5126,\"count\":0,\"type\":\"VEC3\"", "holds no triangle"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const struct files_part parts[] = {
            {files_corners, sizeof files_corners, cases[i].accessor},
            {files_uvs, sizeof files_uvs, "\"componentType\":5126,\"count\":4,\"type\":\"VEC2\""},
            {files_two, sizeof files_two, SCALARS(5123, 6)}};
        assert_refused(files_parts("wrong.gltf", files_primitive, node, "{}", "", parts, 3), cases[i].words);
    }
}

/* Small files that demand much are refused with one line, before they take memory or time. */
static void too_much(void **state)
{
    (void)state;
    enum { MANY = 3000, CORNERS = 60000 };
    static uint16_t corners[CORNERS / 2];
    static char primitives[MANY * 60], nodes[MANY * 140];
    static const uint8_t none[4] = {0};
    const struct files_part parts[] = {
        FILES_SQUARE,
        {corners, sizeof corners, "\"componentType\":5121,\"count\":60000,\"type\":\"SCALAR\""},
        {none, sizeof none,
         "\"componentType\":5126,\"count\":1,\"type\":\"SCALAR\"},{\"componentType\":5126,\"count\":1000000,"
         "\"type\":\"VEC3\",\"sparse\":{\"count\":1,\"indices\":{\"bufferView\":4,\"componentType\":5121},"
         "\"values\":{\"bufferView\":0}}"}};
    size_t n = 0;
    for (int i = 0; i < MANY; i++)
        n += (size_t)sprintf(primitives + n, "%s{\"attributes\":{\"POSITION\":0},\"indices\":3,\"mode\":5}",
                             i ? "," : "");
    assert_refused(files_parts("corners.gltf", primitives, node, "{}", "", parts, 5), "over and over");

    n = (size_t)sprintf(nodes, "{\"children\":[");
    for (int i = 1; i < MANY; i++) n += (size_t)sprintf(nodes + n, "%s%d", i > 1 ? "," : "", i);
    n += (size_t)sprintf(nodes + n, "]}");
    for (int i = 1; i < MANY; i++)
        n += (size_t)sprintf(nodes + n, ",{\"mesh\":0,\"extensions\":{\"EXT_mesh_gpu_instancing\":{"
                                        "\"attributes\":{\"TRANSLATION\":5}}}}");
    assert_refused(files_parts("places.gltf", files_primitive, nodes, "{}", "", parts, 5),
                   "10 million places");

    n = (size_t)sprintf(nodes, "{\"children\":[");
    for (int i = 1; i < MANY; i++) n += (size_t)sprintf(nodes + n, "%s%d", i > 1 ? "," : "", i);
    n += (size_t)sprintf(nodes + n, "]}");
    for (int i = 1; i < MANY; i++) n += (size_t)sprintf(nodes + n, ",{\"mesh\":0}");
    assert_refused(files_parts("shining.gltf",
                               "{\"attributes\":{\"POSITION\":0},\"indices\":3,\"material\":0}", nodes,
                               shining, "", parts, 5),
                   "million triangles or vertices");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(components),      cmocka_unit_test(quantized), cmocka_unit_test(sparse),
        cmocka_unit_test(wrong_accessors), cmocka_unit_test(too_much),
    };
    return cmocka_run_group_tests_name("renderer_gltf_accessors", tests, files_setup, files_teardown);
}
