/* Vertices and nodes in scene files: colours, coordinates, first frames, instances. */
#include "renderer_parts.h"
#include "material/shading.h"
#include "material/surface.h"

static const char node[] = "{\"mesh\":0}";

static void colours_and_sets(void **state)
{
    (void)state;
    static const float rgb[12] = {1, 0.5f, 0, 0, 0, 0, 0, 0, 2, 1, 1, 1},
                       rgba[16] = {1, 0.5f, 0, 0.25f, [15] = 1};
    static const uint8_t bytes[16] = {255, 128, 0, 51};
    static const uint16_t words[16] = {65535, 32768, 0, 13107};
    static const float second[8] = {5, 6, 7, 8};
    const struct {
        struct files_part colour;
        float alpha;
    } cases[] = {
        {{rgb, sizeof rgb, "\"componentType\":5126,\"count\":4,\"type\":\"VEC3\""}, 1.0f},
        {{rgba, sizeof rgba, "\"componentType\":5126,\"count\":4,\"type\":\"VEC4\""}, 0.25f},
        {{bytes, sizeof bytes, "\"componentType\":5121,\"normalized\":true,\"count\":4,\"type\":\"VEC4\""},
         0.2f},
        {{words, sizeof words, "\"componentType\":5123,\"normalized\":true,\"count\":4,\"type\":\"VEC4\""},
         0.2f}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const struct files_part parts[] = {
            FILES_SQUARE,
            cases[i].colour,
            {second, sizeof second, "\"componentType\":5126,\"count\":4,\"type\":\"VEC2\""}};
        const char *path = files_parts("c.gltf",
                                       "{\"attributes\":{\"POSITION\":0,\"TEXCOORD_0\":1,\"COLOR_0\":3,"
                                       "\"TEXCOORD_1\":4},\"indices\":2,\"material\":0}",
                                       node, "{}", "", parts, 5);
        struct rnd_scene *scene = files_load(path, files_env("env.exr", 1), NULL, NULL);
        const struct rnd_mesh *mesh = &scene->mesh[0];
        assert_non_null(mesh->colour);
        assert_non_null(mesh->uv[1]);
        assert_null(mesh->normal);
        NEAR(mesh->colour[0], 1), NEAR(mesh->colour[1], i < 2 ? 0.5 : i == 2 ? 128 / 255.0 : 32768 / 65535.0);
        NEAR(mesh->colour[3], cases[i].alpha);
        if (i == 0) NEAR(mesh->colour[10], 1); /* clamped to 1 */
        NEAR(mesh->uv[1][0], 5), NEAR(mesh->uv[1][3], 8), NEAR(mesh->uv[0][2], 0), NEAR(mesh->uv[0][3], 1);
        rnd_scene_destroy(scene);
    }
}

static void first_frame(void **state)
{
    (void)state;
    static const float times[2] = {0, 1}, moves[6] = {1, 2, 3, 9, 9, 9},
                       turns[8] = {0, 0.70710678f, 0, 0.70710678f},
                       spline[18] = {9, 9, 9, 2, 2, 2, 9, 9, 9, 9, 9, 9, 9, 9, 9, 9, 9, 9};
    const struct files_part parts[] = {
        FILES_SQUARE,
        {times, sizeof times, "\"componentType\":5126,\"count\":2,\"type\":\"SCALAR\""},
        {moves, sizeof moves, "\"componentType\":5126,\"count\":2,\"type\":\"VEC3\""},
        {turns, sizeof turns, "\"componentType\":5126,\"count\":2,\"type\":\"VEC4\""},
        {spline, sizeof spline, "\"componentType\":5126,\"count\":6,\"type\":\"VEC3\""}};
    const char *path = files_parts(
        "moves.gltf", files_primitive, "{\"mesh\":0,\"scale\":[1,1,5],\"translation\":[7,7,7]}", "{}",
        ",\"animations\":[{\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,\"path\":\"translation\"}},"
        "{\"sampler\":1,\"target\":{\"node\":0,\"path\":\"rotation\"}},{\"sampler\":2,\"target\":{\"node\":0,"
        "\"path\":\"scale\"}}],\"samplers\":[{\"input\":3,\"output\":4},{\"input\":3,\"output\":5},{"
        "\"input\":3,"
        "\"output\":6,\"interpolation\":\"CUBICSPLINE\"}]}]",
        parts, 7);
    struct rnd_scene *scene = files_load(path, files_env("env.exr", 1), NULL, NULL);
    /* (-1, 0, -1) is doubled, turned by a quarter around y, and moved */
    NEAR(scene->mesh[0].position[0], -2 + 1), NEAR(scene->mesh[0].position[1], 2);
    NEAR(scene->mesh[0].position[2], 2 + 3);
    assert_string_equal(rnd_scene_info(scene)->unsupported, "animation (its first frame is shown)");
    rnd_scene_destroy(scene);

    char error[RND_ERROR_SIZE] = "";
    path = files_parts("short.gltf", files_primitive, node, "{}",
                       ",\"animations\":[{\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,\"path\":"
                       "\"rotation\"}}],\"samplers\":[{\"input\":3,\"output\":4}]}]",
                       parts, 7);
    const struct rnd_scene_options options = {
        .image_program = files_image_program(), .path = path, .env_path = files_path("env.exr")};
    assert_null(rnd_scene_load(&options, error));
    assert_non_null(strstr(error, "short.gltf: animations[0].samplers[0].output: expected"));
}

/* What a ray straight down at (x, z) hits: the instance is returned; mesh, point and normal are in the world.
 */
static const struct rnd_instance *look_down(const struct rnd_scene *scene, float x, float z,
                                            uint32_t *out_mesh, vec3s *out_point, vec3s *out_normal)
{
    struct RTCRayHit hit = {
        .ray = {.org_x = x, .org_y = 50, .org_z = z, .dir_y = -1, .tfar = INFINITY, .mask = UINT32_MAX},
        .hit = {.geomID = RTC_INVALID_GEOMETRY_ID, .instID = {RTC_INVALID_GEOMETRY_ID}}};
    rnd_embree_intersect1(scene->tree, &hit);
    if (hit.hit.geomID == RTC_INVALID_GEOMETRY_ID) fail_msg("nothing at %g, %g", x, z);
    const struct rnd_instance *instance = rnd_resolve_hit(scene, hit.hit.geomID, hit.hit.instID[0], out_mesh);
    const struct rnd_mesh *mesh = &scene->mesh[*out_mesh];
    for (int c = 0; c < 3; c++)
        out_point->raw[c] =
            rnd_interpolate(mesh->position, 3, c, mesh->index[hit.hit.primID], hit.hit.u, hit.hit.v);
    *out_normal = (vec3s){{hit.hit.Ng_x, hit.hit.Ng_y, hit.hit.Ng_z}};
    if (instance) {
        *out_point = rnd_instance_point(instance, *out_point);
        *out_normal = rnd_from_v3(rnd_normal_to_world(instance, rnd_to_v3(*out_normal)));
    }
    return instance;
}

enum { MANY = 1200 };

/* The parts of a mesh that is the square repeated, so large that its instances share it. */
static const struct files_part *square_many_times(void)
{
    static uint16_t many[6 * MANY];
    static struct files_part parts[] = {FILES_SQUARE};
    for (int i = 0; i < 6 * MANY; i++) many[i] = files_two[i % 6];
    parts[2] =
        (struct files_part){many, sizeof many, "\"componentType\":5123,\"count\":7200,\"type\":\"SCALAR\""};
    return parts;
}

static void instances(void **state)
{
    (void)state;
    const struct files_part *parts = square_many_times();
    static const char nodes[] =
        "{\"children\":[1,2,3,4]},{\"mesh\":0,\"translation\":[0,1,0]},{\"mesh\":0,\"translation\":[10,2,0],"
        "\"scale\":[-2,1,1]},{\"mesh\":0,\"translation\":[20,3,0],\"rotation\":[1,0,0,0]},"
        "{\"mesh\":0,\"translation\":[30,4,0],\"scale\":[1,0,1]}"; /* the last has no inverse */
    struct rnd_scene *scene =
        files_load(files_parts("often.gltf", files_primitive, nodes, "{}", "", parts, 3),
                   files_env("env.exr", 1), NULL, NULL);
    assert_int_equal(scene->instance_count, 3);
    assert_int_equal(scene->mesh_count, 2);
    assert_int_equal(rnd_scene_info(scene)->triangles, 4 * 2 * MANY);
    NEAR(rnd_scene_info(scene)->bounds[1][0], 31), NEAR(rnd_scene_info(scene)->bounds[0][0], -1);
    for (int i = 0; i < 4; i++) {
        uint32_t mesh;
        vec3s point, normal;
        const float x = 10.0f * i + (i == 1 ? 1.5f : 0.4f);
        const struct rnd_instance *instance = look_down(scene, x, 0.3f, &mesh, &point, &normal);
        assert_true(i == 3 ? instance == NULL : instance != NULL);
        NEAR(point.x, x), NEAR(point.y, 1 + i), NEAR(point.z, 0.3);
        if (i < 3)
            assert_true(i == 2 ? normal.y < 0 : normal.y > 0); /* mirrored keeps its side, turned does not */
        assert_int_equal(scene->mesh[mesh].instanced, i < 3);
    }
    rnd_scene_destroy(scene);

    /* Emissive meshes and small ones are copied into the world. */
    scene = files_load(
        files_parts("shine.gltf", files_primitive, nodes, "{\"emissiveFactor\":[1,1,1]}", "", parts, 3), NULL,
        NULL, NULL);
    assert_int_equal(scene->instance_count, 0);
    assert_int_equal(scene->mesh_count, 4);
    rnd_scene_destroy(scene);
    const struct files_part few[] = {FILES_SQUARE};
    scene = files_load(files_parts("few.gltf", files_primitive, nodes, "{}", "", few, 3),
                       files_path("env.exr"), NULL, NULL);
    assert_int_equal(scene->instance_count, 0);
    rnd_scene_destroy(scene);
}

/* Under a white sky a grey instance is as bright as the same mesh in the world. */
static void instances_shaded(void **state)
{
    (void)state;
    const struct files_part *parts = square_many_times();
    static const char twice[] =
        "{\"children\":[1,2]},{\"mesh\":0,\"translation\":[0,-1,0],\"scale\":[3,1,3]},"
        "{\"mesh\":0,\"translation\":[0,-9,0]}";
    const struct rnd_aim down = files_aim(0, -1, 0);
    struct rnd_scene *scene =
        files_load(files_parts("grey.gltf", files_primitive, twice, FILES_GREY, "", parts, 3),
                   files_env("env.exr", 1), NULL, (float[]){0, 0, 0});
    assert_int_equal(scene->instance_count, 2);
    assert_float_equal(files_radiance(scene, "fv", 0, 40000, &down, 20, NULL), 0.5, files_off(0.01));
    rnd_scene_destroy(scene);
    /* A camera between the two does not see the back of the upper one. */
    scene = files_load(files_path("grey.gltf"), files_path("env.exr"), NULL, (float[]){0, -5, 0});
    const struct rnd_aim up = files_aim(0, 1, 0);
    assert_float_equal(files_radiance(scene, "fv", 0, 20000, &up, 20, NULL), 1, 1e-5);
    rnd_scene_destroy(scene);
}

/* A normal map that leans towards the top of its picture looks the same through a mirrored instance, in the
 * world with a mirrored node, and through an instance that is not mirrored. An instance mirrored along v
 * leans the other way. */
static void instances_mirrored(void **state)
{
    (void)state;
    static const char material[] =
        "{\"pbrMetallicRoughness\":{\"metallicFactor\":0},\"normalTexture\":{\"index\":0}}",
                      more[] = ",\"textures\":[{\"source\":0}],\"images\":[{\"uri\":\"lean.exr\"}],"
                               "\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[{\"type\":"
                               "\"directional\",\"intensity\":3}]}}";
#define LEAN_LIGHT                                                                                           \
    "{\"rotation\":[-0.5,0,0,0.8660254],\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}}"
    /* the sun is 60 degrees above +Z; v grows towards +Z, so the map leans to -Z */
    static const char *const nodes[] = {"{\"children\":[1,2,3]},{\"mesh\":0,\"scale\":[-3,1,3]},{\"mesh\":0,"
                                        "\"translation\":[0,-90,0]}," LEAN_LIGHT,
                                        "{\"children\":[1,2]},{\"mesh\":0,\"scale\":[-3,1,3]}," LEAN_LIGHT,
                                        "{\"children\":[1,2,3]},{\"mesh\":0,\"scale\":[3,1,3]},{\"mesh\":0,"
                                        "\"translation\":[0,-90,0]}," LEAN_LIGHT,
                                        "{\"children\":[1,2,3]},{\"mesh\":0,\"scale\":[3,1,-3]},{\"mesh\":0,"
                                        "\"translation\":[0,-90,0]}," LEAN_LIGHT};
    const struct files_part *parts = square_many_times();
    const struct rnd_aim down = files_aim(0, -1, 0);
    const float lean[3] = {0.5f, 0.75f, 0.9330127f}; /* 30 degrees */
    char error[RND_ERROR_SIZE];
    double seen[4];
    assert_true(files_image(files_path("lean.exr"), 1, 1, lean, false, error));
    for (int i = 0; i < 4; i++) {
        struct rnd_scene *scene =
            files_load(files_parts("mirrored.gltf", files_primitive, nodes[i], material, more, parts, 3),
                       NULL, NULL, (float[]){0.1f, 1, 0.1f});
        assert_int_equal(scene->instance_count, i == 1 ? 0 : 2);
        seen[i] = files_radiance(scene, "fv", 0, 20000, &down, 20, NULL);
        rnd_scene_destroy(scene);
    }
    print_message("%g %g %g %g\n", seen[0], seen[1], seen[2], seen[3]);
    assert_float_equal(seen[0], seen[1], 1e-3 * seen[1]);
    assert_float_equal(seen[0], seen[2], 1e-3 * seen[2]);
    assert_true(seen[3] > 1.5 * seen[0]);
}

static void gpu_instances(void **state)
{
    (void)state;
    static const float places[6] = {5, 0, 0, -5, 1, 0}, sizes[6] = {1, 1, 1, 2, 2, 2};
    const struct files_part parts[] = {
        FILES_SQUARE,
        {places, sizeof places, "\"componentType\":5126,\"count\":2,\"type\":\"VEC3\""},
        {sizes, sizeof sizes, "\"componentType\":5126,\"count\":2,\"type\":\"VEC3\""}};
    static const char nodes[] =
        "{\"mesh\":0,\"translation\":[0,0,1],\"extensions\":{\"EXT_mesh_gpu_instancing\":{"
        "\"attributes\":{\"TRANSLATION\":3,\"SCALE\":4}}}}";
    struct rnd_scene *scene = files_load(files_parts("gpu.gltf", files_primitive, nodes, "{}", "", parts, 5),
                                         files_env("env.exr", 1), NULL, NULL);
    assert_int_equal(scene->mesh_count, 2);
    NEAR(scene->mesh[0].position[0], 4), NEAR(scene->mesh[1].position[0], -7),
        NEAR(scene->mesh[1].position[1], 1);
    NEAR(scene->mesh[1].position[2], -1);
    rnd_scene_destroy(scene);
}

/* Thousands of teapots, instanced by EXT_mesh_gpu_instancing. */
static void blender_instances(void **state)
{
    (void)state;
    static const char path[] = SHARED_DATA "/scenes/gltf-tests/24_gpu_instancing/24_gpu_instancing.gltf";
    if (access(path, R_OK) != 0) {
        print_message("skipped: no %s\n", path);
        skip();
    }
    struct rnd_scene *scene = files_load(path, files_env("env.exr", 1), NULL, NULL);
    assert_int_equal(scene->instance_count, 958 + 941);
    rnd_scene_destroy(scene);
}

/* Nodes of the same name share a light and a camera: each node has its own light, and the camera is at the
 * first. */
static void shared_light(void **state)
{
    (void)state;
    static const char nodes[] =
        "{\"mesh\":0,\"children\":[1,2]},"
        "{\"name\":\"emitter\",\"translation\":[1,2,3],\"camera\":0,"
        "\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}},"
        "{\"name\":\"emitter\",\"translation\":[4,5,6],\"rotation\":[1,0,0,0],\"camera\":0,"
        "\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}}";
    static const char *const lights[] = {
        "{\"type\":\"spot\",\"intensity\":2,\"color\":[1,0.5,0.25],\"spot\":{\"outerConeAngle\":1.5}}", "",
        "{\"type\":\"lamp\"}", "{\"type\":\"point\",\"intensity\":-1}",
        "{\"type\":\"point\",\"color\":[1,1e99,1]}"};
    static const char *const wrong[] = {
        NULL, "nodes[1].extensions.KHR_lights_punctual.light: expected the index of one of 0",
        "expected point, spot", "none negative", "none negative"};
    for (size_t i = 0; i < sizeof lights / sizeof *lights; i++) {
        char more[400], error[RND_ERROR_SIZE] = "";
        snprintf(more, sizeof more,
                 ",\"cameras\":[{\"type\":\"perspective\"}],"
                 "\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[%s]}}",
                 lights[i]);
        const struct rnd_scene_options options = {.image_program = files_image_program(),
                                                  .path = files_gltf("emitters.gltf", 1, nodes, "{}", more)};
        struct rnd_scene *scene = rnd_scene_load(&options, error);
        if (wrong[i]) {
            assert_null(scene);
            if (!strstr(error, wrong[i])) fail_msg("%s: expected %s", error, wrong[i]);
            continue;
        }
        if (!scene) fail_msg("%s", error);
        const struct rnd_punctual *at = scene->lights.punctual;
        assert_int_equal(rnd_scene_info(scene)->punctual_lights, 2);
        NEAR(at[0].position.x, 1), NEAR(at[1].position.x, 4), NEAR(at[1].position.z, 6);
        NEAR(at[0].direction.z, -1), NEAR(at[1].direction.z, 1);
        NEAR(at[1].intensity.x, 2), NEAR(at[1].intensity.z, 0.5f);
        NEAR(at[0].drop_inner, 0), NEAR(at[0].drop_outer, 1 - cosf(1.5f));
        NEAR(rnd_scene_info(scene)->camera[1], 2);
        rnd_scene_destroy(scene);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(colours_and_sets),   cmocka_unit_test(first_frame),
        cmocka_unit_test(instances),          cmocka_unit_test(instances_shaded),
        cmocka_unit_test(instances_mirrored), cmocka_unit_test(gpu_instances),
        cmocka_unit_test(blender_instances),  cmocka_unit_test(shared_light),
    };
    return cmocka_run_group_tests_name("renderer_nodes_import", tests, files_setup, files_teardown);
}
