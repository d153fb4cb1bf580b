/* Meshes and nodes of glTF: primitives of every mode, compressed ones, tangents, and which nodes are shown.
 */
#include "renderer_gltf.h"

/* --- primitives --- */

/* A square as a list, strip and fan, with and without indices. Points and lines beside it are left out. */
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

/* Primitives that share one large array of vertices get only the vertices that they use, whether these lie in
 * a row or apart. */
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

/* The square from -1 to 1 with normals, texture coordinates and colours, compressed by Draco 1.5.5. */
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
            for (int k = 0; k < 3; k++) { /* texture coordinates match positions */
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
    for (size_t i = 4; i < sizeof draco_square - 5; i += 7) { /* loads or is refused */
        char error[RND_ERROR_SIZE] = "";
        memcpy(spoiled, draco_square, sizeof spoiled);
        spoiled[i] = spoiled[i] == 'A' ? 'z' : 'A';
        const struct rnd_scene_options options = {.image_program = files_image_program(),
                                                  .path =
                                                      with_draco("spoiled.gltf", indices[0], "0", spoiled),
                                                  .env_path = files_path("env.exr")};
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
        /* as UniGLTF writes it: the parent is not shown */
        {"\"scenes\":[{\"nodes\":[1]}]", "{\"translation\":[5,0,0],\"children\":[1]},{\"mesh\":0}",
         "scenes[0].nodes: 1 of them is a child of another node", 1, -1},
        /* node and parent are listed: shown once, below the parent */
        {"\"scenes\":[{\"nodes\":[1,0]}]", "{\"translation\":[5,0,0],\"children\":[1]},{\"mesh\":0}",
         "scenes[0].nodes: 1 of them is a child", 1, 4},
        {"\"scenes\":[{\"nodes\":[1,0,2]}]", "{\"children\":[1]},{\"mesh\":0,\"children\":[2]},{\"mesh\":0}",
         "2 of them are children", 2, -1},
        {"\"scenes\":[{\"nodes\":[0,0]}]", "{\"mesh\":0}", NULL, 1, -1},
        /* the default scene, and a file without scenes */
        {"\"scenes\":[{\"nodes\":[1]},{\"nodes\":[0]}]", "{\"mesh\":0},{\"mesh\":0,\"translation\":[3,0,0]}",
         NULL, 1, 2},
        {"\"scenes\":[]", "{\"children\":[1]},{\"mesh\":0,\"translation\":[3,0,0]}", NULL, 1, 2},
        /* a hidden node hides all nodes below it */
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

/* --- tangents --- */

static const struct {
    float tangent[4]; /* all 0: no tangents */
    const char *scale;
    int lean; /* leans to 0: -Z, 1: +X, 2: +Z */
} LEANS[] = {
    {{0, 0, 0, 0}, "3,1,3", 0},   {{1, 0, 0, 1}, "3,1,3", 0},   {{1, 0, 0, -1}, "3,1,3", 2},
    {{-1, 0, 0, -1}, "3,1,3", 0}, {{0, 0, 1, 1}, "3,1,3", 1},   {{0, 0, -1, -1}, "3,1,3", 1},
    {{1, 0, 0, 1}, "-3,1,3", 0},  {{1, 0, 0, -1}, "-3,1,3", 2}, {{1, 0, 0, 1}, "3,1,-3", 2},
    {{1, 0, 0, 1}, "-3,1,-3", 2},
};
static const char *const KINDS[] = {
    "", ",\"extensions\":{\"KHR_materials_specular\":{\"specularColorFactor\":[1,1,0.999]}}"};

/* A normal map that leans up its picture, under a sun 60 degrees above +Z. The file's tangents and their w
 * turn the lean in the same way in the world and through instances, mirrored or not, for plain and layered
 * materials. */
static void tangents(void **state)
{
    (void)state;
    enum { MANY = 1200 };
    static const float up[12] = {0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0};
    static uint16_t many[6 * MANY];
    const struct rnd_aim down = files_aim(0, -1, 0);
    const float lean[3] = {0.5f, 0.75f, 0.9330127f}; /* 30 degrees */
    double expected[3] = {0};
    char error[RND_ERROR_SIZE], nodes[500], material[400];
    for (int i = 0; i < 6 * MANY; i++) many[i] = files_two[i % 6];
    assert_true(files_image(files_path("lean.exr"), 1, 1, lean, false, error));
    for (int kind = 0; kind < 2; kind++)
        for (size_t i = 0; i < 2 * sizeof LEANS / sizeof *LEANS; i++) {
            const bool instanced = i % 2;
            const float *t = LEANS[i / 2].tangent;
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
                     instanced ? ",3" : "", LEANS[i / 2].scale);
            snprintf(material, sizeof material,
                     "{\"pbrMetallicRoughness\":{\"metallicFactor\":0},\"normalTexture\":{\"index\":0}%s}",
                     KINDS[kind]);
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
            double *as = &expected[LEANS[i / 2].lean];
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
        cmocka_unit_test(modes),    cmocka_unit_test(shared_vertices), cmocka_unit_test(roots),
        cmocka_unit_test(tangents), cmocka_unit_test(draco),
    };
    return cmocka_run_group_tests_name("renderer_gltf_meshes", tests, files_setup, files_teardown);
}
