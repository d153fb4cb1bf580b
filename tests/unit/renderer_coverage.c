/* Coverage of sheets, backs of sheets, and unfiltered textures. */
#include "renderer_materials.h"

/* Check how much of a white sky shows to the left and to the right through a black sheet that lies at y = 0
 * below the camera. */
static void assert_seen(const char *material, double left, double right, double tolerance)
{
    write_halves("halves.png", 0, 0.75f);
    struct rnd_scene *scene = with_material(material, ",\"textures\":[{\"source\":0}],\"images\":[{\"uri\":"
                                                      "\"halves.png\"}]");
    const struct rnd_aim aims[2] = {files_aim(-0.5, -1, 0), files_aim(0.5, -1, 0)};
    rnd_scene_destroy(scene);
    scene = files_load(files_path("m.gltf"), files_path("env.exr"), NULL, (float[]){0, 1, 0});
    for (int i = 0; i < 2; i++)
        assert_float_equal(files_radiance(scene, "fv", 0, 40000, &aims[i], 8, NULL), i ? right : left,
                           files_off(tolerance));
    rnd_scene_destroy(scene);
}

#define BLACK(mode, alpha, map)                                                                              \
    "{\"alphaMode\":\"" mode                                                                                 \
    "\",\"pbrMetallicRoughness\":{\"metallicFactor\":0,\"baseColorFactor\":[0,0,0," alpha "]" map            \
    "},\"extensions\":{\"KHR_materials_specular\":{\"specularFactor\":0}}}"
#define HALVES ",\"baseColorTexture\":{\"index\":0}"

static void coverage(void **state)
{
    (void)state;
    assert_seen(BLACK("OPAQUE", "0.3", HALVES), 0, 0, 1e-6);
    assert_seen(BLACK("MASK", "1", HALVES), 1, 0, 1e-6);
    assert_seen(BLACK("MASK", "0.6", HALVES), 1, 1, 1e-6); /* 0.45 is below the cut-off */
    assert_seen(BLACK("MASK", "0.4", ""), 1, 1, 1e-6);
    assert_seen(BLACK("MASK", "0.6", ""), 0, 0, 1e-6);
    assert_seen(BLACK("BLEND", "0.3", ""), 0.7, 0.7, 0.02);
    assert_seen(BLACK("BLEND", "0.4", HALVES), 1, 0.7, 0.02);
    assert_seen(BLACK("BLEND", "1", ""), 0, 0, 1e-6);
}

/* A floor is lit by shadow rays through a wide sheet above it. The camera is between them. */
static void coverage_of_shadows(void **state)
{
    (void)state;
    files_text("s.mtl", "newmtl floor\nKd 0.5 0.5 0.5\nnewmtl sheet\nKd 0 0 0\nd 0.3\n");
    const char *path = files_text(
        "s.obj", "mtllib s.mtl\nv -99 -1 -99\nv -99 -1 99\nv 99 -1 99\nv 99 -1 -99\nv -99 1 -99\nv -99 1 99\n"
                 "v 99 1 99\nv 99 1 -99\nusemtl floor\nf 1 2 3 4\nusemtl sheet\nf 5 6 7 8\n");
    struct rnd_scene *scene = files_load(path, files_env("env.exr", 1), NULL, (float[]){0, 0, 0});
    const struct rnd_aim down = files_aim(0, -1, 0);
    assert_float_equal(files_radiance(scene, "fv", 0, 100000, &down, 30, NULL), 0.5 * 0.7, files_off(0.01));
    rnd_scene_destroy(scene);
}

/* A grey single-sided sheet above a single-sided floor, under a white sky. A camera between them sees the sky
 * through the sheet's back, and the floor is in the sheet's shadow. Mirroring the sheet shows its other side.
 */
static void backs(void **state)
{
    (void)state;
    static const struct {
        const char *sheet;
        bool double_sided, seen;
    } cases[] = {{"", false, false},
                 {"", true, true},
                 {",\"scale\":[1,-1,1]", false, true},
                 {",\"rotation\":[1,0,0,0]", false, true},
                 {",\"rotation\":[1,0,0,0],\"scale\":[1,-1,1]", false, false}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char nodes[400], material[400];
        snprintf(nodes, sizeof nodes,
                 "{\"children\":[1,2]},{\"mesh\":0,\"translation\":[0,-1,0]},{\"mesh\":0%s}", cases[i].sheet);
        snprintf(
            material, sizeof material,
            "{\"doubleSided\":%s,\"pbrMetallicRoughness\":{\"metallicFactor\":0,\"baseColorFactor\":[0.5,0.5,"
            "0.5,1]},\"extensions\":{\"KHR_materials_specular\":{\"specularFactor\":0}}}",
            cases[i].double_sided ? "true" : "false");
        struct rnd_scene *scene = files_load(files_gltf("backs.gltf", 500, nodes, material, ""),
                                             files_env("env.exr", 1), NULL, (float[]){0, -0.5f, 0});
        const struct rnd_aim up = files_aim(0, 1, 0), down = files_aim(0, -1, 0);
        const double sky = files_radiance(scene, "fv", 4, 20000, &up, 20, NULL),
                     floor = files_radiance(scene, "fv", 4, 20000, &down, 20, NULL);
        print_message("sheet%s: %.4f above, %.4f below, %u instances\n", cases[i].sheet, sky, floor,
                      scene->instance_count);
        assert_float_equal(sky, cases[i].seen ? 0 : 1, 0.01);
        assert_float_equal(floor, 0, 0.01);
        rnd_scene_destroy(scene);
    }
}

/* A texture of a dark and a bright texel, seen between the middle of the dark one and their border. With
 * NEAREST only the dark texel shows: as emission, as colour of each kind of material, and as coverage. */
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
        "{\"pbrMetallicRoughness\":{\"metallicFactor\":0,\"baseColorFactor\":[0,0,0,1],\"baseColorTexture\":{"
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
            /* A black surface hides the sky of 1/2 where it covers it: nowhere, or by a quarter. */
            const double dark = i == 3 ? 0.5 : 0, mixed = i == 3 ? 0.375 : 0.25;
            if (!(fabs(seen - (filter == 9728 ? dark : mixed)) < files_off(0.02)))
                fail_msg("material %d, filter %d: %g", i, filter, seen);
            rnd_scene_destroy(scene);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(coverage),
        cmocka_unit_test(coverage_of_shadows),
        cmocka_unit_test(backs),
        cmocka_unit_test(nearest),
    };
    return cmocka_run_group_tests_name("renderer_coverage", tests, files_setup, files_teardown);
}
