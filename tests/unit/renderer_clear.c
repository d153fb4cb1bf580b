/* The option clear_glass: light reaches a surface straight through glass. Where glass does not turn light,
 * the picture is the same as without the option; elsewhere the bias is printed and limited. */
#include "renderer_parts.h"

static struct rnd_scene *load(const char *path, const char *env, const float *sun, const float *camera,
                              bool clear)
{
    struct rnd_scene_options options = {.image_program = files_image_program(),
                                        .path = path,
                                        .env_path = env,
                                        .has_sun = sun,
                                        .has_camera = true,
                                        .clear_glass = clear};
    char error[RND_ERROR_SIZE];
    if (sun) memcpy(options.sun, sun, sizeof options.sun);
    for (int c = 0; c < 3; c++) options.camera[c] = (double)camera[c];
    struct rnd_scene *scene = rnd_scene_load(&options, error);
    if (!scene) fail_msg("%s", error);
    return scene;
}

/* Write a floor of albedo 1/2 under a slab of MTL glass, 0.2 m thick; the camera is between them. */
static const char *slab(const char *glass)
{
    char text[2000] = "mtllib slab.mtl\nusemtl floor\nv -900 0 -900\nv 900 0 -900\nv 900 0 900\n"
                      "v -900 0 900\nf 4 3 2 1\n",
         materials[400];
    snprintf(materials, sizeof materials, "newmtl floor\nKd .5 .5 .5\nnewmtl glass\nKd 1 1 1\nillum 7\n%s",
             glass);
    files_text("slab.mtl", materials);
    files_box(text, sizeof text, "glass", (double[]){-900, 1, -900}, (double[]){900, 1.2, 900});
    return files_text("slab.obj", text);
}

/* Glass of index 1 neither bends nor reflects light. It only tints sky and sun, both on the floor and for a
 * camera that looks up. */
static void index_of_one(void **state)
{
    (void)state;
    static const float sun[4] = {20, 50, 3, 4}, camera[3] = {0, 0.5f, 0};
    static const double tint[3] = {0.5, 0.7, 0.9};
    const struct rnd_aim down = files_aim(0, -1, 0), up = files_aim(0, 1, 0);
    const double irradiance = 0.75 * M_PI + 3 * sin(50 * M_PI / 180);
    const char *path = slab("Ni 1\nTf .5 .7 .9\n"), *env = files_env("sky.exr", 0.75f);
    for (int clear = 0; clear < 2; clear++) {
        struct rnd_scene *scene = load(path, env, sun, camera, clear);
        float floor[3], sky[3];
        files_radiance(scene, "fv", 0, 400000, &down, 30, floor);
        files_radiance(scene, "fv", 0, 200000, &up, 10, sky);
        rnd_scene_destroy(scene);
        for (int c = 0; c < 3; c++) {
            assert_within(clear ? "floor, clear" : "floor, by chance", floor[c],
                          0.5 / M_PI * irradiance * tint[c], clear ? 0.01 : 0.05);
            assert_within(clear ? "sky, clear" : "sky, by chance", sky[c], 0.75 * tint[c], 0.01);
        }
    }
}

/* Radiance of the floor below the camera: out[0] without clear glass, out[1] with it. */
static void both(const char *path, const char *env, const float *sun, const float *camera, uint32_t paths,
                 double out[2])
{
    const struct rnd_aim down = files_aim(0, -1, 0);
    for (int clear = 0; clear < 2; clear++) {
        struct rnd_scene *scene = load(path, env, sun, camera, clear);
        out[clear] = files_radiance(scene, "fv", 0, paths, &down, 30, NULL);
        rnd_scene_destroy(scene);
    }
}

/* Through a slab of index 1.5 the option is exact: a slab shifts rays and does not turn them. */
static void slab_of_glass(void **state)
{
    (void)state;
    static const float suns[2][4] = {{20, 50, 3, 40}, {20, 25, 3, 40}}, camera[3] = {0, 0.5f, 0};
    double light[2];
    const char *path = slab("Ni 1.5\n");
    both(path, files_env("sky.exr", 0.75f), NULL, camera, 400000, light);
    assert_within("sky through a slab", light[1], light[0], 0.005);
    for (int k = 0; k < 2; k++) {
        both(path, NULL, suns[k], camera, 600000, light);
        assert_within(k ? "low sun through a slab" : "sun through a slab", light[1], light[0], 0.03);
    }
}

/* Write glass of this roughness above a floor: two squares, or one that is thin. */
static const char *rough_glass(double roughness, bool thin)
{
    static const struct files_part part[] = {FILES_SQUARE};
    char materials[1000];
    snprintf(materials, sizeof materials,
             FILES_GREY ","
                        "{\"pbrMetallicRoughness\":{\"metallicFactor\":0,\"roughnessFactor\":%g},"
                        "\"extensions\":{\"KHR_materials_transmission\":{\"transmissionFactor\":1}%s}}",
             roughness, thin ? "" : ",\"KHR_materials_volume\":{\"thicknessFactor\":0.2}");
    return files_parts("rough.gltf", files_two_squares,
                       thin ? "{\"mesh\":0,\"scale\":[900,1,900],\"children\":[1]},{\"mesh\":1,"
                              "\"translation\":[0,1,0]}"
                            : "{\"mesh\":0,\"scale\":[900,1,900],\"children\":[1,2]},{\"mesh\":1,"
                              "\"translation\":[0,1.2,0]},{\"mesh\":1,\"translation\":[0,1,0],"
                              "\"rotation\":[1,0,0,0]}",
                       materials, "", part, 3);
}

/* Up to a limit of roughness, rough glass counts as clear, which changes the picture little. Rougher glass
 * does not. */
static void rough_slab(void **state)
{
    (void)state;
    static const struct {
        double roughness, sun, sky; /* sun, sky: the largest relative error under each */
    } cases[] = {{0.05, 0.02, 0.02}, {0.25, 0.05, 0.1}, {0.4, 0, 0}};
    static const float sun[4] = {20, 50, 3, 40}, camera[3] = {0, 0.5f, 0};
    const char *env = files_env("sky.exr", 0.75f);
    for (int thin = 0; thin < 2; thin++)
        for (int k = 0; k < 3; k++) {
            const char *path = rough_glass(cases[k].roughness, thin);
            double light[2];
            for (int sky = 0; sky < 2; sky++) {
                const double most = sky ? cases[k].sky : cases[k].sun;
                char what[100];
                snprintf(what, sizeof what, "%s through %s glass of roughness %g", sky ? "sky" : "sun",
                         thin ? "thin" : "thick", cases[k].roughness);
                both(path, sky ? env : NULL, sky ? NULL : sun, camera, most > 0 ? 400000 : 20000, light);
                if (most > 0)
                    assert_within(what, light[1], light[0], most);
                else
                    assert_true(light[1] == light[0]);
            }
        }
}

/* Append a sphere to the text of an OBJ. */
static void sphere(char *text, size_t size, const char *material, double y, double radius)
{
    enum { AROUND = 32, DOWN = 16 };
    size_t n = strlen(text);
    n += (size_t)snprintf(text + n, size - n, "usemtl %s\n", material);
    for (int i = 0; i <= DOWN; i++)
        for (int k = 0; k < AROUND; k++)
            n += (size_t)snprintf(text + n, size - n, "v %.9g %.9g %.9g\n",
                                  radius * sin(M_PI * i / DOWN) * sin(2 * M_PI * k / AROUND),
                                  y + radius * cos(M_PI * i / DOWN),
                                  radius * sin(M_PI * i / DOWN) * cos(2 * M_PI * k / AROUND));
    for (int i = 0; i < DOWN; i++)
        for (int k = 0; k < AROUND; k++) {
            const int all = (DOWN + 1) * AROUND, a = i * AROUND + k - all,
                      b = i * AROUND + (k + 1) % AROUND - all;
            if (i > 0) n += (size_t)snprintf(text + n, size - n, "f %d %d %d\n", a, b + AROUND, b);
            if (i < DOWN - 1)
                n += (size_t)snprintf(text + n, size - n, "f %d %d %d\n", a, a + AROUND, b + AROUND);
        }
}

/* A glass bulb hangs in a room. Its emitter is small enough that straight light is nearly right, and large
 * enough for paths to find it. */
static void bulb(void **state)
{
    (void)state;
    static char text[200000];
    static const char *const glass[] = {"Ni 1.5\nTf 1 1 1\n", "Ni 1.5\nTf .6 .8 1\n"};
    const float camera[3] = {0.5f, 0.3f, 0.5f};
    for (int k = 0; k < 2; k++) {
        char materials[400];
        double light[2];
        snprintf(materials, sizeof materials,
                 "newmtl wall\nKd .5 .5 .5\nnewmtl glow\nKd 0 0 0\nKe 50 50 50\nnewmtl glass\nillum 7\n%s",
                 glass[k]);
        files_text("bulb.mtl", materials);
        strcpy(text, "mtllib bulb.mtl\n");
        files_box(text, sizeof text, "wall", (double[]){-2, 0, -2}, (double[]){2, 2.5, 2});
        sphere(text, sizeof text, "glow", 2, 0.08);
        sphere(text, sizeof text, "glass", 2, 0.16);
        both(files_text("bulb.obj", text), NULL, NULL, camera, 400000, light);
        assert_within(k ? "room lit by a tinted bulb" : "room lit by a bulb", light[1], light[0], 0.015);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(index_of_one), cmocka_unit_test(slab_of_glass),
                                       cmocka_unit_test(rough_slab), cmocka_unit_test(bulb)};
    return cmocka_run_group_tests_name("renderer_clear", tests, files_setup, files_teardown);
}
