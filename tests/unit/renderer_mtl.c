/* MTL materials and maps, as the scene holds them. */
#include "renderer_materials.h"

#include <sys/stat.h>

static struct rnd_scene *with_mtl(const char *mtl)
{
    files_text("m.mtl", mtl);
    return files_load(files_text("m.obj",
                                 "mtllib m.mtl\nusemtl m\nv -1 0 -1\nv -1 0 1\nv 1 0 1\nvt 0 1\nvt 0 0\n"
                                 "vt 1 0\nf 1/1 2/2 3/3\n"),
                      files_env("env.exr", 1), NULL, NULL);
}

/* The files that a scene lists: libraries and maps that are found as written, found in another letter case,
 * or missing. */
static void files(void **state)
{
    (void)state;
    write_halves("Halves.PNG", 0, 1);
    files_text(
        "m.mtl",
        "newmtl m\nKd 1 1 1\nmap_Kd halves.png\nKs 0.5 0.5 0.5\nNs 98\nillum 2\nmap_Ks maps\\gone.png\n");
    struct rnd_scene *scene =
        files_load(files_text("m.obj", "mtllib lost.mtl\nmtllib m.mtl\nusemtl m\nv -1 0 -1\nv -1 0 1\n"
                                       "v 1 0 1\nvt 0 1\nvt 0 0\nvt 1 0\nf 1/1 2/2 3/3\n"),
                   files_env("env.exr", 1), NULL, NULL);
    const struct rnd_scene_info *info = rnd_scene_info(scene);
    assert_true(files_named(info, files_path("m.mtl")) && files_named(info, files_path("Halves.PNG")));
    assert_true(files_named(info, files_path("lost.mtl")));
    assert_true(files_named(info, files_path("maps/gone.png")));
    assert_false(files_named(info, files_path("env.exr")));
    rnd_scene_destroy(scene);
    remove(files_path("m.mtl"));
}

static void mtl(void **state)
{
    (void)state;
    write_halves("halves.png", 0, 1);
    struct rnd_scene *scene = with_mtl("newmtl m\nKd 0.3 0.4 0.5\nKe 1 2 3\nd 0.25\nillum 1\nKs 1 1 1\n");
    const struct rnd_material *m = only(scene);
    assert_int_equal(m->kind, RND_DIFFUSE);
    assert_int_equal(m->alpha_mode, RND_BLEND);
    NEAR(m->base.y, 0.4), NEAR(m->emission.z, 3), NEAR(m->alpha, 0.25), NEAR(m->specular, 0);
    rnd_scene_destroy(scene);

    scene = with_mtl(
        "newmtl m\nKd 0.3 0.4 0.5\nKs 0.2 0.1 0.05\nNs 98\nillum 2\nmap_Kd -clamp on halves.png\n"
        "map_Ks halves.png\nmap_d halves.png\nnorm halves.png\nmap_bump halves.png\nmap_Ns halves.png\n");
    m = only(scene);
    const float root = (m->ior - 1) / (m->ior + 1);
    assert_int_equal(m->kind, RND_RICH);
    assert_int_equal(m->alpha_mode, RND_BLEND);
    NEAR(root * root * m->specular_colour.x, 0.2), NEAR(root * root * m->specular_colour.z, 0.05);
    NEAR(m->roughness, sqrtf(sqrtf(0.02f)));
    assert_int_equal(m->map[RND_MAP_BASE].wrap[0], RND_CLAMP);
    assert_true(m->map[RND_MAP_SPECULAR_COLOUR].texture >= 0 && m->map[RND_MAP_COVERAGE].texture >= 0);
    assert_int_equal(scene->texture[m->map[RND_MAP_NORMAL].texture].use, RND_PIXELS_DATA);
    assert_int_equal(scene->texture[m->map[RND_MAP_BASE].texture].use, RND_PIXELS_COLOUR);
    assert_string_equal(rnd_scene_info(scene)->unsupported, "bump maps, maps of Phong's exponent");
    rnd_scene_destroy(scene);

    scene = with_mtl("newmtl m\nKd 1 1 1\nKs 0.5 0.5 0.5\nTf 0.25 1 0.81\nNi 1.4\nd 0.1\nillum 7\n");
    m = only(scene);
    assert_int_equal(m->alpha_mode, RND_OPAQUE);
    NEAR(m->transmission, 1), NEAR(m->ior, 1.4), NEAR(m->roughness, 0), NEAR(m->base.x, 0.5),
        NEAR(m->base.z, 0.9);
    assert_false(m->thin || m->pane);
    rnd_scene_destroy(scene);

    scene = with_mtl("newmtl m\nKd 1 1 1\nNi 1.5\nillum 4\n"); /* illum 4 is "glass on", without refraction */
    assert_true(only(scene)->thin && only(scene)->pane);
    rnd_scene_destroy(scene);

    static const char *const bad[] = {"newmtl m\nKd -1 0 0\n", "newmtl m\nKe nan 0 0\n", "newmtl m\nd 2\n",
                                      "newmtl m\nNi 0.5\nillum 7\n"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        char error[RND_ERROR_SIZE] = "";
        files_text("m.mtl", bad[i]);
        const struct rnd_scene_options options = {.image_program = files_image_program(),
                                                  .path = files_path("m.obj"),
                                                  .env_path = files_path("env.exr")};
        assert_null(rnd_scene_load(&options, error));
        print_message("%s\n", error);
        assert_non_null(strstr(error, "m.obj: material \"m\""));
    }
}

/* Details that assimp loses: options of maps, a map without its factor, the PBR keys, a library in a folder
 * with its images beside it, and lines beside triangles. */
static void mtl_of_exporters(void **state)
{
    (void)state;
    char folder[600];
    snprintf(folder, sizeof folder, "%s/sub", files_directory);
    assert_int_equal(mkdir(folder, 0700), 0);
    write_halves("sub/halves.png", 1, 1);
    files_text(
        "sub/m.mtl",
        "newmtl m\r\nillum 1\nmap_Kd -t 0 0 0 -mm 0 1 -s 2 3 1 -o 0.25 0.5 0 halves.png\nPr 0.25\nPm 1\n"
        "norm -bm 0.5 halves.png\nmap_Pr halves.png\nnewmtl plain\nmap_Kd halves.png\n"
        "newmtl grey\nKd 0.6 0.6 0.6\nmap_Kd halves.png\n");
    struct rnd_scene *scene = files_load(
        files_text("far.obj",
                   "mtllib sub/m.mtl\nv -1 0 -1\nv -1 0 1\nv 1 0 1\nvt 0 1\nvt 0 0\nvt 1 0\n"
                   "usemtl m\nf 1/1 2/2 3/3\nusemtl plain\nf 1/1 2/2 3/3\nusemtl grey\nf 1/1 2/2 3/3\n"
                   "l 1 2 3\n"),
        files_env("env.exr", 1), NULL, NULL);
    static const float moved[6] = {2, 0, 0.25f, 0, 3, -2.5f};
    const struct rnd_material *m = &scene->material[scene->mesh[0].material];
    assert_string_equal(rnd_scene_info(scene)->warnings, "");
    assert_true(m->map[RND_MAP_BASE].texture >= 0 && m->map[RND_MAP_BASE].has_transform);
    for (int k = 0; k < 6; k++) NEAR(m->map[RND_MAP_BASE].transform[k], moved[k]);
    NEAR(m->base.x, 1), NEAR(m->roughness, 0.25), NEAR(m->metallic, 1), NEAR(m->specular, 1);
    NEAR(m->normal_scale, 0.5);
    assert_non_null(strstr(rnd_scene_info(scene)->unsupported, "map_Pr and map_Pm"));
    assert_non_null(strstr(rnd_scene_info(scene)->unsupported, "points and lines"));
    m = &scene->material[scene->mesh[1].material];
    NEAR(m->base.x, 1);
    assert_true(m->map[RND_MAP_BASE].texture >= 0 && !m->map[RND_MAP_BASE].has_transform);
    NEAR(scene->material[scene->mesh[2].material].base.x, 0.6);
    rnd_scene_destroy(scene);
}

/* A library that is named several times is read once, where it is named last. */
static void mtl_named_often(void **state)
{
    (void)state;
    static char text[4096];
    size_t lines = 0;
    files_text("one.mtl", "newmtl m\nPr 0.25\n");
    files_text("other.mtl", "newmtl m\nPr 0.75\n");
    int n = snprintf(text, sizeof text, "mtllib one.mtl\nmtllib other.mtl\n");
    for (int i = 0; i < 50; i++) n += snprintf(text + n, sizeof text - (size_t)n, "mtllib gone.mtl\n");
    snprintf(text + n, sizeof text - (size_t)n,
             "mtllib one.mtl\nusemtl m\nv -1 0 -1\nv -1 0 1\nv 1 0 1\nf 1 2 3\nmtllib gone.mtl\n");
    struct rnd_scene *scene = files_load(files_text("often.obj", text), files_env("env.exr", 1), NULL, NULL);
    NEAR(only(scene)->roughness, 0.25);
    for (const char *c = rnd_scene_info(scene)->warnings; *c; c++) lines += *c == '\n';
    assert_non_null(strstr(rnd_scene_info(scene)->warnings, "mtllib gone.mtl"));
    assert_int_equal(lines, 1);
    rnd_scene_destroy(scene);
}

/* Colours of 16 bits are sRGB like those of 8 bits; in glTF whatever gAMA says. Alpha and normals are not
 * changed. */
static void wide_images(void **state)
{
    (void)state;
    static char images[700];
    uint8_t png[128];
    for (int marked = 0; marked < 2; marked++) {
        const size_t count = files_png_bytes(png, 16, 128 * 257, marked ? 100000 : 0);
        snprintf(images, sizeof images,
                 ",\"textures\":[{\"source\":0}],\"images\":[{\"uri\":\"data:image/png;base64,%.600s\"}]",
                 files_base64(png, count));
        struct rnd_scene *scene =
            with_material("{\"normalTexture\":{\"index\":0},"
                          "\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0}}}",
                          images);
        const struct rnd_material *m = only(scene);
        const struct rnd_texel base = rnd_texture_texel(&scene->texture[m->map[RND_MAP_BASE].texture], 0),
                               normal = rnd_texture_texel(&scene->texture[m->map[RND_MAP_NORMAL].texture], 0);
        NEAR(base.g, 0.21586), NEAR(base.a, 0.50196), NEAR(normal.g, 0.50196);
        rnd_scene_destroy(scene);

        files_write("wide.png", png, count);
        scene = with_mtl("newmtl m\nmap_Kd wide.png\n");
        NEAR(rnd_texture_texel(&scene->texture[only(scene)->map[RND_MAP_BASE].texture], 0).g,
             marked ? 0.50196 : 0.21586);
        rnd_scene_destroy(scene);
    }
}

/* --- files from elsewhere --- */

static void cornell_boxes(void **state)
{
    (void)state;
    have(SHARED_DATA "/scenes/cornell-box");
    static const struct {
        const char *file;
        int mirrors, glasses, glossy;
        float ior;
    } cases[] = {{"Original", 0, 0, 0, 0},    {"Empty-CO", 0, 0, 0, 0},       {"Empty-RG", 0, 0, 0, 0},
                 {"Empty-White", 0, 0, 0, 0}, {"Empty-Squashed", 0, 0, 0, 0}, {"Mirror", 1, 0, 0, 0},
                 {"Sphere", 1, 1, 0, 2.5f},   {"Water", 1, 2, 0, 1.5f},       {"Glossy", 0, 0, 2, 0},
                 {"Glossy-Floor", 0, 0, 2, 0}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char path[300];
        int mirrors = 0, glasses = 0, glossy = 0;
        snprintf(path, sizeof path, SHARED_DATA "/scenes/cornell-box/CornellBox-%s.obj", cases[i].file);
        struct rnd_scene *scene = files_load(path, files_env("env.exr", 1), NULL, NULL);
        bool used[64] = {false};
        for (uint32_t k = 0; k < scene->mesh_count; k++) used[scene->mesh[k].material] = true;
        for (uint32_t k = 0; k < scene->material_count; k++) {
            const struct rnd_material *m = &scene->material[k];
            if (!used[k]) continue;
            mirrors += m->metallic == 1.0f && m->roughness == 0.0f && m->base.x == 0.95f;
            glossy += m->kind == RND_METAL_ROUGH && m->metallic == 0.0f && m->specular == 1.0f &&
                      m->roughness < 0.6f;
            if (m->transmission == 1.0f) {
                assert_true(!m->thin && m->roughness == 0.0f && m->kind == RND_RICH);
                if (++glasses == cases[i].glasses) NEAR(m->ior, cases[i].ior);
                NEAR(m->base.x * m->base.x, 0.1); /* Tf 0.1, for the way in and out */
            }
        }
        print_message("%s: %d mirrors, %d glasses, %d glossy\n", cases[i].file, mirrors, glasses, glossy);
        assert_int_equal(mirrors, cases[i].mirrors);
        assert_int_equal(glasses, cases[i].glasses);
        assert_int_equal(glossy, cases[i].glossy);
        rnd_scene_destroy(scene);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(files),           cmocka_unit_test(mtl),
        cmocka_unit_test(wide_images),     cmocka_unit_test(mtl_of_exporters),
        cmocka_unit_test(mtl_named_often), cmocka_unit_test(cornell_boxes),
    };
    return cmocka_run_group_tests_name("renderer_mtl", tests, files_setup, files_teardown);
}
