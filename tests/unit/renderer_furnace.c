/* Scenes whose radiance is known in closed form: furnaces, suns, a rectangular emitter, environments. */
#include "renderer_parts.h"

static const double deg = M_PI / 180.0;

/* Albedo 0.5 and emission 1 everywhere: the radiance is 1 + 1/2 + 1/4 + ... = 2, or the first terms of that
 * sum if bounces are limited. */
static void closed_furnace(void **state)
{
    (void)state;
    static const char *const modes[] = {"od", "vp", "fv", "fv-exact"};
    const char *path = files_box_scene("furnace", "newmtl m\nKd 0.5 0.5 0.5\nKe 1 1 1\n",
                                       (double[]){-1, -1, -1}, (double[]){1, 1, 1});
    struct rnd_scene *scene = files_load(path, NULL, NULL, NULL);
    const struct rnd_aim aim = files_aim(0.3, 0.2, -1);
    char what[64];
    for (int i = 0; i < 4; i++) {
        snprintf(what, sizeof what, "closed furnace, %s", modes[i]);
        assert_within(what, files_radiance(scene, modes[i], 0, 200000, &aim, 180, NULL), 2.0, 0.005);
    }
    double series = 1.0, term = 1.0;
    for (int bounces = 1; bounces <= 5; bounces++) {
        series += term *= 0.5;
        snprintf(what, sizeof what, "closed furnace, %d bounces", bounces);
        assert_within(what, files_radiance(scene, "od", bounces, 200000, &aim, 180, NULL), series, 0.005);
    }
    rnd_scene_destroy(scene);
}

/* A convex grey object in a white world: every face sees only the sky. */
static void convex_in_white(void **state)
{
    (void)state;
    const char *env = files_env("white.hdr", 1.0f);
    const char *path = files_box_scene("convex", "newmtl m\nKd 0.5 0.25 0.75\n", (double[]){-1, -1, -1},
                                       (double[]){1, 1, 1});
    struct rnd_scene *scene = files_load(path, env, NULL, (float[]){4, 3, 5});
    const struct rnd_aim aim = files_aim(-4, -3, -5);
    float rgb[3];
    files_radiance(scene, "fv", 0, 200000, &aim, 6, rgb);
    assert_within("convex in a white world, red", rgb[0], 0.5, 0.005);
    assert_within("convex in a white world, green", rgb[1], 0.25, 0.005);
    assert_within("convex in a white world, blue", rgb[2], 0.75, 0.005);
    const struct rnd_aim away = files_aim(4, 3, 5);
    assert_within("the white world itself", files_radiance(scene, "fv", 0, 20000, &away, 30, NULL), 1.0,
                  1e-5);
    rnd_scene_destroy(scene);
}

/* An unlit surface shows its base colour without any light. The rest of the picture is black. */
static void unlit_without_light(void **state)
{
    (void)state;
    const char *path = files_gltf("unlit.gltf", 3, "{\"mesh\":0,\"translation\":[0,-1,0]}",
                                  "{\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.5,0.25,0.75,1]},"
                                  "\"doubleSided\":true,\"extensions\":{\"KHR_materials_unlit\":{}}}",
                                  "");
    struct rnd_scene *scene = files_load(path, NULL, NULL, (float[]){0, 0, 0});
    const struct rnd_aim down = files_aim(0, -1, 0), up = files_aim(0, 1, 0);
    float rgb[3];
    files_radiance(scene, "fv", 0, 20000, &down, 20, rgb);
    assert_within("unlit without a light, red", rgb[0], 0.5, 1e-5);
    assert_within("unlit without a light, green", rgb[1], 0.25, 1e-5);
    assert_within("unlit without a light, blue", rgb[2], 0.75, 1e-5);
    assert_true(files_radiance(scene, "fv", 0, 20000, &up, 20, NULL) == 0.0);
    rnd_scene_destroy(scene);
}

/* A sun of irradiance E above a plane gives a radiance of albedo / pi E sin(elevation), whatever its
 * diameter, as long as all of it is above the horizon. */
static void sun_on_plane(void **state)
{
    (void)state;
    static const float suns[][4] = {{30, 45, 3, 0},     {-120, 20, 3, 0.53f}, {30, 80, 3, 0.53f},
                                    {30, 45, 3, 0.01f}, {30, 45, 3, 0.1f},    {200, 45, 2, 20},
                                    {90, 30, 2, 59}};
    const char *path = files_box_scene("plane", "newmtl m\nKd 0.8 0.8 0.8\n", (double[]){-100, -1, -100},
                                       (double[]){100, 0, 100});
    const struct rnd_aim aim = files_aim(0, -1, 0);
    for (size_t i = 0; i < sizeof suns / sizeof *suns; i++) {
        struct rnd_scene *scene = files_load(path, NULL, suns[i], (float[]){0, 1, 0});
        char what[64];
        snprintf(what, sizeof what, "sun of %g degrees, %g high", suns[i][3], suns[i][1]);
        assert_within(what, files_radiance(scene, "fv", 0, 100000, &aim, 40, NULL),
                      0.8 / M_PI * suns[i][2] * sin(suns[i][1] * deg), 0.002);
        rnd_scene_destroy(scene);
    }
}

/* The camera sees the sun's disc with the radiance that its irradiance implies, E / (pi sin^2 r), and nothing
 * beside it. */
static void sun_seen(void **state)
{
    (void)state;
    const double r = 10.0 * deg, expected = 3.0 / (M_PI * sin(r) * sin(r));
    const char *path =
        files_box_scene("speck", "newmtl m\nKd 0 0 0\n", (double[]){0, -50, 0}, (double[]){1, -49, 1});
    struct rnd_scene *scene = files_load(path, NULL, (float[]){90, 30, 3, 20}, (float[]){0, 0, 0});
    const struct rnd_aim at = files_aim(cos(30 * deg), sin(30 * deg), 0), below = files_aim(1, 0, 0);
    assert_within("the sun's disc", files_radiance(scene, "fv", 0, 20000, &at, 8, NULL), expected, 1e-4);
    assert_true(files_radiance(scene, "fv", 0, 20000, &below, 10, NULL) == 0.0);
    rnd_scene_destroy(scene);
}

/* Form factor of a rectangle a x b at height 1 to a parallel element below its corner (Howell's catalogue,
 * B-3). */
static double corner_form_factor(double a, double b)
{
    const double p = sqrt(1 + a * a), q = sqrt(1 + b * b);
    return (a / p * atan(b / p) + b / q * atan(a / q)) / (2.0 * M_PI);
}

/* A floor seen from a centimetre above, under a rectangular emitter at a height of 1.5 m. */
static void rectangle_of_light(void **state)
{
    (void)state;
    files_text("emitter.mtl", "newmtl floor\nKd 0.6 0.6 0.6\nnewmtl emitter\nKd 0 0 0\nKe 5 5 5\n");
    const char *path =
        files_text("emitter.obj", "mtllib emitter.mtl\nusemtl floor\nv -5 0 -5\nv 5 0 -5\nv 5 0 5\nv -5 0 5\n"
                                  "f 4 3 2 1\nusemtl emitter\nv -1 1.5 -0.5\nv 1 1.5 -0.5\nv 1 1.5 0.5\n"
                                  "v -1 1.5 0.5\nf 5 6 7 8\n");
    const struct rnd_aim aim = files_aim(0, -1, 0);
    struct rnd_scene *scene = files_load(path, NULL, NULL, (float[]){0, 0.01f, 0});
    const double middle = 4.0 * corner_form_factor(1 / 1.5, 0.5 / 1.5);
    assert_within("floor below an emitter's middle", files_radiance(scene, "fv", 0, 100000, &aim, 30, NULL),
                  0.6 * 5 * middle, 0.003);
    rnd_scene_destroy(scene);
    scene = files_load(path, NULL, NULL, (float[]){1, 0.01f, 0.5f});
    assert_within("floor below its corner", files_radiance(scene, "fv", 0, 100000, &aim, 30, NULL),
                  0.6 * 5 * corner_form_factor(2 / 1.5, 1 / 1.5), 0.003);
    rnd_scene_destroy(scene);
}

/* The same far from the origin, where floats are coarse: the emitter must not be hidden by itself. */
static void rectangle_far_away(void **state)
{
    (void)state;
    files_text("far.mtl", "newmtl floor\nKd 0.6 0.6 0.6\nnewmtl emitter\nKd 0 0 0\nKe 5 5 5\n");
    const char *path = files_text(
        "far.obj",
        "mtllib far.mtl\nusemtl floor\nv 95 64 -5\nv 105 64 -5\nv 105 64 5\nv 95 64 5\nf 4 3 2 1\n"
        "usemtl emitter\nv 99 65.5 -0.5\nv 101 65.5 -0.5\nv 101 65.5 0.5\nv 99 65.5 0.5\nf 5 6 7 8\n");
    const struct rnd_aim aim = files_aim(0, -1, 0);
    struct rnd_scene *scene = files_load(path, NULL, NULL, (float[]){100, 64.01f, 0});
    assert_within("floor below an emitter, 119 m from the origin",
                  files_radiance(scene, "fv", 0, 100000, &aim, 30, NULL),
                  0.6 * 5 * 4.0 * corner_form_factor(1 / 1.5, 0.5 / 1.5), 0.003);
    rnd_scene_destroy(scene);
}

/* A closed room with walls of 12.5 cm in a white world is dark inside, however far it is from the origin. */
static void dark_room_far_away(void **state)
{
    (void)state;
    static const double far[] = {0, 1000, 10000, 50000, 1000000};
    for (size_t i = 0; i < sizeof far / sizeof *far; i++) {
        const double x = far[i], z = 0.5 * far[i];
        char text[4000] = "mtllib wall.mtl\n";
        files_text("wall.mtl", "newmtl m\nKd 0.8 0.8 0.8\n");
        files_box(text, sizeof text, "m", (double[]){x - 2, 0, z - 2}, (double[]){x + 2, 3, z + 2});
        files_box(text, sizeof text, "m", (double[]){x - 2.125, -0.125, z - 2.125},
                  (double[]){x + 2.125, 3.125, z + 2.125});
        struct rnd_scene *scene = files_load(files_text("far.obj", text), files_env("white.hdr", 1.0f), NULL,
                                             (float[]){(float)x + 0.25f, 1.5f, (float)z + 0.25f});
        const struct rnd_aim aim = files_aim(0.3, 0.2, -1);
        const double inside = files_radiance(scene, "od", 0, 100000, &aim, 180, NULL);
        print_message("a dark room %g m away: %g\n", x, inside);
        assert_true(inside == 0.0);
        assert_float_equal(rnd_scene_info(scene)->bounds[0][0], x - 2.125, 0.04);
        assert_float_equal(rnd_scene_info(scene)->camera[2], z + 0.25, 0.04);
        rnd_scene_destroy(scene);
    }
}

/* A far node takes along the file's camera, lights and meshes. The picture is the same as near the origin. */
static void far_nodes(void **state)
{
    (void)state;
    static const char light[] =
        ",\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":1,\"znear\":0.1}}],"
        "\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[{\"type\":\"point\",\"intensity\":8}]}}";
    const struct rnd_aim down = files_aim(0, -1, 0);
    for (int i = 0; i < 2; i++) {
        char nodes[600];
        snprintf(nodes, sizeof nodes,
                 "{\"translation\":[%s],\"children\":[1,2,3]},{\"mesh\":0},"
                 "{\"translation\":[0.3,0.5,0.1],\"camera\":0},"
                 "{\"translation\":[0.3,2,0.1],\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}}",
                 i ? "50000.3,-20000.7,1000000.2" : "0,0,0");
        struct rnd_scene *scene =
            files_load(files_gltf("far.gltf", 1, nodes, FILES_GREY, light), NULL, NULL, NULL);
        assert_within("floor under an emitter of a far node",
                      files_radiance(scene, "fv", 1, 50000, &down, 10, NULL), 0.5 / M_PI * 8 / 4, 0.005);
        assert_float_equal(rnd_scene_info(scene)->camera[0], i ? 50000.6 : 0.3, 0.01);
        assert_float_equal(rnd_scene_info(scene)->bounds[1][2], i ? 1000001.2 : 1, 0.1);
        rnd_scene_destroy(scene);
    }
}

/* Punctual lights of glTF above a floor of albedo 0.5: intensity / distance^2 at normal incidence; a
 * directional light at 60 degrees from the normal; no light outside the cone of a spot. */
static void punctual(void **state)
{
    (void)state;
    /* A light shines along -Z of its node: when the node is turned by 30 degrees, it comes from 60 degrees
     * off the normal. */
    static const struct {
        const char *what, *light, *place;
        double irradiance;
    } cases[] = {
        {"point light, 2 m", "{\"type\":\"point\",\"intensity\":40,\"color\":[1,1,1]}",
         "\"translation\":[0,2,0]", 10},
        {"directional light, 60 degrees", "{\"type\":\"directional\",\"intensity\":6}",
         "\"rotation\":[-0.258819045,0,0,0.965925826]", 3},
        {"spot light, inside", "{\"type\":\"spot\",\"intensity\":40,\"spot\":{\"innerConeAngle\":0.2}}",
         "\"translation\":[0,2,0],\"rotation\":[-0.707106781,0,0,0.707106781]", 10},
        {"spot light, outside", "{\"type\":\"spot\",\"intensity\":40,\"spot\":{\"outerConeAngle\":0.2}}",
         "\"translation\":[0,2,0],\"rotation\":[-0.258819045,0,0,0.965925826]", 0},
        {"spot light of half a degree, in its middle",
         "{\"type\":\"spot\",\"intensity\":40,\"spot\":{\"innerConeAngle\":0.002,\"outerConeAngle\":0.004}}",
         "\"translation\":[0,2,0],\"rotation\":[-0.707106781,0,0,0.707106781]", 10},
    };
    const struct rnd_aim aim = files_aim(0, -1, 0);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char nodes[400], more[400];
        snprintf(
            nodes, sizeof nodes,
            "{\"mesh\":0,\"children\":[1]},{\"name\":\"light\",%s,\"extensions\":{\"KHR_lights_punctual\":{"
            "\"light\":0}}}",
            cases[i].place);
        snprintf(more, sizeof more,
                 ",\"extensionsUsed\":[\"KHR_lights_punctual\"],\"extensions\":{\"KHR_lights_punctual\":{"
                 "\"lights\":["
                 "%s]}}",
                 cases[i].light);
        const char *path = files_gltf("punctual.gltf", 50, nodes, FILES_GREY, more);
        struct rnd_scene *scene = files_load(path, NULL, NULL, (float[]){0, 0.005f, 0});
        assert_int_equal(rnd_scene_info(scene)->punctual_lights, 1);
        const double value = files_radiance(scene, "fv", 0, 20000, &aim, 30, NULL);
        if (cases[i].irradiance > 0)
            assert_within(cases[i].what, value, 0.5 / M_PI * cases[i].irradiance, 0.001);
        else
            assert_true(value == 0.0);
        rnd_scene_destroy(scene);
    }
}

/* An environment map with integer pixels is as bright as their sRGB values say. */
static void environments_of_integers(void **state)
{
    (void)state;
    const char *path =
        files_box_scene("speck", "newmtl m\nKd 0 0 0\n", (double[]){0, -50, 0}, (double[]){1, -49, 1});
    const struct rnd_aim up = files_aim(0, 1, 0);
    for (int bits = 8; bits <= 16; bits += 8) {
        const char *env = files_png("grey.png", bits, bits == 8 ? 128 : 128 * 257, 0);
        struct rnd_scene *scene = files_load(path, env, NULL, (float[]){0, 0, 0});
        assert_within("a grey sky of integers", files_radiance(scene, "fv", 0, 20000, &up, 30, NULL), 0.21586,
                      1e-4);
        rnd_scene_destroy(scene);
    }
}

/* Pixels that cannot be a radiance are clamped, and a warning names the first by its column and row. */
static void broken_environments(void **state)
{
    (void)state;
    enum { W = 16, H = 8 };
    static const struct {
        float value;
        const char *word;
        double sky; /* expected radiance of that pixel */
    } cases[] = {{-1, "x 4, y 1 is -1,", 0},
                 {NAN, "x 4, y 1 is ", 0},
                 {INFINITY, "x 4, y 1 is inf,", 65504},
                 {3e38f, "x 4, y 1 is 3e+38,", 65504}};
    static const struct rnd_channel rgb_channels[3] = {{"R", RND_FLOAT}, {"G", RND_FLOAT}, {"B", RND_FLOAT}};
    const char *path =
        files_box_scene("speck", "newmtl m\nKd 0 0 0\n", (double[]){0, -50, 0}, (double[]){1, -49, 1});
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        float rgb[W * H * 3];
        for (int k = 0; k < W * H * 3; k++) rgb[k] = 1.0f;
        for (int k = 0; k < 12 * 3; k++) rgb[3 * ((1 + k / 12) * W + 4) + k % 12] = cases[i].value;
        files_pixels(files_path("broken.exr"), "exr", W, H, 3, rgb_channels, rgb);
        struct rnd_scene *scene = files_load(path, files_path("broken.exr"), NULL, (float[]){0, 0, 0});
        print_message("%s", rnd_scene_info(scene)->warnings);
        assert_non_null(strstr(rnd_scene_info(scene)->warnings, "broken.exr: the pixel at "));
        assert_non_null(strstr(rnd_scene_info(scene)->warnings, cases[i].word));
        assert_non_null(strstr(rnd_scene_info(scene)->warnings, ": 12"));
        const double azimuth = (6.0 / W - 0.5) * 2 * M_PI, elevation = (0.5 - 2.5 / H) * M_PI;
        const struct rnd_aim there = files_aim(cos(elevation) * sin(azimuth), sin(elevation),
                                               -cos(elevation) * cos(azimuth)),
                             down = files_aim(0, -1, 0.3);
        const double sky = files_radiance(scene, "fv", 0, 100000, &there, 8, NULL);
        assert_float_equal(sky, cases[i].sky, 1e-3 * cases[i].sky);
        assert_within("the rest of a clamped sky", files_radiance(scene, "fv", 0, 20000, &down, 10, NULL),
                      1.0, 1e-4);
        rnd_scene_destroy(scene);
    }
}

/* An environment that is bright only ahead. Turned to the right, it is seen there, and lights a floor as much
 * as before. */
static void turned_environment(void **state)
{
    (void)state;
    enum { W = 64, H = 32 };
    float rgb[W * H * 3], seen[2], lit[2];
    char error[RND_ERROR_SIZE];
    for (int i = 0; i < W * H; i++)
        for (int c = 0; c < 3; c++) rgb[3 * i + c] = i % W >= W / 2 - 4 && i % W < W / 2 + 4 ? 5.0f : 0.1f;
    const char *env = files_path("ahead.exr");
    if (!files_image(env, W, H, rgb, true, error)) fail_msg("%s", error);
    const char *path = files_gltf("floor.gltf", 100, "{\"mesh\":0}",
                                  "{\"pbrMetallicRoughness\":{\"metallicFactor\":0},\"extensions\":{"
                                  "\"KHR_materials_specular\":{\"specularFactor\":0}}}",
                                  "");
    for (int k = 0; k < 2; k++) {
        const struct rnd_scene_options options = {.image_program = files_image_program(),
                                                  .path = path,
                                                  .env_path = env,
                                                  .env_azimuth = k ? 90.0f : 0.0f,
                                                  .has_camera = true,
                                                  .camera = {0, 1, 0}};
        struct rnd_scene *scene = rnd_scene_load(&options, error);
        if (!scene) fail_msg("%s", error);
        const struct rnd_aim there = k ? files_aim(1, 0.3, 0) : files_aim(0, 0.3, -1),
                             down = files_aim(0, -1, 0);
        seen[k] = (float)files_radiance(scene, "fv", 0, 20000, &there, 5, NULL);
        lit[k] = (float)files_radiance(scene, "fv", 0, 400000, &down, 20, NULL);
        rnd_scene_destroy(scene);
    }
    assert_within("seen ahead", seen[0], 5.0, 1e-3);
    assert_within("seen to the right", seen[1], 5.0, 1e-3);
    assert_within("light on the floor", lit[1], lit[0], 0.01);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(closed_furnace),
        cmocka_unit_test(convex_in_white),
        cmocka_unit_test(unlit_without_light),
        cmocka_unit_test(sun_on_plane),
        cmocka_unit_test(sun_seen),
        cmocka_unit_test(rectangle_of_light),
        cmocka_unit_test(rectangle_far_away),
        cmocka_unit_test(dark_room_far_away),
        cmocka_unit_test(far_nodes),
        cmocka_unit_test(punctual),
        cmocka_unit_test(environments_of_integers),
        cmocka_unit_test(broken_environments),
        cmocka_unit_test(turned_environment),
    };
    return cmocka_run_group_tests_name("renderer_furnace", tests, files_setup, files_teardown);
}
