/* Media that touch, overlap and lie inside each other: no light is gained or lost at their borders, and
 * things behind them are seen where Snell, Fresnel and Beer predict. */
#include "renderer_parts.h"

#include "path/media.h"

#define GLASS "\"KHR_materials_ior\":{\"ior\":1.5},"
#define WATER "\"KHR_materials_ior\":{\"ior\":1.333},"
#define VOLUME                                                                                               \
    "\"KHR_materials_transmission\":{\"transmissionFactor\":1},\"KHR_materials_volume\":{"                   \
    "\"thicknessFactor\":1"
#define CLEAR VOLUME "}"

static const char bright[] = "\"KHR_materials_emissive_strength\":{\"emissiveStrength\":3},"
                             "\"KHR_materials_specular\":{\"specularFactor\":0}";

struct box {
    const char *extensions; /* of its material */
    double roughness;
    double low[3], high[3];
};

enum { MOST_BOXES = 6 };

/* A scene of boxes, each with its own material. */
static struct rnd_scene *boxes(const struct box *box, int count, const char *env, const float camera[3])
{
    static const float corner[24] = {-1, -1, -1, 1, -1, -1, -1, 1, -1, 1, 1, -1,
                                     -1, -1, 1,  1, -1, 1,  -1, 1, 1,  1, 1, 1};
    static const uint16_t index[36] = {0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 4, 6, 0, 6, 2,
                                       1, 3, 7, 1, 7, 5, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3};
    const struct files_part part[] = {
        {corner, sizeof corner,
         "\"componentType\":5126,\"count\":8,\"type\":\"VEC3\",\"min\":[-1,-1,-1],\"max\":[1,1,1]"},
        {index, sizeof index, "\"componentType\":5123,\"count\":36,\"type\":\"SCALAR\""}};
    char nodes[2000] = "{\"children\":[", primitives[2000] = "", materials[4000] = "";
    for (int i = 0; i < count; i++)
        snprintf(nodes + strlen(nodes), sizeof nodes - strlen(nodes), "%s%d", i ? "," : "", i + 1);
    strcat(nodes, "]}");
    for (int i = 0; i < count; i++) {
        const struct box *b = &box[i];
        snprintf(nodes + strlen(nodes), sizeof nodes - strlen(nodes),
                 ",{\"mesh\":%d,\"translation\":[%.9g,%.9g,%.9g],\"scale\":[%.9g,%.9g,%.9g]}", i,
                 (b->low[0] + b->high[0]) / 2, (b->low[1] + b->high[1]) / 2, (b->low[2] + b->high[2]) / 2,
                 (b->high[0] - b->low[0]) / 2, (b->high[1] - b->low[1]) / 2, (b->high[2] - b->low[2]) / 2);
        snprintf(primitives + strlen(primitives), sizeof primitives - strlen(primitives),
                 "%s{\"attributes\":{\"POSITION\":0},\"indices\":1,\"material\":%d}",
                 i ? "]},{\"primitives\":[" : "", i);
        const bool emits = strstr(b->extensions, "strength");
        snprintf(materials + strlen(materials), sizeof materials - strlen(materials),
                 "%s{\"pbrMetallicRoughness\":{\"metallicFactor\":0,\"roughnessFactor\":%g%s},"
                 "\"doubleSided\":true,"
                 "\"extensions\":{%s}%s}",
                 i ? "," : "", b->roughness, emits ? ",\"baseColorFactor\":[0,0,0,1]" : "", b->extensions,
                 emits ? ",\"emissiveFactor\":[1,1,1]" : "");
    }
    struct rnd_scene_options options = {
        .image_program = files_image_program(),
        .path = files_parts("boxes.gltf", primitives, nodes, materials, "", part, 2),
        .env_path = env,
        .has_camera = true,
        .camera = {(double)camera[0], (double)camera[1], (double)camera[2]}};
    char error[RND_ERROR_SIZE];
    struct rnd_scene *scene = rnd_scene_load(&options, error);
    if (!scene) fail_msg("%s", error);
    return scene;
}

static const struct {
    const char *name;
    int count;
    struct box box[MOST_BOXES];
    float camera[3][3]; /* one outside, the others inside media */
} WORLDS[] = {
    {"water beside glass, touching",
     2,
     {{GLASS CLEAR, 0, {-1, -1, -3}, {0, 1, -2}}, {WATER CLEAR, 0, {0, -1, -3}, {1, 1, -2}}},
     {{0, 0, 0}, {-0.5f, 0.1f, -2.5f}, {0.5f, 0.1f, -2.5f}}},
    {"water in a glass, touching",
     6,
     {{GLASS CLEAR, 0, {-1.1, -1, -3.1}, {-1, 1, -0.9}},
      {GLASS CLEAR, 0, {1, -1, -3.1}, {1.1, 1, -0.9}},
      {GLASS CLEAR, 0, {-1, -1, -3.1}, {1, 1, -3}},
      {GLASS CLEAR, 0, {-1, -1, -1}, {1, 1, -0.9}},
      {GLASS CLEAR, 0, {-1.1, -1.1, -3.1}, {1.1, -1, -0.9}},
      {WATER CLEAR, 0, {-1, -1, -3}, {1, 0.8, -1}}},
     {{0, 0.5f, 1}, {0.2f, 0.1f, -2}, {1.05f, 0.1f, -1.7f}}},
    {"water that overlaps its glass",
     3,
     {{GLASS CLEAR, 0, {-1.1, -1, -3.1}, {-1, 1, -0.9}},
      {GLASS CLEAR, 0, {-1.1, -1.1, -3.1}, {1.1, -1, -0.9}},
      {WATER CLEAR, 0, {-1.05, -1.05, -3}, {1, 0.8, -1}}},
     {{0, 0.5f, 1}, {0.2f, 0.1f, -2}, {-1.02f, 0.1f, -1.7f}}},
    {"ice in water, a bubble in the ice",
     3,
     {{WATER CLEAR, 0, {-1, -1, -3}, {1, 1, -1}},
      {"\"KHR_materials_ior\":{\"ior\":1.31}," CLEAR, 0, {-.6, -.6, -2.6}, {.6, 1.3, -1.4}},
      {"\"KHR_materials_ior\":{\"ior\":1.0003}," CLEAR, 0, {-.2, -.2, -2.2}, {.2, .2, -1.8}}},
     {{0, 0.2f, 0.5f}, {0.01f, 0.02f, -2}, {-0.8f, 0.1f, -1.7f}}},
    {"one body in two parts",
     2,
     {{GLASS CLEAR, 0, {-1, -1, -3}, {0, 1, -2}}, {GLASS CLEAR, 0, {0, -1, -3}, {1, 1, -2}}},
     {{0, 0, 0}, {-0.5f, 0.1f, -2.5f}, {0.3f, 0.1f, -1}}},
    {"a pile that touches, far away",
     3,
     {{GLASS CLEAR, 0, {99, -1, -3}, {102, 0, 0}},
      {WATER CLEAR, 0, {99, 0, -3}, {102, 1, 0}},
      {"\"KHR_materials_ior\":{\"ior\":2.4}," CLEAR, 0, {99, 1, -3}, {102, 2, 0}}},
     {{97, 0.5f, -1}, {100, 0.5f, -1}, {100, -0.5f, -1}}},
};

/* In a world of constant radiance clear media are invisible, whatever the order of their surfaces, both from
 * outside and to a camera inside one of them. */
static void furnaces(void **state)
{
    (void)state;
    static const double roughness[] = {0, 0.15, 0.5};
    char env[512];
    strcpy(env, files_env("white.exr", 1.0f));
    int wrong = 0;
    for (size_t k = 0; k < sizeof WORLDS / sizeof *WORLDS; k++)
        for (int r = 0; r < 3; r++)
            for (int e = 0; e < 3; e++) {
                struct box box[MOST_BOXES];
                memcpy(box, WORLDS[k].box, sizeof box);
                for (int i = 0; i < WORLDS[k].count; i++) box[i].roughness = roughness[r];
                struct rnd_scene *scene = boxes(box, WORLDS[k].count, env, WORLDS[k].camera[e]);
                /* In a smooth box, light that meets every face at a flat angle is trapped for ever. So a
                 * camera inside one looks only at the 20 degrees ahead. */
                const struct rnd_aim aim = files_aim(0, 0, -1);
                const double mean =
                    files_radiance(scene, r || !e ? "od" : "fv", 0, 70000, &aim, r || !e ? 180 : 20, NULL);
                print_message("%-36s roughness %.2f, camera %d: %.4f\n", WORLDS[k].name, roughness[r], e,
                              mean);
                wrong += !(fabs(mean - 1) < files_off(0.01));
                rnd_scene_destroy(scene);
            }
    assert_int_equal(wrong, 0);
}

/* Unpolarised Fresnel reflectance at the border between two indices (Born and Wolf, section 1.5). */
static double fresnel(double cosine, double from, double to)
{
    const double sine = from / to * sqrt(1 - cosine * cosine), t = sqrt(1 - sine * sine);
    const double s = (from * cosine - to * t) / (from * cosine + to * t),
                 p = (to * cosine - from * t) / (to * cosine + from * t);
    return (s * s + p * p) / 2;
}

/* A camera in glass looks down into water at an angle of 50 degrees, at something bright in the water. The
 * water touches the glass or reaches into it. If there were air between them, the camera would see nothing,
 * because glass reflects everything from 41.8 degrees on. What the border reflects is reflected down again by
 * the top of the glass, so that in the end everything is bright. The bright box is in the water, so its
 * radiance is divided by the square of the index of water. */
static void bright_in_water(void **state)
{
    (void)state;
    static const float camera[3] = {0, 0.5f, 0};
    const double angle = 50 * M_PI / 180;
    const struct rnd_aim aim = files_aim(sin(angle), -cos(angle), 0.02);
    for (int k = 0; k < 3; k++) {
        const double overlap[] = {0, 0.01, 1e-5};
        const struct box box[] = {{GLASS CLEAR, 0, {-50, 0, -50}, {50, 1, 50}},
                                  {WATER CLEAR, 0, {-50, -3, -50}, {50, overlap[k], 50}},
                                  {bright, 1, {-40, -2, -40}, {40, -1, 40}}};
        struct rnd_scene *scene = boxes(box, 3, NULL, camera);
        char what[100];
        snprintf(what, sizeof what, "bright in water, %g m into the glass", overlap[k]);
        assert_within(what, files_radiance(scene, "fv", 0, 200000, &aim, 3, NULL), 3 / (1.333 * 1.333),
                      0.005);
        rnd_scene_destroy(scene);
    }
}

/* A medium absorbs light on the way to everything in it, also to drawn lights. A border inside one medium has
 * no effect. */
static void absorbing(void **state)
{
    (void)state;
    static const char tinted[] = WATER VOLUME ",\"attenuationDistance\":2,\"attenuationColor\":[0.25,0.5,1]}",
                      floor[] = "\"KHR_materials_specular\":{\"specularFactor\":0}";
    static const float outside[3] = {0, 2, 0}, in_it[3] = {0, -0.5f, 0};
    const struct rnd_aim down = files_aim(0, -1, 0);
    const double index = 1.333 * 1.333, through = 1 - fresnel(1, 1, 1.333);
    const struct box box[] = {{tinted, 0, {-50, -3, -50}, {50, 0, 50}},
                              {bright, 1, {-40, -2.5, -40}, {40, -2, 40}},
                              {tinted, 0, {-30, -1.5, -30}, {30, -1, 30}}};
    for (int inner = 0; inner < 2; inner++) {
        float rgb[3];
        struct rnd_scene *scene = boxes(box, 2 + inner, NULL, outside);
        files_radiance(scene, "fv", 0, 100000, &down, 4, rgb);
        assert_within("bright under water, red", rgb[0], 3 / index * through * 0.25, 0.01);
        assert_within("bright under water, green", rgb[1], 3 / index * through * 0.5, 0.01);
        assert_within("bright under water, blue", rgb[2], 3 / index * through, 0.01);
        rnd_scene_destroy(scene);
        scene = boxes(box, 2 + inner, NULL, in_it);
        files_radiance(scene, "fv", 0, 100000, &down, 4, rgb);
        assert_within("bright seen from in the water, red", rgb[0], 3 / index * pow(0.25, 0.75), 0.01);
        assert_within("bright seen from in the water, green", rgb[1], 3 / index * pow(0.5, 0.75), 0.01);
        rnd_scene_destroy(scene);
    }
    /* A white floor is 1 m below a much wider emitter, both in water of index n, and the camera looks
     * straight down at it from 0.1 m. Its radiance is emission / n^2 times 2 E3(s) exp(-0.1 s), with the
     * exponential integral E3 (DLMF 8.19) and the absorption s over 1 m. */
    const struct box room[] = {{tinted, 0, {-900, -3, -900}, {900, 0, 900}},
                               {bright, 1, {-800, -1, -800}, {800, -0.5, 800}},
                               {floor, 1, {-800, -2.5, -800}, {800, -2, 800}}};
    static const float over_floor[3] = {0, -1.9f, 0};
    struct rnd_scene *scene = boxes(room, 3, NULL, over_floor);
    double series[2] = {0};
    float rgb[3];
    for (int c = 0; c < 2; c++) {
        const double s = -log(c ? 0.5 : 0.25) / 2;
        for (int i = 0; i < 100000; i++) { /* E3(s) is the integral of mu e^(-s / mu) over mu from 0 to 1 */
            const double mu = (i + 0.5) / 100000;
            series[c] += mu * exp(-s / mu) / 100000;
        }
        series[c] *= 2 * 3 / index * exp(-s * 0.1);
    }
    files_radiance(scene, "fv", 1, 400000, &down, 6, rgb);
    assert_within("floor lit in the water, red", rgb[0], series[0], 0.02);
    assert_within("floor lit in the water, green", rgb[1], series[1], 0.02);
    rnd_scene_destroy(scene);
}

/* The list of media: the innermost comes first, and a medium can be left wherever it stands in the list. */
static void lists(void **state)
{
    (void)state;
    rnd_media media = rnd_media_enter(rnd_media_enter(rnd_media_enter(0, 7), 65535), 9);
    assert_int_equal(rnd_media_innermost(media), 9);
    assert_true(rnd_media_leave(media, 65535) == rnd_media_enter(rnd_media_enter(0, 7), 9));
    assert_true(rnd_media_leave(media, 7) == rnd_media_enter(rnd_media_enter(0, 65535), 9));
    /* A medium that was not entered is left: that removes the innermost. */
    assert_true(rnd_media_leave(media, 8) == rnd_media_enter(rnd_media_enter(0, 7), 65535));
    assert_true(rnd_media_leave(0, 8) == 0);
    media = rnd_media_enter(media, 9); /* entered twice */
    assert_true(rnd_media_innermost(rnd_media_leave(media, 9)) == 9);
    media = rnd_media_enter(media, 3); /* the fifth medium: the outermost is forgotten */
    for (int i = 0; i < 4; i++) media = rnd_media_leave(media, rnd_media_innermost(media));
    assert_true(media == 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(lists), cmocka_unit_test(furnaces),
                                       cmocka_unit_test(bright_in_water), cmocka_unit_test(absorbing)};
    return cmocka_run_group_tests(tests, files_setup, files_teardown);
}
