/* Glass, panes and metals, whose radiance is known in closed form. */
#include "renderer_parts.h"

/* In a world of constant radiance lossless glass is invisible: what it does not reflect it refracts. */
static void invisible_glass(void **state)
{
    (void)state;
    static const char glass[] = "newmtl m\nKd 1 1 1\nNi 1.5\nillum 7\n";
    const char *env = files_env("grey.exr", 0.75f);
    const char *path = files_box_scene("slab", glass, (double[]){-3, -3, -4.1}, (double[]){3, 3, -4});
    struct rnd_scene *scene = files_load(path, env, NULL, (float[]){0, 0, 0});
    const struct rnd_aim ahead = files_aim(0, 0, -1), askew = files_aim(0.6, 0, -1);
    assert_within("glass slab", files_radiance(scene, "fv", 0, 200000, &ahead, 10, NULL), 0.75, 0.003);
    assert_within("glass slab, askew", files_radiance(scene, "fv", 0, 200000, &askew, 5, NULL), 0.75, 0.003);
    rnd_scene_destroy(scene);

    /* a sphere of flat facets: some light is trapped at its corners for long */
    enum { AROUND = 64, DOWN = 32 };
    static char text[400000];
    size_t n = (size_t)sprintf(text, "mtllib slab.mtl\nusemtl m\n");
    for (int i = 0; i <= DOWN; i++)
        for (int k = 0; k < AROUND; k++)
            n += (size_t)sprintf(text + n, "v %.9g %.9g %.9g\n",
                                 sin(M_PI * i / DOWN) * sin(2 * M_PI * k / AROUND), cos(M_PI * i / DOWN),
                                 -3 + sin(M_PI * i / DOWN) * cos(2 * M_PI * k / AROUND));
    for (int i = 0; i < DOWN; i++)
        for (int k = 0; k < AROUND; k++) {
            const int a = i * AROUND + k + 1, b = i * AROUND + (k + 1) % AROUND + 1;
            if (i > 0) n += (size_t)sprintf(text + n, "f %d %d %d\n", a, b + AROUND, b);
            if (i < DOWN - 1) n += (size_t)sprintf(text + n, "f %d %d %d\n", a, a + AROUND, b + AROUND);
        }
    scene = files_load(files_text("sphere.obj", text), env, NULL, (float[]){0, 0, 0});
    assert_within("glass sphere", files_radiance(scene, "fv", 0, 400000, &ahead, 16, NULL), 0.75, 0.005);
    rnd_scene_destroy(scene);
}

/* An emitter behind a slab of glass, in the dark. All its light passes except what the two faces reflect:
 * with all inner reflections (1 - R) / (1 + R), R = 0.04. */
static void emitter_behind_glass(void **state)
{
    (void)state;
    char text[2000] = "mtllib behind.mtl\n";
    files_text("behind.mtl", "newmtl m\nKd 1 1 1\nNi 1.5\nillum 7\nnewmtl emitter\nKd 0 0 0\nKe 2 2 2\n");
    files_box(text, sizeof text, "m", (double[]){-30, -30, -4.1}, (double[]){30, 30, -4});
    files_box(text, sizeof text, "emitter", (double[]){-30, -30, -6}, (double[]){30, 30, -5});
    struct rnd_scene *scene = files_load(files_text("behind.obj", text), NULL, NULL, (float[]){0, 0, 0});
    const struct rnd_aim ahead = files_aim(0, 0, -1);
    assert_within("emitter behind glass", files_radiance(scene, "fv", 0, 200000, &ahead, 6, NULL),
                  2 * 0.96 / 1.04, 0.003);
    rnd_scene_destroy(scene);
}

/* Radiance of a metal plane in a white world, seen along its normal. */
static double metal(double roughness, const char *base, double cone_deg, float rgb[3])
{
    char material[300];
    snprintf(
        material, sizeof material,
        "{\"pbrMetallicRoughness\":{\"baseColorFactor\":[%s,1],\"metallicFactor\":1,\"roughnessFactor\":%g}}",
        base, roughness);
    const char *path = files_gltf("metal.gltf", 100, "{\"mesh\":0}", material, "");
    struct rnd_scene *scene = files_load(path, files_env("one.exr", 1.0f), NULL, (float[]){0, 1, 0});
    const struct rnd_aim aim = files_aim(0, -1, 0);
    const double value = files_radiance(scene, "fv", 0, 1000000, &aim, cone_deg, rgb);
    rnd_scene_destroy(scene);
    return value;
}

/* A mirror shows its base colour. A white metal returns all light, however rough it is. */
static void metals(void **state)
{
    (void)state;
    float rgb[3];
    metal(0.0, "0.9,0.6,0.3", 10, rgb);
    assert_within("mirror, red", rgb[0], 0.9, 0.002);
    assert_within("mirror, green", rgb[1], 0.6, 0.002);
    assert_within("mirror, blue", rgb[2], 0.3, 0.002);
    static const double roughness[] = {0.1, 0.3, 0.6, 1.0};
    for (int i = 0; i < 4; i++) {
        char what[64];
        snprintf(what, sizeof what, "white metal of roughness %g", roughness[i]);
        assert_within(what, metal(roughness[i], "1,1,1", 3, NULL), 1.0, 0.005);
    }
}

/* A diffuse floor of albedo 0.5 with panes above it (and below) of glass with index 1.5 and this colour. */
static struct rnd_scene *under_panes(const char *nodes, const char *colour, const char *env, const float *sun)
{
    static const struct files_part part[] = {FILES_SQUARE};
    char materials[600];
    snprintf(materials, sizeof materials,
             FILES_GREY ","
                        "{\"pbrMetallicRoughness\":{\"baseColorFactor\":[%s,1],\"metallicFactor\":0,"
                        "\"roughnessFactor\":0},\"extensions\":{\"KHR_materials_transmission\":"
                        "{\"transmissionFactor\":1}}}",
             colour);
    return files_load(files_parts("pane.gltf", files_two_squares, nodes, materials, "", part, 3), env, sun,
                      (float[]){0, 0.5f, 0});
}

static const char pane_nodes[] =
    "{\"mesh\":0,\"scale\":[600,1,300],\"children\":[1]},{\"mesh\":1,\"translation\":[0,1,0]}";

/* The sun shines through a clear pane on a floor. The pane is first a mesh of the world, then an instance
 * that is stretched along two axes. 1 - R passes, where R is Fresnel's reflectance at 60 degrees. Of the
 * light that the floor returns, the pane reflects the mean of R over the hemisphere, 0.0918 for index 1.5
 * (Walsh 1926). */
static void pane(void **state)
{
    (void)state;
    static const char *const nodes[] = {
        pane_nodes,
        "{\"mesh\":0,\"scale\":[600,1,300],\"children\":[1,2]},{\"mesh\":1,\"translation\":[0,1,0]},"
        "{\"mesh\":1,\"translation\":[0,-1,0]}"};
    const double ci = 0.5, ct = sqrt(1.0 - (1.0 - ci * ci) / 2.25), rs = (ci - 1.5 * ct) / (ci + 1.5 * ct),
                 rp = (1.5 * ci - ct) / (1.5 * ci + ct), reflected = 0.5 * (rs * rs + rp * rp);
    const struct rnd_aim down = files_aim(0, -1, 0), up = files_aim(0, 1, 0);
    for (int i = 0; i < 2; i++) {
        struct rnd_scene *scene = under_panes(nodes[i], "1,1,1", NULL, (float[]){20, 30, 3, 0.53f});
        assert_within(i ? "sun through instanced panes" : "sun through a pane",
                      files_radiance(scene, "fv", 0, 200000, &down, 30, NULL),
                      0.5 / M_PI * 3 * ci * (1 - reflected) / (1 - 0.5 * 0.0918), 0.003);
        rnd_scene_destroy(scene);

        scene = under_panes(nodes[i], "1,1,1", files_env("lit.exr", 0.75f), NULL);
        const double floor = 0.5 * 0.75 * (1 - 0.0918) / (1 - 0.5 * 0.0918);
        assert_within("sky through it, and the floor in it",
                      files_radiance(scene, "fv", 0, 200000, &up, 10, NULL), 0.96 * 0.75 + 0.04 * floor,
                      0.003);
        rnd_scene_destroy(scene);
    }
}

/* A tinted pane takes its share of each colour, both of the sky that is seen through it and of the light on
 * the floor. */
static void tinted_pane(void **state)
{
    (void)state;
    static const double tint[3] = {0.5, 0.8, 0.9};
    const struct rnd_aim down = files_aim(0, -1, 0), up = files_aim(0, 1, 0);
    struct rnd_scene *scene = under_panes(pane_nodes, "0.5,0.8,0.9", files_env("lit.exr", 0.75f), NULL);
    float sky[3], floor[3];
    files_radiance(scene, "fv", 0, 1000000, &up, 10, sky);
    files_radiance(scene, "fv", 0, 1000000, &down, 10, floor);
    rnd_scene_destroy(scene);
    for (int c = 0; c < 3; c++) {
        const double below = 0.5 * 0.75 * tint[c] * (1 - 0.0918) / (1 - 0.5 * 0.0918);
        assert_within("floor under a tinted pane", floor[c], below, 0.01);
        assert_within("sky through it, and the floor in it", sky[c], 0.96 * tint[c] * 0.75 + 0.04 * below,
                      0.01);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(invisible_glass),      cmocka_unit_test(metals),
        cmocka_unit_test(emitter_behind_glass), cmocka_unit_test(pane),
        cmocka_unit_test(tinted_pane),
    };
    return cmocka_run_group_tests_name("renderer_glass", tests, files_setup, files_teardown);
}
