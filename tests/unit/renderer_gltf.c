/* What artists bring as glTF: every way to write the same numbers means the same, and what is out of order is
 * named with its place in the file. */
#include "renderer_parts.h"

#include <sys/stat.h>

static const char node[] = "{\"mesh\":0}", shining[] = "{\"emissiveFactor\":[1,1,1]}";

#define VEC3(n)               "\"componentType\":5126,\"count\":" #n ",\"type\":\"VEC3\""
#define SCALARS(component, n) "\"componentType\":" #component ",\"count\":" #n ",\"type\":\"SCALAR\""

/* Loads, without a word. */
static struct rnd_scene *load_quietly(const char *path)
{
    struct rnd_scene *scene = files_load(path, files_env("env.exr", 1), NULL, NULL);
    assert_string_equal(rnd_scene_info(scene)->warnings, "");
    assert_string_equal(rnd_scene_info(scene)->unsupported, "");
    return scene;
}

/* Loads, and warns with these words. */
static struct rnd_scene *load_warned(const char *path, const char *words)
{
    struct rnd_scene *scene = files_load(path, files_env("env.exr", 1), NULL, NULL);
    if (!strstr(rnd_scene_info(scene)->warnings, words))
        fail_msg("\"%s\": expected %s", rnd_scene_info(scene)->warnings, words);
    return scene;
}

static void assert_refused(const char *path, const char *words)
{
    const struct rnd_scene_options options = {.readers = files_readers(), .path = path, .env_path = files_env("env.exr", 1)};
    char error[RND_ERROR_SIZE] = "";
    struct rnd_scene *scene = rnd_scene_load(&options, error);
    if (scene || !strstr(error, words) || strchr(error, '\n'))
        fail_msg("\"%s\": expected %s", scene ? "loaded" : error, words);
    assert_non_null(strstr(error, strrchr(path, '/') + 1));
}

/* --- accessors --- */

/* Texture coordinates (0, 1/2), (1/2, 1) ... of all components, packed and at a stride of 8. */
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

/* Positions as integers (KHR_mesh_quantization), and indices of all widths. */
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
        if (i == 1) { /* four numbers are no position */
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

/* Elements that are elsewhere, of an accessor with bytes and of one without; and of an animation. */
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

    /* sparse over nothing: the accessors after the first have views of one less */
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

/* What accessors and views say that is not there. */
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

/* Small files that ask for much: a line, before there is memory or time for it. */
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

/* --- primitives --- */

/* A square as a list, strip and fan, with indices and without; points and lines beside it are left out. */
static void modes(void **state)
{
    (void)state;
    static const float strip[12] = {-1, 0, -1, -1, 0, 1, 1, 0, -1, 1, 0, 1};
    static const uint16_t turned[8] = {0, 1, 2, 3, 3, 3, 3, 3};
    const struct files_part parts[] = {{strip, sizeof strip, VEC3(4)},
                                       {files_corners, sizeof files_corners, VEC3(4)},
                                       {files_two, sizeof files_two, SCALARS(5123, 6)},
                                       {turned, sizeof turned, SCALARS(5123, 8)}};
    static const char *const primitives[] = {
        "{\"attributes\":{\"POSITION\":0},\"mode\":5}", "{\"attributes\":{\"POSITION\":1},\"mode\":6}",
        "{\"attributes\":{\"POSITION\":0},\"indices\":3,\"mode\":5}",
        "{\"attributes\":{\"POSITION\":1},\"indices\":2,\"mode\":4}",
        "{\"attributes\":{\"POSITION\":1},\"mode\":0},{\"attributes\":{\"POSITION\":1},\"indices\":2},"
        "{\"attributes\":{\"POSITION\":1},\"mode\":3},{\"attributes\":{}}"};
    for (int i = 0; i < 5; i++) {
        struct rnd_scene *scene =
            files_load(files_parts("modes.gltf", primitives[i], node, "{}", "", parts, 4),
                       files_env("env.exr", 1), NULL, NULL);
        assert_int_equal(scene->mesh_count, 1);
        assert_int_equal(scene->mesh[0].triangles, 2);
        for (int t = 0; t < 2; t++) { /* both face up */
            const uint32_t *index = scene->mesh[0].index[t];
            const vec3s a = rnd_vertex(scene->mesh, index[0]);
            const vec3s n = glms_vec3_cross(glms_vec3_sub(rnd_vertex(scene->mesh, index[1]), a),
                                            glms_vec3_sub(rnd_vertex(scene->mesh, index[2]), a));
            NEAR(n.y, 4);
        }
        assert_string_equal(rnd_scene_info(scene)->unsupported,
                            i < 4 ? "" : "points and lines, primitives without positions");
        rnd_scene_destroy(scene);
    }
    assert_refused(
        files_parts("mode.gltf", "{\"attributes\":{\"POSITION\":1},\"mode\":7}", node, "{}", "", parts, 4),
        "meshes[0].primitives[0].mode: expected a whole number from 0 to 6");
    assert_refused(
        files_parts("lines.gltf", "{\"attributes\":{\"POSITION\":1},\"mode\":1}", node, "{}", "", parts, 4),
        "holds no triangle");
}

/* Primitives that share one large array of vertices have those that they name, in a row or scattered. */
static void shared_vertices(void **state)
{
    (void)state;
    enum { MANY = 3000 };
    static float corners[3 * MANY];
    static const uint16_t row[3] = {1000, 1001, 1002}, scattered[6] = {0, 1500, 2999, 2999, 1500, 7};
    for (int i = 0; i < MANY; i++) corners[3 * i] = (float)i, corners[3 * i + 1] = (float)(i * i % 100);
    const struct files_part parts[] = {{corners, sizeof corners, VEC3(3000)},
                                       {row, sizeof row, SCALARS(5123, 3)},
                                       {scattered, sizeof scattered, SCALARS(5123, 6)}};
    struct rnd_scene *scene = load_quietly(files_parts(
        "shared.gltf",
        "{\"attributes\":{\"POSITION\":0},\"indices\":1},{\"attributes\":{\"POSITION\":0},\"indices\":2}",
        node, "{}", "", parts, 3));
    assert_int_equal(scene->mesh[0].vertices, 3);
    assert_int_equal(scene->mesh[1].vertices, 4);
    for (int k = 0; k < 3; k++) NEAR(rnd_vertex(&scene->mesh[0], scene->mesh[0].index[0][k]).x, row[k]);
    for (int k = 0; k < 6; k++)
        NEAR(rnd_vertex(&scene->mesh[1], scene->mesh[1].index[k / 3][k % 3]).x, scattered[k]);
    rnd_scene_destroy(scene);
}

/* --- Draco --- */

/* The square from -1 to 1 with normals, texture coordinates and colours, by Draco 1.5.5. */
static const char draco_square[] =
    "RFJBQ08CAgEBAAAABAIDAgAAAR//ARH/ARH/ARH/AREE/wAAAAAAAQAAAgAAAQAJAwAAAgEDCQIAAQIBAQkDAAIDAQIEBAAD"
    "AQEBAQADAwEwARADACiCKAgAAAAA/z8AAAAAgL8AAAAAAACAvwAAAEAOAQEBAAMDATABEAMAKIKMAAAAAAD/DwAAAAAAAAAA"
    "AAAAAIA/DAADAQAKAwEwGwEQAwAcgv8BAP8DAAD/AQAACgEBAQARAwEwNwEQAwAcggEA//8AAAEAAAAAAAAA//8AAA==";

static const char *with_draco(const char *name, const char *index, const char *view, const char *data)
{
    static char text[6000];
    snprintf(
        text, sizeof text,
        "{\"asset\":{\"version\":\"2.0\"},\"extensionsRequired\":[\"KHR_draco_mesh_compression\"],\"scenes\":"
        "[{"
        "\"nodes\":[0]}],\"nodes\":[{\"mesh\":0,\"translation\":[0,1,0]}],\"materials\":[{}],\"meshes\":[{"
        "\"primitives\":[{\"attributes\":{\"POSITION\":0,\"TEXCOORD_0\":1,\"NORMAL\":2,\"COLOR_0\":3},"
        "\"indices\":4,\"material\":0,\"extensions\":{\"KHR_draco_mesh_compression\":{\"bufferView\":%s,"
        "\"attributes\":{"
        "\"POSITION\":0,\"TEXCOORD_0\":1,\"NORMAL\":2,\"COLOR_0\":3}}}}]}],\"accessors\":[{\"componentType\":"
        "5126,"
        "\"count\":4,\"type\":\"VEC3\"},{\"componentType\":5126,\"count\":4,\"type\":\"VEC2\"},{"
        "\"componentType\":"
        "5126,\"count\":4,\"type\":\"VEC3\"},{\"componentType\":5123,\"normalized\":true,\"count\":4,"
        "\"type\":"
        "\"VEC4\"},{\"componentType\":%s,\"type\":\"SCALAR\"}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":"
        "211}],"
        "\"buffers\":[{\"byteLength\":211,\"uri\":\"data:;base64,%s\"}]}",
        view, index, data);
    return files_text(name, text);
}

static void draco(void **state)
{
    (void)state;
    static const char *const indices[] = {"5123,\"count\":6", "5125,\"count\":6"};
    char spoiled[sizeof draco_square];
    for (int i = 0; i < 2; i++) {
        struct rnd_scene *scene = load_quietly(with_draco("draco.gltf", indices[i], "0", draco_square));
        const struct rnd_mesh *mesh = &scene->mesh[0];
        assert_int_equal(mesh->triangles, 2);
        for (int t = 0; t < 2; t++)
            for (int k = 0; k < 3; k++) { /* texture coordinates go along with places */
                const vec3s p = rnd_vertex(mesh, mesh->index[t][k]);
                const float *uv = mesh->uv[0] + 2 * (size_t)mesh->index[t][k];
                assert_float_equal(p.x, 2 * uv[0] - 1, 1e-3);
                assert_float_equal(p.z, 2 * uv[1] - 1, 1e-3);
                NEAR(p.y, 1), NEAR(fabsf(p.x), 1), NEAR(fabsf(p.z), 1);
            }
        NEAR(mesh->normal[1], 1), NEAR(mesh->colour[0], 1), NEAR(mesh->colour[1], 32768 / 65535.0),
            NEAR(mesh->colour[3], 1);
        rnd_scene_destroy(scene);
    }
    assert_refused(with_draco("count.gltf", "5123,\"count\":600", "0", draco_square),
                   "meshes[0].primitives[0]: KHR_draco_mesh_compression cannot be decoded by assimp");
    assert_refused(
        with_draco("view.gltf", indices[0], "1", draco_square),
        "meshes[0].primitives[0].extensions.KHR_draco_mesh_compression.bufferView: expected the index");
    for (size_t i = 4; i < sizeof draco_square - 5; i += 7) { /* a scene or a line */
        char error[RND_ERROR_SIZE] = "";
        memcpy(spoiled, draco_square, sizeof spoiled);
        spoiled[i] = spoiled[i] == 'A' ? 'z' : 'A';
        const struct rnd_scene_options options = {
            .readers = files_readers(), .path = with_draco("spoiled.gltf", indices[0], "0", spoiled), .env_path = files_path("env.exr")};
        struct rnd_scene *scene = rnd_scene_load(&options, error);
        assert_true(scene != NULL || strstr(error, "spoiled.gltf: "));
        rnd_scene_destroy(scene);
    }
}

/* --- nodes --- */

static struct rnd_scene *with_nodes(const char *roots, const char *nodes, const char *warned)
{
    static char text[8000];
    const struct files_part parts[] = {FILES_SQUARE};
    const char *path = files_parts("n.gltf", files_primitive, nodes, "{}", "", parts, 3);
    FILE *file = fopen(path, "rb");
    const size_t n = fread(text, 1, sizeof text - 100, file);
    fclose(file);
    text[n] = 0;
    char *old = strstr(text, "\"scenes\":[{\"nodes\":[0]}]"), *rest = old + 24;
    assert_non_null(old);
    memmove(old + strlen(roots), rest, strlen(rest) + 1);
    memcpy(old, roots, strlen(roots));
    path = files_text("n.gltf", text);
    return warned ? load_warned(path, warned) : load_quietly(path);
}

static void roots(void **state)
{
    (void)state;
    static const struct {
        const char *roots, *nodes, *warned;
        int meshes;
        float x; /* of the first mesh's first corner */
    } cases[] = {
        /* UniGLTF: the parent is not shown */
        {"\"scenes\":[{\"nodes\":[1]}]", "{\"translation\":[5,0,0],\"children\":[1]},{\"mesh\":0}",
         "scenes[0].nodes: 1 of them is a child of another node", 1, -1},
        /* both are: once, in its tree */
        {"\"scenes\":[{\"nodes\":[1,0]}]", "{\"translation\":[5,0,0],\"children\":[1]},{\"mesh\":0}",
         "scenes[0].nodes: 1 of them is a child", 1, 4},
        {"\"scenes\":[{\"nodes\":[1,0,2]}]", "{\"children\":[1]},{\"mesh\":0,\"children\":[2]},{\"mesh\":0}",
         "2 of them are children", 2, -1},
        {"\"scenes\":[{\"nodes\":[0,0]}]", "{\"mesh\":0}", NULL, 1, -1},
        /* the scene that is asked for, and none */
        {"\"scenes\":[{\"nodes\":[1]},{\"nodes\":[0]}]", "{\"mesh\":0},{\"mesh\":0,\"translation\":[3,0,0]}",
         NULL, 1, 2},
        {"\"scenes\":[]", "{\"children\":[1]},{\"mesh\":0,\"translation\":[3,0,0]}", NULL, 1, 2},
        /* what is hidden, with all below it */
        {"\"scenes\":[{\"nodes\":[0,1]}]",
         "{\"mesh\":0,\"children\":[2],\"extensions\":{\"KHR_node_visibility\":{\"visible\":false}}},"
         "{\"mesh\":0,\"translation\":[3,0,0],\"extensions\":{\"KHR_node_visibility\":{\"visible\":true}}},{"
         "\"mesh\":0}",
         NULL, 1, 2},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char wanted[200];
        snprintf(wanted, sizeof wanted, "%s", cases[i].roots);
        struct rnd_scene *scene = with_nodes(wanted, cases[i].nodes, cases[i].warned);
        assert_int_equal(scene->mesh_count, cases[i].meshes);
        NEAR(scene->mesh[0].position[0], cases[i].x);
        rnd_scene_destroy(scene);
    }
}

/* --- files --- */

/* A square whose buffer is in a file of that name. */
static const char *with_buffer(const char *uri)
{
    static char text[4000];
    char named[300];
    snprintf(named, sizeof named, ",\"uri\":\"%s\"", uri);
    files_gltf_text(text, sizeof text, 1, node, shining, "", named);
    return files_text("named.gltf", text);
}

/* Buffers and images are found by one rule. */
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
        rnd_scene_destroy(scene);
        remove(files_path(cases[i].file));
    }
    for (size_t i = 0; i < sizeof cases / sizeof *cases;
         i++) { /* as images; their format shows in the bytes */
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

    /* padded with zeros, an unknown chunk between, the ending of another format */
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

/* Names of a file reach a terminal without their control characters, in errors and in warnings. */
static void printable(void **state)
{
    (void)state;
    static const float far[9] = {0, 0, 0, 1, 0, 0, 1e30f, 1, 0};
    const struct files_part parts[] = {{far, sizeof far, VEC3(3)}};
    const char *path = files_parts("far.gltf",
                                   "{\"attributes\":{\"POSITION\":0}}],\"name\":\"a\\u001b]0;"
                                   "b\\u0007\\u009b1m\\u007f\\n\\u00e4\",\"x\":[",
                                   node, "", "", parts, 1);
    const struct rnd_scene_options options = {.readers = files_readers(), .path = path, .env_path = files_env("env.exr", 1)};
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

/* --- materials --- */

/* Two texels, and a look at the plane between the middle of the dark one and their border: NEAREST shows the
 * dark one alone, as emission, as colour of each kind of material, and as coverage. */
static void nearest(void **state)
{
    (void)state;
    static const char *const materials[] = {
        "{\"emissiveFactor\":[1,1,1],\"emissiveTexture\":{\"index\":0},\"pbrMetallicRoughness\":{"
        "\"baseColorFactor\":[0,0,0,1]}}",
        "{\"pbrMetallicRoughness\":{\"metallicFactor\":0,\"baseColorTexture\":{\"index\":0}},\"extensions\":{"
        "\"KHR_materials_unlit\":{}}}",
        "{\"pbrMetallicRoughness\":{\"metallicFactor\":0,\"baseColorTexture\":{\"index\":0}},\"extensions\":{"
        "\"KHR_materials_specular\":{\"specularFactor\":0}}}",
        "{\"pbrMetallicRoughness\":{\"metallicFactor\":0,\"baseColorFactor\":[1,1,1,1],\"baseColorTexture\":{"
        "\"index\":0}},"
        "\"alphaMode\":\"BLEND\",\"extensions\":{\"KHR_materials_specular\":{\"specularFactor\":0}}}"};
    static const struct rnd_channel channels[4] = {
        {"R", RND_FLOAT}, {"G", RND_FLOAT}, {"B", RND_FLOAT}, {"A", RND_FLOAT}};
    const struct rnd_aim down = files_aim(0, -1, 0);
    for (int i = 0; i < 4; i++)
        for (int filter = 9728; filter <= 9729; filter++) {
            const float see = i == 3 ? 1 : 0, white[8] = {see, see, see, 1 - see, 1, 1, 1, 1};
            char more[300];
            files_pixels(files_path("two.exr"), "exr", 2, 1, 4, channels, white);
            snprintf(more, sizeof more,
                     ",\"textures\":[{\"source\":0,\"sampler\":0}],\"images\":[{\"uri\":\"two.exr\"}],"
                     "\"samplers\":[{\"magFilter\":%d,\"wrapS\":33071,\"wrapT\":33071}]",
                     filter);
            struct rnd_scene *scene = files_load(files_gltf("two.gltf", 4, node, materials[i], more),
                                                 files_env("env.exr", i == 0   ? 1e-6f
                                                                      : i == 3 ? 0.5f
                                                                               : 1),
                                                 NULL, (float[]){-1, 1, 0});
            const double seen = files_radiance(scene, "fv", i == 0 ? 1 : 0, 40000, &down, 5, NULL);
            /* the cover of a white surface under a sky of 1/2 is no matter, and its emission is that of one
             */
            const double dark = i == 3 ? 0.5 : 0, mixed = i == 3 ? 0.5 : 0.25;
            if (!(fabs(seen - (filter == 9728 ? dark : mixed)) < 0.02))
                fail_msg("material %d, filter %d: %g", i, filter, seen);
            rnd_scene_destroy(scene);
        }
}

/* A normal map that leans up its picture, under a sun 60 degrees over +Z: where the file's tangent and its w
 * turn the lean, in the world and through instances, mirrored and not, for plain and layered materials. */
static void tangents(void **state)
{
    (void)state;
    enum { MANY = 1200 };
    static const float up[12] = {0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0};
    static uint16_t many[6 * MANY];
    static const struct {
        float tangent[4]; /* zeros: none */
        const char *scale;
        int lean; /* to -Z 0, to +X 1, to +Z 2 */
    } cases[] = {
        {{0, 0, 0, 0}, "3,1,3", 0},   {{1, 0, 0, 1}, "3,1,3", 0},   {{1, 0, 0, -1}, "3,1,3", 2},
        {{-1, 0, 0, -1}, "3,1,3", 0}, {{0, 0, 1, 1}, "3,1,3", 1},   {{0, 0, -1, -1}, "3,1,3", 1},
        {{1, 0, 0, 1}, "-3,1,3", 0},  {{1, 0, 0, -1}, "-3,1,3", 2}, {{1, 0, 0, 1}, "3,1,-3", 2},
        {{1, 0, 0, 1}, "-3,1,-3", 2},
    };
    static const char *const kinds[] = {
        "", ",\"extensions\":{\"KHR_materials_specular\":{\"specularColorFactor\":[1,1,0.999]}}"};
    const struct rnd_aim down = files_aim(0, -1, 0);
    const float lean[3] = {0.5f, 0.75f, 0.9330127f}; /* 30 degrees */
    double expected[3] = {0};
    char error[RND_ERROR_SIZE], nodes[500], material[400];
    for (int i = 0; i < 6 * MANY; i++) many[i] = files_two[i % 6];
    assert_true(files_image(files_path("lean.exr"), 1, 1, lean, false, error));
    for (int kind = 0; kind < 2; kind++)
        for (size_t i = 0; i < 2 * sizeof cases / sizeof *cases; i++) {
            const bool instanced = i % 2;
            const float *t = cases[i / 2].tangent;
            float tangent[16];
            for (int k = 0; k < 16; k++) tangent[k] = t[k % 4];
            const struct files_part parts[] = {
                {files_corners, sizeof files_corners, VEC3(4)},
                {files_uvs, sizeof files_uvs, "\"componentType\":5126,\"count\":4,\"type\":\"VEC2\""},
                {many, sizeof many, SCALARS(5123, 7200)},
                {up, sizeof up, VEC3(4)},
                {tangent, sizeof tangent, "\"componentType\":5126,\"count\":4,\"type\":\"VEC4\""}};
            snprintf(nodes, sizeof nodes,
                     "{\"children\":[1,2%s]},{\"mesh\":0,\"scale\":[%s]},{\"rotation\":[-0.5,0,0,0.8660254],"
                     "\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}},{\"mesh\":0,\"translation\":[0,"
                     "-90,0]}",
                     instanced ? ",3" : "", cases[i / 2].scale);
            snprintf(material, sizeof material,
                     "{\"pbrMetallicRoughness\":{\"metallicFactor\":0},\"normalTexture\":{\"index\":0}%s}",
                     kinds[kind]);
            const char *path = files_parts(
                "tangent.gltf",
                t[3] == 0 ? "{\"attributes\":{\"POSITION\":0,\"TEXCOORD_0\":1,\"NORMAL\":3},\"indices\":2,"
                            "\"material\":0}"
                          : "{\"attributes\":{\"POSITION\":0,\"TEXCOORD_0\":1,\"NORMAL\":3,\"TANGENT\":4},"
                            "\"indices\":2,\"material\":0}",
                nodes, material,
                ",\"textures\":[{\"source\":0}],\"images\":[{\"uri\":\"lean.exr\"}],\"extensions\":{"
                "\"KHR_lights_punctual\":{\"lights\":[{\"type\":\"directional\",\"intensity\":3}]}}",
                parts, 5);
            struct rnd_scene *scene = files_load(path, NULL, NULL, (float[]){0.1f, 1, 0.1f});
            assert_int_equal(scene->instance_count, instanced ? 2 : 0);
            assert_int_equal(scene->material[0].kind, kind ? RND_RICH : RND_METAL_ROUGH);
            const double seen = files_radiance(scene, "fv", 0, 20000, &down, 10, NULL);
            double *as = &expected[cases[i / 2].lean];
            if (*as == 0) *as = seen;
            if (!(fabs(seen / *as - 1) < 0.01))
                fail_msg("kind %d, case %zu: %g, expected %g", kind, i, seen, *as);
            rnd_scene_destroy(scene);
        }
    print_message("%g %g %g\n", expected[0], expected[1], expected[2]);
    assert_true(expected[1] > 1.2 * expected[0] && expected[2] > 1.2 * expected[1]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(components),      cmocka_unit_test(quantized), cmocka_unit_test(sparse),
        cmocka_unit_test(wrong_accessors), cmocka_unit_test(modes),     cmocka_unit_test(shared_vertices),
        cmocka_unit_test(roots),           cmocka_unit_test(names),     cmocka_unit_test(versions),
        cmocka_unit_test(extensions),      cmocka_unit_test(nearest),   cmocka_unit_test(tangents),
        cmocka_unit_test(draco),           cmocka_unit_test(printable), cmocka_unit_test(too_much),
    };
    return cmocka_run_group_tests_name("renderer_gltf", tests, files_setup, files_teardown);
}
