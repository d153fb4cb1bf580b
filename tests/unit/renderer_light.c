/* Lights without a render: draws follow the stated density, which integrates to one; a spherical emitter
 * agrees with its closed form; and points draw the lights that reach them. */
#include "path/survey.h"
#include "renderer_files.h"
#include "light/area.h"
#include "light/env.h"
#include "light/light.h"
#include "scene/scene.h"
#include "statistics.h"

static const char floor_obj[] =
    "mtllib f.mtl\nusemtl floor\nv -9 0 -9\nv 9 0 -9\nv 9 0 9\nv -9 0 9\nf 4 3 2 1\n";

enum { ROWS = 24, COLUMNS = 48, CELLS = ROWS * COLUMNS, DRAWS = 400000 };

static int cell_of(struct rnd_v3 d)
{
    float u, v;
    rnd_v3_to_uv(d, &u, &v);
    const int x = (int)(u * COLUMNS), y = (int)(v * ROWS);
    return (y < ROWS ? y : ROWS - 1) * COLUMNS + (x < COLUMNS ? x : COLUMNS - 1);
}

/* Draws follow the density, whatever the choice of regions, and the density integrates to one over the
 * sphere. */
static void check_environment(const struct rnd_env *env, const struct rnd_env_choice *choice, double mean)
{
    enum { PARTS = 24 };
    static double mass[CELLS], count[CELLS];
    memset(mass, 0, sizeof mass);
    memset(count, 0, sizeof count);
    double sum = 0.0, all = 0.0, given = 0.0, others = 0.0;
    for (int cell = 0; cell < CELLS; cell++) {
        for (int k = 0; k < PARTS * PARTS; k++) {
            const double u = (cell % COLUMNS + (k % PARTS + 0.5) / PARTS) / COLUMNS,
                         v = (cell / COLUMNS + (k / PARTS + 0.5) / PARTS) / ROWS;
            float pdf;
            uint32_t region;
            const struct rnd_v3 d = rnd_v3_from_uv((float)u, (float)v),
                                radiance = rnd_env_radiance(env, d, &region, &pdf);
            const double area = sin(M_PI * v) * 2.0 * M_PI * M_PI / ((double)CELLS * PARTS * PARTS);
            mass[cell] += pdf * choice->factor[region] * area;
            all += radiance.x * area;
        }
        sum += mass[cell];
    }
    print_message("density integrates to %.5f, radiance to %.2f of %.2f\n", sum, all, mean);
    assert_float_equal(sum, 1.0, 2e-3);
    assert_true(fabs(all / mean - 1.0) < 2e-2);
    for (uint32_t i = 0; i < DRAWS; i++) {
        const float u[4] = {stat_uniform(2, i), stat_uniform(3, i), stat_uniform(4, i), stat_uniform(5, i)};
        uint32_t region, there;
        float part, s, t, pdf;
        const uint32_t place = rnd_env_place(env, choice, u[1], u[0], &region, &part);
        const struct rnd_v3 d =
            rnd_env_direction(env, rnd_env_texel_of(env, region, place, part), u[2], u[3], &s, &t);
        const struct rnd_v3 radiance = rnd_env_radiance(env, d, &there, &pdf);
        others += there != region;
        count[cell_of(d)]++;
        given += radiance.x / (pdf * choice->factor[there]) / DRAWS;
    }
    for (int i = 0; i < CELLS; i++) mass[i] *= DRAWS / sum;
    const double p = stat_chi_square_p(count, mass, CELLS);
    print_message("p %.3f; radiance over density %.3f of the integral\n", p, given / all);
    assert_true(p > 0.001);
    assert_true(others < 1e-4 * DRAWS); /* at the borders of regions, directions are rounded */
    assert_true(fabs(given / all - 1.0) < 0.01);
}

/* An environment with values of three orders of magnitude, turned by nine texels: the stated density
 * integrates to one over the sphere, draws follow it, and the mean of radiance over density is that of the
 * map. */
static void environment(void **state)
{
    (void)state;
    enum { W = 96, H = 48 };
    static float rgb[W * H * 3];
    char error[RND_ERROR_SIZE];
    double mean = 0.0;
    for (int i = 0; i < W * H; i++) {
        const float value = powf(10.0f, 3.0f * stat_uniform(1, (uint32_t)i) - 2.0f) +
                            (i % W == 17 && i / W == 9 ? 500.0f : 0);
        for (int c = 0; c < 3; c++) rgb[3 * i + c] = value;
        mean += value * sin(M_PI * (i / W + 0.5) / H);
    }
    files_text("f.mtl", "newmtl floor\nKd 0.5 0.5 0.5\n");
    assert_true(files_image(files_path("env.hdr"), W, H, rgb, true, error));
    const struct rnd_scene_options options = {.image_program = files_image_program(),
                                              .path = files_text("f.obj", floor_obj),
                                              .env_path = files_path("env.hdr"),
                                              .env_azimuth = 33.75f};
    struct rnd_scene *scene = rnd_scene_load(&options, error);
    if (!scene) fail_msg("%s", error);
    const struct rnd_env *env = scene->lights.env;
    assert_true(scene->lights.has[RND_LIGHT_ENV]);

    mean *= 4.0 * M_PI * M_PI / (2.0 * W * H);
    check_environment(env, &env->by_weight, mean);

    float probability[RND_ENV_REGIONS];
    struct rnd_env_choice some;
    for (uint32_t i = 0; i < RND_ENV_REGIONS; i++)
        probability[i] = env->weight[i] * (0.05f + 2.0f * stat_uniform(10, i));
    assert_true(rnd_env_choose(env, probability, &some));
    check_environment(env, &some, mean);
    rnd_scene_destroy(scene);
}

/* A triangle seen from a point: draws fall within its solid angle as the density says, and the mean of one
 * over the density is the solid angle (Van Oosterom and Strackee 1983). */
static void triangle(void **state)
{
    (void)state;
    files_text("t.mtl", "newmtl emitter\nKd 0 0 0\nKe 3 3 3\n");
    struct rnd_scene *scene = files_load(
        files_text("t.obj", "mtllib t.mtl\nusemtl emitter\nv 1 2 -1\nv -1 1.5 -2\nv 0.5 3 -0.5\nf 1 2 3\n"),
        NULL, NULL, NULL);
    const double a[3] = {1, 2, -1}, b[3] = {-1, 1.5, -2}, c[3] = {0.5, 3, -0.5};
    double la = 0, lb = 0, lc = 0, ab = 0, bc = 0, ca = 0;
    for (int k = 0; k < 3; k++)
        la += a[k] * a[k], lb += b[k] * b[k], lc += c[k] * c[k], ab += a[k] * b[k], bc += b[k] * c[k],
            ca += c[k] * a[k];
    la = sqrt(la), lb = sqrt(lb), lc = sqrt(lc);
    const double volume = a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) +
                          a[2] * (b[0] * c[1] - b[1] * c[0]);
    const double expected = 2.0 * atan2(fabs(volume), la * lb * lc + ab * lc + bc * la + ca * lb);
    double angle = 0.0;
    struct rnd_light_choice choice = {0};
    rnd_light_choose_evenly(&scene->lights, &choice);
    for (uint32_t i = 0; i < DRAWS; i++) {
        const float u[4] = {stat_uniform(6, i), stat_uniform(7, i), stat_uniform(8, i), stat_uniform(9, i)};
        struct rnd_light_sample light;
        assert_true(rnd_light_draw(scene, &choice, RND_LIGHT_AREA, rnd_v3(0, 0, 0), u, &light));
        assert_float_equal(
            rnd_area_pdf(&scene->lights.area[0], 1.0f, light.direction, light.distance) / light.pdf, 1, 1e-5);
        angle += 1.0 / light.pdf / DRAWS;
    }
    print_message("solid angle %.5f of %.5f sr\n", angle, expected);
    assert_true(fabs(angle / expected - 1.0) < 0.005);
    rnd_scene_destroy(scene);
}

/* A spherical emitter of radius r whose middle is at height h gives a floor an irradiance of pi L (r / h)^2
 * (Lambert 1760). */
static void sphere_of_light(void **state)
{
    (void)state;
    enum { AROUND = 96, DOWN = 48 };
    static char text[400000];
    files_text("s.mtl", "newmtl floor\nKd 0.6 0.6 0.6\nnewmtl emitter\nKd 0 0 0\nKe 5 5 5\n");
    size_t n = (size_t)sprintf(
        text,
        "mtllib s.mtl\nusemtl floor\nv -9 0 -9\nv 9 0 -9\nv 9 0 9\nv -9 0 9\nf 4 3 2 1\nusemtl emitter\n");
    /* The radius at which the faceted sphere has the volume of a ball of radius 0.5. */
    const double ring = 2 * M_PI / AROUND,
                 r = 0.5 * pow(ring / sin(ring) * (M_PI / DOWN) / sin(M_PI / DOWN), 1.0 / 3);
    for (int i = 0; i <= DOWN; i++)
        for (int k = 0; k < AROUND; k++)
            n += (size_t)sprintf(text + n, "v %.9g %.9g %.9g\n", r * sin(M_PI * i / DOWN) * sin(k * ring),
                                 2 + r * cos(M_PI * i / DOWN), r * sin(M_PI * i / DOWN) * cos(k * ring));
    for (int i = 0; i < DOWN; i++)
        for (int k = 0; k < AROUND; k++) {
            const int a = 4 + i * AROUND + k + 1, b = 4 + i * AROUND + (k + 1) % AROUND + 1;
            if (i > 0) n += (size_t)sprintf(text + n, "f %d %d %d\n", a, b + AROUND, b);
            if (i < DOWN - 1) n += (size_t)sprintf(text + n, "f %d %d %d\n", a, a + AROUND, b + AROUND);
        }
    struct rnd_scene *scene = files_load(files_text("s.obj", text), NULL, NULL, (float[]){0, 0.01f, 0});
    const struct rnd_aim aim = files_aim(0, -1, 0);
    const double expected = 0.6 * 5 * 0.25 * 0.25,
                 value = files_radiance(scene, "fv", 0, 400000, &aim, 30, NULL);
    print_message("floor below a sphere of light: %.5f of %.5f\n", value, expected);
    assert_true(fabs(value / expected - 1.0) < files_off(0.01));
    rnd_scene_destroy(scene);
}

/* An emitter in a closed box, under the sun: points in the box mostly draw the emitter, points outside mostly
 * the sun, but each point sometimes draws the other. */
static void survey(void **state)
{
    (void)state;
    static const float sun[4] = {20, 60, 5, 0.53f}, in[3] = {0, 1, 0}, out[3] = {3, 1, 0};
    struct rnd_light_choice choice[2][3] = {0};
    files_text("b.mtl", "newmtl wall\nKd 0.5 0.5 0.5\nnewmtl emitter\nKd 0 0 0\nKe 3 3 3\n");
    struct rnd_scene *scene = files_load(
        files_text("b.obj", "mtllib b.mtl\nusemtl wall\nv -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\n"
                            "v -1 2 -1\nv 1 2 -1\nv 1 2 1\nv -1 2 1\nf 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\n"
                            "f 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\nv -9 -0.1 -9\nv 9 -0.1 -9\nv 9 -0.1 9\n"
                            "v -9 -0.1 9\nf 12 11 10 9\nusemtl emitter\nv -0.3 1.9 -0.3\nv 0.3 1.9 -0.3\n"
                            "v 0 1.9 0.3\nf 13 14 15\n"),
        NULL, sun, NULL);
    for (int threads = 1; threads <= 3; threads++) {
        struct rnd_pool *pool = rnd_pool_create(threads);
        assert_non_null(pool);
        rnd_survey_lights(scene, &(struct rnd_camera){.position = {in[0], in[1], in[2]}}, pool,
                          &choice[0][threads - 1]);
        rnd_survey_lights(scene, &(struct rnd_camera){.position = {out[0], out[1], out[2]}}, pool,
                          &choice[1][threads - 1]);
        rnd_pool_destroy(pool);
    }
    for (int place = 0; place < 2; place++) {
        const float *c = choice[place][0].group;
        const int near = place == 0 ? RND_LIGHT_AREA : RND_LIGHT_SUN,
                  far = place == 0 ? RND_LIGHT_SUN : RND_LIGHT_AREA;
        print_message("%s: emitter %.3f, sun %.3f\n", place == 0 ? "inside" : "outside", c[RND_LIGHT_AREA],
                      c[RND_LIGHT_SUN]);
        assert_float_equal(c[near] + c[far], 1, 1e-6);
        assert_true(c[near] >= 0.89f && c[far] >= 0.09f);
        for (int t = 1; t < 3; t++)
            assert_memory_equal(c, choice[place][t].group, sizeof choice[place][t].group);
    }
    rnd_scene_destroy(scene);
}

/* A closed box with a window towards +X, under an even sky: points in the box draw the sky in that direction.
 */
static void window(void **state)
{
    (void)state;
    struct rnd_light_choice choice[3] = {0};
    files_text("w.mtl", "newmtl wall\nKd 0.5 0.5 0.5\n");
    struct rnd_scene *scene = files_load(
        files_text("w.obj", "mtllib w.mtl\nusemtl wall\nv -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\n"
                            "v -1 2 -1\nv 1 2 -1\nv 1 2 1\nv -1 2 1\nf 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\n"
                            "f 3 4 8 7\nf 4 1 5 8\nv 1 1 -1\nv 1 1 1\nf 2 3 10 9\n"),
        files_env("even.exr", 1.0f), NULL, (float[]){0, 1, 0});
    for (int threads = 1; threads <= 3; threads++) {
        struct rnd_pool *pool = rnd_pool_create(threads);
        assert_non_null(pool);
        rnd_survey_lights(scene, &(struct rnd_camera){.position = {0, 1, 0}}, pool, &choice[threads - 1]);
        rnd_pool_destroy(pool);
        assert_memory_equal(&choice[0].env, &choice[threads - 1].env, sizeof choice[0].env);
    }
    uint32_t out, back;
    float pdf;
    rnd_env_radiance(scene->lights.env, rnd_v3(1, 0.1f, 0), &out, &pdf);
    rnd_env_radiance(scene->lights.env, rnd_v3(-1, 0.1f, 0), &back, &pdf);
    const float *factor = choice[0].env.factor;
    print_message("through the window %.3f, through the wall %.3f times as often as by weight\n", factor[out],
                  factor[back]);
    assert_true(factor[out] > 2 && factor[back] < 0.11f && factor[back] > 0.09f);
    rnd_scene_destroy(scene);
}

/* Mean radiance below this camera, and the probability that its points draw the first emitter. */
static double below(const char *path, const float camera[3], int group, float *out_probability)
{
    struct rnd_light_choice choice[2] = {0};
    struct rnd_scene *scene = files_load(path, NULL, NULL, camera);
    for (int threads = 1; threads <= 2; threads++) {
        struct rnd_pool *pool = rnd_pool_create(threads);
        assert_non_null(pool);
        rnd_survey_lights(scene, &(struct rnd_camera){.position = {camera[0], camera[1], camera[2]}}, pool,
                          &choice[threads - 1]);
        rnd_pool_destroy(pool);
    }
    const struct rnd_alias *alias = choice[0].emitters[group];
    double sum = 0.0;
    for (uint32_t i = 0; i < alias->count; i++) {
        sum += alias->probability[i];
        assert_true(alias->probability[i] == choice[1].emitters[group]->probability[i]);
    }
    assert_true(fabs(sum - 1.0) < 1e-4);
    *out_probability = alias->probability[0];
    const struct rnd_aim aim = files_aim(0, -1, 0);
    const double radiance = files_radiance(scene, "fv", 0, 400000, &aim, 30, NULL);
    for (int i = 0; i < 2; i++) rnd_light_choice_finish(&choice[i]);
    rnd_scene_destroy(scene);
    return radiance;
}

/* A room with an emitter, alone and in a house of twelve such rooms. In the house its emitter is drawn nearly
 * as often, and the picture is the same. */
static void house(void **state)
{
    (void)state;
    static const char *const name[] = {"room.obj", "house.obj"};
    static char text[8000];
    const float camera[3] = {0, 0, 0};
    double radiance[2];
    float probability[2];
    files_text("house.mtl", "newmtl wall\nKd 0.5 0.5 0.5\nnewmtl emitter\nKd 0.2 0.2 0.2\nKe 3 3 3\n");
    for (int k = 0; k < 2; k++) {
        size_t n = (size_t)sprintf(text, "mtllib house.mtl\nusemtl emitter\n");
        for (int x = 0; x < (k ? 12 : 1); x++)
            n += (size_t)sprintf(text + n, "v %g 0.9 -0.3\nv %g 0.9 -0.3\nv %g 0.9 0.3\nf -3 -2 -1\n",
                                 3 * x - 0.3, 3 * x + 0.3, 3.0 * x);
        for (int x = 0; x < (k ? 12 : 1); x++)
            files_box(text, sizeof text, "wall", (double[]){3 * x - 1, -1, -1}, (double[]){3 * x + 1, 1, 1});
        radiance[k] = below(files_text(name[k], text), camera, RND_LIGHT_AREA, &probability[k]);
    }
    print_message("its emitter %.3f of all in the house; floor %.5f alone, %.5f there\n", probability[1],
                  radiance[0], radiance[1]);
    assert_true(probability[0] == 1.0f);
    assert_float_equal(probability[1], 0.8 + 0.2 / 12, 1e-3);
    assert_true(fabs(radiance[1] / radiance[0] - 1.0) < files_off(0.005));
}

/* The same with point lights: one above a floor, and nine more below the floor. */
static void cellar(void **state)
{
    (void)state;
    const float camera[3] = {0, 0.5f, 0};
    double radiance[2];
    float probability[2];
    for (int k = 0; k < 2; k++) {
        char nodes[2000], lights[200] = ",\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[{\"type\":"
                                        "\"point\",\"intensity\":20}]}}";
        const char *light = "\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}";
        size_t n = (size_t)sprintf(nodes, "{\"mesh\":0,\"children\":[1%s]}", k ? ",2,3,4,5,6,7,8,9,10" : "");
        for (int i = 0; i < (k ? 10 : 1); i++)
            n += (size_t)sprintf(nodes + n, ",{\"translation\":[%d,%d,0],%s}", i, i ? -1 : 2, light);
        const char *path = files_gltf(k ? "cellar.gltf" : "floor.gltf", 100, nodes,
                                      "{\"pbrMetallicRoughness\":{\"metallicFactor\":0},\"extensions\":{"
                                      "\"KHR_materials_specular\":{\"specularFactor\":0}}}",
                                      lights);
        radiance[k] = below(path, camera, RND_LIGHT_PUNCTUAL, &probability[k]);
    }
    print_message("its light %.3f of all; floor %.5f alone, %.5f over the cellar\n", probability[1],
                  radiance[0], radiance[1]);
    assert_true(probability[0] == 1.0f && probability[1] > 0.79f);
    assert_true(fabs(radiance[1] / radiance[0] - 1.0) < files_off(0.005));
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(environment),     cmocka_unit_test(triangle),
                                       cmocka_unit_test(sphere_of_light), cmocka_unit_test(survey),
                                       cmocka_unit_test(window),          cmocka_unit_test(house),
                                       cmocka_unit_test(cellar)};
    return cmocka_run_group_tests_name("renderer_light", tests, files_setup, files_teardown);
}
