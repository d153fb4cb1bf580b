/* Uneven emissive surfaces: with holes, with a coverage of one half, or bright only in places. All ways of
 * finding their light give the same result, and a small bright spot is found as soon as a large area. */
#include "renderer_parts.h"

#include "light/light.h"
#include "light/area.h"
#include "statistics.h"

enum { DRAWS = 200000, RAYS = 1000000 };

static const char floor_material[] = FILES_GREY;

/* A mean and its standard error. */
struct mean {
    double sum, squares;
    uint32_t count;
};

static void mean_add(struct mean *m, double value)
{
    m->sum += value;
    m->squares += value * value;
    m->count++;
}

static double mean_of(const struct mean *m)
{
    return m->sum / m->count;
}

static double mean_error(const struct mean *m)
{
    const double mean = mean_of(m);
    return sqrt(fmax(m->squares / m->count - mean * mean, 0.0) / m->count);
}

/* --- images --- */

/* Write an image of size x size that is black except for a bright square of side x side texels. */
static void write_spot(const char *name, int size, int side)
{
    static float rgb[512 * 512 * 3];
    char error[RND_ERROR_SIZE];
    for (int y = 0; y < size; y++)
        for (int x = 0; x < size; x++)
            for (int c = 0; c < 3; c++) {
                const int left = size * 5 / 8, top = size / 5;
                const bool in = x >= left && x < left + side && y >= top && y < top + side;
                rgb[3 * (y * size + x) + c] = in ? 1.0f : 0.0f;
            }
    if (!files_image(files_path(name), size, size, rgb, false, error)) fail_msg("%s", error);
}

/* Write an image whose alpha falls from left to right, with holes in it. */
static void write_holes(const char *name)
{
    enum { SIDE = 12 };
    static const struct rnd_channel rgba[4] = {
        {"R", RND_BYTE}, {"G", RND_BYTE}, {"B", RND_BYTE}, {"A", RND_BYTE}};
    float data[SIDE * SIDE * 4];
    for (int i = 0; i < SIDE * SIDE; i++) {
        const int x = i % SIDE, y = i / SIDE;
        data[4 * i] = data[4 * i + 1] = data[4 * i + 2] = 1.0f;
        data[4 * i + 3] = x / 3 % 2 == y / 4 % 2 ? 1.0f - 0.8f * (float)x / SIDE : 0.0f;
    }
    files_pixels(files_path(name), "png", SIDE, SIDE, 4, rgba, data);
}

/* --- the same light found in three ways --- */

/* Radiance of the floor at the origin, from drawn lights and how much of them is visible. */
static struct mean by_lights(const struct rnd_scene *scene)
{
    struct mean mean = {0};
    struct rnd_light_choice choice = {0};
    rnd_light_choose_evenly(&scene->lights, &choice);
    for (uint32_t i = 0; i < DRAWS; i++) {
        const float u[4] = {stat_uniform(1, i), stat_uniform(2, i), stat_uniform(3, i), stat_uniform(4, i)};
        struct rnd_light_sample light;
        double value = 0.0;
        if (scene->lights.has[RND_LIGHT_AREA] &&
            rnd_light_draw(scene, &choice, RND_LIGHT_AREA, rnd_v3(0, 1e-4f, 0), u, &light) &&
            light.direction.y > 0.0f)
            value = 0.5 / M_PI * (double)(light.radiance.x * light.direction.y / light.pdf);
        mean_add(&mean, value);
    }
    return mean;
}

/* The same from directions that the floor draws, and what they hit. */
static struct mean by_directions(const struct rnd_scene *scene)
{
    struct mean mean = {0};
    for (uint32_t i = 0; i < RAYS; i++) {
        const float r = sqrtf(stat_uniform(5, i)), turn = 2.0f * (float)M_PI * stat_uniform(6, i);
        struct RTCRayHit hit = {.ray = {.org_y = 1e-4f,
                                        .dir_x = r * cosf(turn),
                                        .dir_y = sqrtf(1.0f - r * r),
                                        .dir_z = r * sinf(turn),
                                        .tfar = INFINITY,
                                        .mask = UINT32_MAX},
                                .hit = {.geomID = RTC_INVALID_GEOMETRY_ID}};
        rnd_embree_intersect1(scene->tree, &hit);
        double value = 0.0;
        if (hit.hit.geomID != RTC_INVALID_GEOMETRY_ID &&
            scene->mesh[hit.hit.geomID].first_light != UINT32_MAX) {
            const uint32_t i_area = scene->mesh[hit.hit.geomID].first_light + hit.hit.primID;
            value =
                0.5 * (double)rnd_area_emission(scene, &scene->lights.area[i_area], hit.hit.u, hit.hit.v).x;
        }
        mean_add(&mean, value);
    }
    return mean;
}

/* Check that lights, directions and a render give the same radiance, and that it is `expected` unless that is
 * negative. Returns the relative standard deviation of one drawn light. */
static double check(const char *what, const char *path, double expected)
{
    struct rnd_scene *scene = files_load(path, NULL, NULL, (float[]){0, 0.01f, 0});
    const struct mean lights = by_lights(scene), directions = by_directions(scene);
    const struct rnd_aim down = files_aim(0, -1, 0);
    const double both = files_radiance(scene, "fv", 0, 200000, &down, 20, NULL), one = mean_of(&lights),
                 other = mean_of(&directions), error = hypot(mean_error(&lights), mean_error(&directions)),
                 deviation = mean_error(&lights) * sqrt(DRAWS) / fmax(one, 1e-30);
    print_message("%-42s lights %.5f, directions %.5f, both %.5f; deviation of a light %.2f\n", what, one,
                  other, both, deviation);
    rnd_scene_destroy(scene);
    assert_true(fabs(one - other) <= 4.0 * error + 1e-6);
    assert_true(fabs(one - both) <= 4.0 * mean_error(&lights) + files_off(0.005) * one);
    if (expected >= 0.0) assert_true(fabs(one - expected) <= 4.0 * mean_error(&lights) + 1e-6);
    return deviation;
}

/* Write an emitter of 2 x 2 m, 1.5 m above the floor, with this glTF material. */
static const char *emitter(const char *material, const char *attributes, const char *more)
{
    static const float colours[16] = {1, 1, 1, 0, 1, 1, 1, 0.5f, 1, 1, 1, 1, 1, 1, 1, 0.25f};
    static const struct files_part part[] = {
        FILES_SQUARE, {colours, sizeof colours, "\"componentType\":5126,\"count\":4,\"type\":\"VEC4\""}};
    char meshes[800], materials[2000];
    snprintf(meshes, sizeof meshes,
             "{\"attributes\":{\"POSITION\":0},\"indices\":2,\"material\":0}]},{\"primitives\":["
             "{\"attributes\":{\"POSITION\":0,\"TEXCOORD_0\":1%s},\"indices\":2,\"material\":1}",
             attributes);
    snprintf(materials, sizeof materials,
             "%s,{\"emissiveFactor\":[1,1,1],\"doubleSided\":true,\"extensions\":{"
             "\"KHR_materials_emissive_strength\":{\"emissiveStrength\":10},\"KHR_materials_specular\":{"
             "\"specularFactor\":0}},%s}",
             floor_material, material);
    return files_parts(
        "emitter.gltf", meshes,
        "{\"mesh\":0,\"scale\":[50,1,50],\"children\":[1]},{\"mesh\":1,\"scale\":[0.02,1,0.02],"
        "\"translation\":[0,1.5,0]}",
        materials, more, part, 4);
}

#define BLACK(alpha) "\"pbrMetallicRoughness\":{\"baseColorFactor\":[0,0,0," alpha "],\"metallicFactor\":0}"
#define HOLES                                                                                                \
    "\"pbrMetallicRoughness\":{\"baseColorFactor\":[0,0,0,1],\"metallicFactor\":0,"                          \
    "\"baseColorTexture\":{\"index\":0}}"

/* JSON of both images as textures with this sampler. */
static const char *images(const char *wrap)
{
    static char text[400];
    snprintf(text, sizeof text,
             ",\"textures\":[{\"source\":0,\"sampler\":0},{\"source\":1,\"sampler\":0}],\"images\":["
             "{\"uri\":\"holes.png\"},{\"uri\":\"spot.png\"}],\"samplers\":[{%s}]",
             wrap);
    return text;
}

/* Radiance of the floor below the middle of the whole square (Howell's catalogue, B-3). */
static double whole(void)
{
    const double a = 1 / 1.5, p = sqrt(1 + a * a);
    return 0.5 * 10 * 4 * (2 * a / p * atan(a / p)) / (2 * M_PI);
}

static void coverage(void **state)
{
    (void)state;
    write_holes("holes.png");
    write_spot("spot.png", 32, 4);
    const char *repeat = images("\"wrapS\":10497");
    check("opaque", emitter(BLACK("0.1"), "", ""), whole());
    check("BLEND, half", emitter("\"alphaMode\":\"BLEND\"," BLACK("0.5"), "", ""), 0.5 * whole());
    check("MASK, below the cut-off", emitter("\"alphaMode\":\"MASK\"," BLACK("0.2"), "", ""), 0);
    check("MASK, at the cut-off", emitter("\"alphaMode\":\"MASK\"," BLACK("0.5"), "", ""), whole());
    check("BLEND, with holes", emitter("\"alphaMode\":\"BLEND\"," HOLES, "", repeat), -1);
    check("MASK, with holes", emitter("\"alphaMode\":\"MASK\",\"alphaCutoff\":0.6," HOLES, "", repeat), -1);
    check("BLEND by vertices", emitter("\"alphaMode\":\"BLEND\"," BLACK("0.9"), ",\"COLOR_0\":3", ""), -1);
    check("MASK by vertices", emitter("\"alphaMode\":\"MASK\"," BLACK("0.9"), ",\"COLOR_0\":3", ""), -1);
    check("MASK by vertices, with holes",
          emitter("\"alphaMode\":\"MASK\",\"alphaCutoff\":0.3," HOLES, ",\"COLOR_0\":3", repeat), -1);
}

/* The same in an OBJ: Ke with d and with map_d. */
static void dissolved(void **state)
{
    (void)state;
    static const char *const material[] = {"d 0.5\n", "map_d holes.png\n", "d 0.5\nmap_d holes.png\n"};
    write_holes("holes.png");
    for (int k = 0; k < 3; k++) {
        char text[300];
        snprintf(text, sizeof text, "newmtl floor\nKd .5 .5 .5\nnewmtl light\nKd 0 0 0\nKe 10 10 10\n%s",
                 material[k]);
        files_text("d.mtl", text);
        check(material[k],
              files_text("d.obj", "mtllib d.mtl\nusemtl floor\nv -50 0 -50\nv 50 0 -50\nv 50 0 50\n"
                                  "v -50 0 50\nf 4 3 2 1\nusemtl light\nv -1 1.5 -1\nv 1 1.5 -1\nv 1 1.5 1\n"
                                  "v -1 1.5 1\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 5/1 6/2 7/3 8/4\n"),
              k == 0 ? 0.5 * whole() : -1);
    }
}

/* Bright spots are found wherever wrapping and transforms put them, and also where another texture cuts
 * holes. */
static void textured(void **state)
{
    (void)state;
    static const char *const wraps[] = {"\"wrapS\":10497", "\"wrapS\":33648,\"wrapT\":33071"};
    static const char transformed[] =
        BLACK("1") ",\"emissiveTexture\":{\"index\":1,\"extensions\":{\"KHR_texture_transform\":{\"scale\":["
                   "3,-2.3],\"rotation\":0.4,\"offset\":[0.3,0.8]}}}";
    write_holes("holes.png");
    write_spot("spot.png", 32, 4);
    for (int k = 0; k < 2; k++) {
        const char *more = images(wraps[k]);
        assert_true(check(k ? "spot, mirrored and clamped" : "spots, repeated",
                          emitter(transformed, "", more), -1) < 2);
        /* expected value by quadrature of the bilinear texture over the square */
        assert_true(check("a spot", emitter(BLACK("1") ",\"emissiveTexture\":{\"index\":1}", "", more),
                          0.031948) < 2);
        check("a spot, with holes",
              emitter("\"alphaMode\":\"BLEND\",\"emissiveTexture\":{\"index\":1,\"extensions\":{"
                      "\"KHR_texture_transform\":{\"scale\":[2,2]}}}," HOLES,
                      "", more),
              -1);
    }
}

/* A single bright texel out of a quarter of a million is drawn like a separate light. */
static void tiny_spot(void **state)
{
    (void)state;
    write_holes("holes.png");
    write_spot("spot.png", 512, 1);
    struct rnd_scene *scene =
        files_load(emitter(BLACK("1") ",\"emissiveTexture\":{\"index\":1}", "", images("\"wrapS\":10497")),
                   NULL, NULL, (float[]){0, 0.01f, 0});
    const struct mean lights = by_lights(scene);
    /* Integrated, a bilinear texel has its own area. It is in the plane 1.5 m above, where the spot is. */
    const double side = 2.0 / 512, x = (320.5 / 512 - 0.5) * 2, z = (102.5 / 512 - 0.5) * 2,
                 square = x * x + z * z + 1.5 * 1.5,
                 expected = 0.5 / M_PI * 10 * side * side * 1.5 * 1.5 / (square * square),
                 deviation = mean_error(&lights) * sqrt(DRAWS) / mean_of(&lights);
    print_message("one texel: %.4e of %.4e, deviation of a light %.2f; %u parts\n", mean_of(&lights),
                  expected, deviation, scene->lights.area_count);
    rnd_scene_destroy(scene);
    assert_true(fabs(mean_of(&lights) / expected - 1.0) < 0.02);
    assert_true(deviation < 1.5); /* it would be 500 if texels were drawn evenly */
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(coverage), cmocka_unit_test(dissolved),
                                       cmocka_unit_test(textured), cmocka_unit_test(tiny_spot)};
    return cmocka_run_group_tests_name("renderer_emitter", tests, files_setup, files_teardown);
}
