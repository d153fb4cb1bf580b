/* A sun of any size is equally bright however it is found: seen by the camera, in a mirror, and by the
 * surfaces that it lights. */
#include "renderer_files.h"

#include "light/light.h"
#include "path/trace.h"
#include "render.h"

/* Pixels of this film are 0.011 degrees wide: large suns cover several of them, and the smallest covers part
 * of one. */
enum { WIDTH = 32768, HEIGHT = WIDTH / 2 };

static const float diameters[] = {0.53f, 0.1f, 0.04f, 0.005f};

/* How many paths per pixel a camera needs to find a sun of this size precisely enough for the test. */
static uint32_t enough(float diameter)
{
    return diameter > 0.2f ? 8 : (diameter > 0.02f ? 4096 : 32768) / (SANITIZED ? 16 : 1);
}

static struct rnd_light_choice choice_of(const struct rnd_scene *scene)
{
    struct rnd_light_choice choice = {0};
    rnd_light_choose_evenly(&scene->lights, &choice);
    return choice;
}

/* The radiance that arrives at the camera from within `half` degrees around a direction, integrated over the
 * solid angle, with this many paths per pixel. */
static double arriving(const struct rnd_scene *scene, double azimuth_deg, double elevation_deg, double half,
                       uint32_t paths)
{
    static struct rnd_wave_io io;
    const struct rnd_light_choice choice = choice_of(scene);
    struct rnd_tracer *tracer = rnd_tracer_create(scene, &choice, 0, 0.0f, WIDTH, 11);
    assert_non_null(tracer);
    const double x = (0.5 + azimuth_deg / 360.0) * WIDTH, y = (0.5 - elevation_deg / 180.0) * HEIGHT,
                 down = half / 180.0 * HEIGHT + 1.0, across = down / cos(elevation_deg * M_PI / 180.0);
    double sum = 0.0;
    struct rnd_camera camera;
    for (int k = 0; k < 3; k++) camera.position[k] = (float)(scene->info.camera[k] - scene->origin[k]);
    uint32_t count = 0;
    for (uint32_t row = (uint32_t)(y - down); row <= (uint32_t)(y + down); row++) {
        const double top = cos(M_PI * row / HEIGHT), bottom = cos(M_PI * (row + 1) / HEIGHT),
                     angle = 2.0 * M_PI / WIDTH * (top - bottom);
        for (uint32_t column = (uint32_t)(x - across); column <= (uint32_t)(x + across); column++)
            for (uint32_t k = 0; k < paths; k++) {
                io.x[count] = column, io.y[count] = row, io.number[count] = k;
                const bool last =
                    row == (uint32_t)(y + down) && column == (uint32_t)(x + across) && k == paths - 1;
                if (++count < RND_WAVE && !last && !(k == paths - 1 && column == (uint32_t)(x + across)))
                    continue;
                rnd_trace(tracer, &camera, 0, &io, count);
                for (uint32_t i = 0; i < count; i++) sum += (double)io.radiance[0][i] * angle / paths;
                count = 0;
            }
    }
    rnd_tracer_destroy(tracer);
    return sum;
}

static void assert_within(const char *what, float diameter, double value, double expected, double relative)
{
    print_message("sun of %5g degrees, %-16s %.5f of %.5f: %+.3f %%\n", (double)diameter, what, value,
                  expected, 100.0 * (value / expected - 1.0));
    assert_true(fabs(value / expected - 1.0) < files_off(relative));
}

/* The camera's integral over the sun's disc is its irradiance, in every direction. */
static void seen(void **state)
{
    (void)state;
    static const float place[][2] = {{30, 45}, {-120, 20}, {170, -10}};
    const char *path = files_text("speck.obj", "v 0 -50 0\nv 0 -49 0\nv 1 -50 0\nf 1 2 3\n");
    for (size_t i = 0; i < sizeof diameters / sizeof *diameters; i++)
        for (size_t k = 0; k < 3; k++) {
            const float sun[4] = {place[k][0], place[k][1], 3, diameters[i]};
            struct rnd_scene *scene = files_load(path, NULL, sun, (float[]){0, 0, 0});
            assert_within("by the camera", sun[3],
                          arriving(scene, sun[0], sun[1], 0.6 * sun[3], enough(sun[3])), 3, 0.01);
            rnd_scene_destroy(scene);
        }
}

/* The same in a mirror, where both directions of the lobe and directions to the sun find it. */
static void mirrored(void **state)
{
    (void)state;
    files_text("mirror.mtl", "newmtl m\nKd 0 0 0\nKs 1 1 1\nillum 3\n");
    const char *path = files_text("mirror.obj", "mtllib mirror.mtl\nusemtl m\nv -9 0 -9\nv 9 0 -9\n"
                                                "v 9 0 9\nv -9 0 9\nf 4 3 2 1\n");
    for (size_t i = 0; i < sizeof diameters / sizeof *diameters; i++) {
        const float sun[4] = {30, 45, 3, diameters[i]};
        struct rnd_scene *scene = files_load(path, NULL, sun, (float[]){0, 1, 0});
        assert_within("in a mirror", sun[3], arriving(scene, sun[0], -sun[1], 0.6 * sun[3] + 1.2, 8), 3,
                      0.015);
        rnd_scene_destroy(scene);
    }
}

/* The same through a slab of glass, where only chance finds the sun. All of its light arrives except what the
 * two faces reflect: with all inner reflections (1 - R) / (1 + R). */
static void refracted(void **state)
{
    (void)state;
    char text[1000] = "mtllib slab.mtl\n";
    const double r = 0.0502399; /* Fresnel's reflectance at 45 degrees, index 1.5 */
    files_text("slab.mtl", "newmtl m\nKd 1 1 1\nNi 1.5\nillum 7\n");
    files_box(text, sizeof text, "m", (double[]){-9, 1, -9}, (double[]){9, 1.1, 9});
    const char *path = files_text("slab.obj", text);
    for (size_t i = 0; i < sizeof diameters / sizeof *diameters; i++) {
        const float sun[4] = {30, 45, 3, diameters[i]};
        struct rnd_scene *scene = files_load(path, NULL, sun, (float[]){0, 0, 0});
        assert_within("through glass", sun[3], arriving(scene, sun[0], sun[1], 0.6 * sun[3], enough(sun[3])),
                      3 * (1 - r) / (1 + r), 0.015);
        rnd_scene_destroy(scene);
    }
}

/* The same from the light on a floor. */
static void lights(void **state)
{
    (void)state;
    files_text("floor.mtl", "newmtl m\nKd 0.8 0.8 0.8\n");
    const char *path = files_text("floor.obj", "mtllib floor.mtl\nusemtl m\nv -90 0 -90\nv 90 0 -90\n"
                                               "v 90 0 90\nv -90 0 90\nf 4 3 2 1\n");
    const struct rnd_aim down = files_aim(0, -1, 0);
    for (size_t i = 0; i < sizeof diameters / sizeof *diameters; i++) {
        const float sun[4] = {30, 45, 3, diameters[i]};
        struct rnd_scene *scene = files_load(path, NULL, sun, (float[]){0, 1, 0});
        assert_within("on a floor", sun[3], files_radiance(scene, "fv", 0, 40000, &down, 40, NULL),
                      0.8 / M_PI * 3 * sqrt(0.5), 0.001);
        rnd_scene_destroy(scene);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(seen), cmocka_unit_test(mirrored),
                                       cmocka_unit_test(refracted), cmocka_unit_test(lights)};
    return cmocka_run_group_tests_name("renderer_sun", tests, files_setup, files_teardown);
}
