/* What scene files say of materials, maps and coverage, as it is in the scene and as it looks. */
#include "renderer_parts.h"

#include <sys/stat.h>

static const char node[] = "{\"mesh\":0}";

static const struct rnd_material *only(const struct rnd_scene *scene)
{
    return &scene->material[scene->mesh[0].material];
}

/* A scene of one square with that material, lit by a constant environment. */
static struct rnd_scene *with_material(const char *material, const char *more)
{
    return files_load(files_gltf("m.gltf", 1, node, material, more), files_env("env.exr", 1), NULL, NULL);
}

/* An image of two halves along u: of these alphas, grey. */
static const char *write_halves(const char *name, float left, float right)
{
    enum { SIDE = 16 };
    static const struct rnd_channel rgba[4] = {
        {"R", RND_BYTE}, {"G", RND_BYTE}, {"B", RND_BYTE}, {"A", RND_BYTE}};
    float data[SIDE * SIDE * 4];
    const char *path = files_path(name);
    for (int i = 0; i < SIDE * SIDE; i++) {
        data[4 * i] = data[4 * i + 1] = data[4 * i + 2] = 0.5f;
        data[4 * i + 3] = i % SIDE < SIDE / 2 ? left : right;
    }
    files_pixels(path, "png", SIDE, SIDE, 4, rgba, data);
    return path;
}

#define IMAGE                                                                                                \
    ",\"textures\":[{\"source\":0,\"sampler\":0}],\"images\":[{\"uri\":\"halves.png\"}],"                    \
    "\"samplers\":[{\"wrapS\":33648,\"wrapT\":33071}]"

/* --- materials --- */

static void all_factors(void **state)
{
    (void)state;
    struct rnd_scene *scene = with_material(
        "{\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.1,0.2,0.3,0.4],\"metallicFactor\":0.5,"
        "\"roughnessFactor\":0.6},\"alphaMode\":\"MASK\",\"alphaCutoff\":0.25,\"doubleSided\":true,"
        "\"emissiveFactor\":[1,0.5,0],\"extensions\":{\"KHR_materials_emissive_strength\":{"
        "\"emissiveStrength\":6},\"KHR_materials_ior\":{\"ior\":1.33},\"KHR_materials_specular\":{"
        "\"specularFactor\":0.7,\"specularColorFactor\":[0.5,1,2]},\"KHR_materials_transmission\":{"
        "\"transmissionFactor\":0.9},\"KHR_materials_volume\":{\"thicknessFactor\":0.1,"
        "\"attenuationDistance\":2,\"attenuationColor\":[1,0.5,0]},\"KHR_materials_clearcoat\":{"
        "\"clearcoatFactor\":0.8,\"clearcoatRoughnessFactor\":0.3},\"KHR_materials_sheen\":{"
        "\"sheenColorFactor\":[0.2,0.3,0.4],\"sheenRoughnessFactor\":0.45},\"KHR_materials_unlit\":{}}}",
        "");
    const struct rnd_material *m = only(scene);
    assert_int_equal(m->kind, RND_RICH);
    assert_int_equal(m->alpha_mode, RND_MASK);
    assert_true(m->double_sided && m->unlit && !m->thin);
    NEAR(m->base.y, 0.2), NEAR(m->alpha, 0.4), NEAR(m->alpha_cutoff, 0.25);
    NEAR(m->metallic, 0.5), NEAR(m->roughness, 0.6), NEAR(m->ior, 1.33);
    NEAR(m->emission.x, 6), NEAR(m->emission.y, 3), NEAR(m->emission.z, 0);
    NEAR(m->specular, 0.7), NEAR(m->specular_colour.x, 0.5), NEAR(m->specular_colour.z, 2);
    NEAR(m->transmission, 0.9), NEAR(m->clearcoat, 0.8), NEAR(m->clearcoat_roughness, 0.3);
    NEAR(m->absorption.x, 0), NEAR(m->absorption.y, -logf(0.5f) / 2);
    assert_true(m->absorption.z > 5 && isfinite(m->absorption.z));
    NEAR(m->sheen_colour.z, 0.4), NEAR(m->sheen_roughness, 0.45);
    assert_string_equal(rnd_scene_info(scene)->unsupported, "");
    rnd_scene_destroy(scene);
}

static void defaults(void **state)
{
    (void)state;
    static const char bare[] = "{\"attributes\":{\"POSITION\":0},\"indices\":2}";
    const struct files_part parts[] = {FILES_SQUARE};
    const char *path = files_parts("bare.gltf", bare, node, "{\"alphaMode\":\"BLEND\"}", "", parts, 3);
    struct rnd_scene *scenes[2] = {with_material("{}", ""),
                                   files_load(path, files_env("env.exr", 1), NULL, NULL)};
    for (int i = 0; i < 2; i++) {
        const struct rnd_material *m = only(scenes[i]);
        assert_int_equal(m->kind, RND_METAL_ROUGH);
        assert_int_equal(m->alpha_mode, RND_OPAQUE);
        assert_true(m->thin && !m->double_sided && !m->unlit);
        NEAR(m->base.x, 1), NEAR(m->metallic, 1), NEAR(m->roughness, 1), NEAR(m->ior, 1.5),
            NEAR(m->specular, 1);
        NEAR(m->alpha, 1), NEAR(m->alpha_cutoff, 0.5), NEAR(m->transmission, 0), NEAR(m->absorption.x, 0);
        for (int use = 0; use < RND_MAPS; use++) assert_int_equal(m->map[use].texture, -1);
        rnd_scene_destroy(scenes[i]);
    }
}

static void kinds(void **state)
{
    (void)state;
#define DULL                                                                                                 \
    "\"pbrMetallicRoughness\":{\"metallicFactor\":0},\"extensions\":{\"KHR_materials_specular\":{"           \
    "\"specularFactor\":0}}"
    static const struct {
        const char *material;
        enum rnd_material_kind kind;
    } cases[] = {
        {"{" DULL "}", RND_DIFFUSE},
        {"{\"alphaMode\":\"BLEND\"," DULL "}", RND_DIFFUSE},
        {"{\"normalTexture\":{\"index\":1}," DULL "}", RND_METAL_ROUGH},
        {"{\"emissiveFactor\":[1,1,1],\"emissiveTexture\":{\"index\":1}," DULL "}", RND_DIFFUSE},
        {"{\"emissiveFactor\":[1,1,1],\"emissiveTexture\":{\"index\":1,\"texCoord\":1}," DULL "}", RND_RICH},
        {"{}", RND_METAL_ROUGH},
        {"{\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":1},\"metallicRoughnessTexture\":{"
         "\"index\":1}}}",
         RND_METAL_ROUGH},
        {"{\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0}}}", RND_METAL_ROUGH},
        {"{\"normalTexture\":{\"index\":1,\"extensions\":{\"KHR_texture_transform\":{}}}}", RND_METAL_ROUGH},
        {"{\"normalTexture\":{\"index\":1,\"extensions\":{\"KHR_texture_transform\":{\"scale\":[2,1]}}}}",
         RND_RICH},
        {"{\"extensions\":{\"KHR_materials_transmission\":{}}}", RND_METAL_ROUGH},
        {"{\"extensions\":{\"KHR_materials_transmission\":{\"transmissionFactor\":0.1}}}", RND_RICH},
        {"{\"extensions\":{\"KHR_materials_clearcoat\":{\"clearcoatFactor\":1}}}", RND_RICH},
        {"{\"extensions\":{\"KHR_materials_sheen\":{\"sheenColorFactor\":[0,0,1]}}}", RND_RICH},
        {"{\"extensions\":{\"KHR_materials_unlit\":{}}}", RND_RICH},
        {"{\"extensions\":{\"KHR_materials_specular\":{\"specularColorFactor\":[1,1,0]}}}", RND_RICH},
        {"{\"extensions\":{\"KHR_materials_ior\":{\"ior\":2}}}", RND_METAL_ROUGH},
    };
    write_halves("halves.png", 1, 1);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct rnd_scene *scene = with_material(
            cases[i].material, ",\"textures\":[{\"source\":0,\"sampler\":0},{\"source\":0}],"
                               "\"images\":[{\"uri\":\"halves.png\"}],\"samplers\":[{\"wrapS\":33071}]");
        if (only(scene)->kind != cases[i].kind) print_message("%s\n", cases[i].material);
        assert_int_equal(only(scene)->kind, cases[i].kind);
        rnd_scene_destroy(scene);
    }
}

static void maps(void **state)
{
    (void)state;
    write_halves("halves.png", 1, 1);
    struct rnd_scene *scene = with_material(
        "{\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0,\"texCoord\":0,\"extensions\":{"
        "\"KHR_texture_transform\":{\"offset\":[0.5,0.25],\"rotation\":1.5707963,\"scale\":[2,3],"
        "\"texCoord\":1}}},"
        "\"metallicRoughnessTexture\":{\"index\":0}},\"normalTexture\":{\"index\":0,\"scale\":0.5},"
        "\"extensions\":{\"KHR_materials_specular\":{\"specularTexture\":{\"index\":0},"
        "\"specularColorTexture\":{"
        "\"index\":0}},\"KHR_materials_clearcoat\":{\"clearcoatFactor\":1,\"clearcoatTexture\":{\"index\":0},"
        "\"clearcoatNormalTexture\":{\"index\":0,\"scale\":2}},\"KHR_materials_sheen\":{\"sheenColorFactor\":"
        "[1,1,1],"
        "\"sheenColorTexture\":{\"index\":0},\"sheenRoughnessTexture\":{\"index\":0}},"
        "\"KHR_materials_transmission\":{\"transmissionFactor\":1,\"transmissionTexture\":{\"index\":0,"
        "\"texCoord\":1}}}}",
        IMAGE);
    const struct rnd_material *m = only(scene);
    const struct rnd_map *base = &m->map[RND_MAP_BASE];
    /* a quarter turn takes (u, v) to (v, -u): anticlockwise as seen, v being downwards */
    static const float turned[6] = {0, 3, 0.5f, -2, 0, 0.25f};
    for (int i = 0; i < 6; i++) NEAR(base->transform[i], turned[i]);
    assert_true(base->has_transform && !m->map[RND_MAP_NORMAL].has_transform);
    assert_int_equal(base->uv_set, 1);
    assert_int_equal(m->map[RND_MAP_TRANSMISSION].uv_set, 1);
    assert_int_equal(m->map[RND_MAP_NORMAL].uv_set, 0);
    assert_int_equal(base->wrap[0], RND_MIRROR);
    assert_int_equal(base->wrap[1], RND_CLAMP);
    NEAR(m->normal_scale, 0.5), NEAR(m->clearcoat_normal_scale, 2);
    NEAR(m->map[RND_MAP_NORMAL].transform[0], 1), NEAR(m->map[RND_MAP_NORMAL].transform[4], 1);
    for (int use = 0; use < RND_MAPS; use++) {
        const bool colour =
            use == RND_MAP_BASE || use == RND_MAP_SPECULAR_COLOUR || use == RND_MAP_SHEEN_COLOUR;
        if (use == RND_MAP_EMISSION || use == RND_MAP_CLEARCOAT_ROUGHNESS || use == RND_MAP_COVERAGE) {
            assert_int_equal(m->map[use].texture, -1);
            continue;
        }
        assert_true(m->map[use].texture >= 0);
        assert_int_equal(scene->texture[m->map[use].texture].use, colour ? RND_PIXELS_SRGB : RND_PIXELS_DATA);
    }
    assert_int_equal(scene->texture_count, 2); /* one image, as colours and as numbers */
    rnd_scene_destroy(scene);
}

/* An image within a buffer; and a view that holds none. */
static void image_in_buffer(void **state)
{
    (void)state;
    static char png[20000];
    static const char material[] = "{\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0}}}";
    FILE *file = fopen(write_halves("halves.png", 0, 1), "rb");
    assert_non_null(file);
    const size_t length = fread(png, 1, sizeof png, file);
    fclose(file);
    const struct files_part parts[] = {FILES_SQUARE, {png, length, NULL}};
    for (int view = 3; view >= 0; view -= 3) {
        char more[200], error[RND_ERROR_SIZE] = "";
        snprintf(more, sizeof more,
                 ",\"textures\":[{\"source\":0}],\"images\":[{\"bufferView\":%d,\"mimeType\":"
                 "\"image/png\"}]",
                 view);
        const char *path = files_parts("inside.gltf", files_primitive, node, material, more, parts, 4);
        const struct rnd_scene_options options = {.readers = files_readers(), .path = path, .env_path = files_env("env.exr", 1)};
        struct rnd_scene *scene = rnd_scene_load(&options, error);
        if (!scene) fail_msg("%s", error);
        if (view == 3) {
            assert_int_equal(scene->texture[only(scene)->map[RND_MAP_BASE].texture].level[0].width, 16);
        } else {
            assert_int_equal(only(scene)->map[RND_MAP_BASE].texture, -1);
            assert_non_null(strstr(rnd_scene_info(scene)->warnings, "inside.gltf"));
        }
        rnd_scene_destroy(scene);
    }
}

static void specular_glossiness(void **state)
{
    (void)state;
    struct rnd_scene *scene = with_material(
        "{\"extensions\":{\"KHR_materials_pbrSpecularGlossiness\":{\"diffuseFactor\":[0.1,0.2,0.3,1],"
        "\"specularFactor\":[0.16,0.04,0.08],\"glossinessFactor\":0.75}}}",
        "");
    const struct rnd_material *m = only(scene);
    const float root = (m->ior - 1) / (m->ior + 1);
    NEAR(m->base.y, 0.2), NEAR(m->metallic, 0), NEAR(m->roughness, 0.25), NEAR(m->specular, 1);
    NEAR(root * root * m->specular_colour.x, 0.16);
    NEAR(root * root * m->specular_colour.y, 0.04);
    NEAR(root * root * m->specular_colour.z, 0.08);
    rnd_scene_destroy(scene);
}

/* Textures that come after the scene: it does without, then has what it would have had at once; one that
 * cannot be read is told; and who does not want them any more need not wait. */
static void later(void **state)
{
    (void)state;
    static const char material[] =
        "{\"pbrMetallicRoughness\":{\"baseColorFactor\":[1,0.5,0.25,1],"
        "\"baseColorTexture\":{\"index\":0},\"metallicRoughnessTexture\":{\"index\":0}}}";
    const char *warnings;
    char error[RND_ERROR_SIZE] = "";
    write_halves("halves.png", 0, 1);
    struct rnd_scene_options options = {.readers = files_readers(), .path = files_gltf("later.gltf", 1, node, material, IMAGE),
                                        .env_path = files_env("env.exr", 1)};
    struct rnd_scene *at_once = rnd_scene_load(&options, error);
    assert_non_null(at_once);
    assert_int_equal(rnd_scene_take_textures(at_once, &warnings), RND_TEXTURES_IN_USE);
    options.textures_later = true;
    struct rnd_scene *scene = rnd_scene_load(&options, error);
    assert_non_null(scene);
    assert_int_equal(only(scene)->map[RND_MAP_BASE].texture, -1);
    assert_int_equal(rnd_scene_info(scene)->texture_bytes, 0);
    NEAR(only(scene)->base.y, 0.25), NEAR(only(scene)->metallic, 0);
    enum rnd_textures textures;
    while ((textures = rnd_scene_take_textures(scene, &warnings)) == RND_TEXTURES_READING) continue;
    assert_int_equal(textures, RND_TEXTURES_CAME);
    assert_int_equal(rnd_scene_take_textures(scene, &warnings), RND_TEXTURES_IN_USE);
    assert_memory_equal(only(scene), only(at_once), sizeof *only(scene));
    const uint64_t bytes = rnd_scene_info(at_once)->texture_bytes;
    assert_true(bytes > 0 && bytes == rnd_scene_info(scene)->texture_bytes);
    assert_memory_equal(scene->texture[0].bytes, at_once->texture[0].bytes,
                        scene->texture[0].level[1].first * 4);
    rnd_scene_destroy(scene);
    rnd_scene_destroy(at_once);

    for (int i = 0; i < 20; i++) rnd_scene_destroy(rnd_scene_load(&options, error));

    files_text("halves.png", "no image\n");
    scene = rnd_scene_load(&options, error);
    assert_non_null(scene);
    while ((textures = rnd_scene_take_textures(scene, &warnings)) == RND_TEXTURES_READING) continue;
    assert_int_equal(textures, RND_TEXTURES_CAME);
    assert_non_null(strstr(warnings, "halves.png"));
    NEAR(only(scene)->base.y, 0.5), NEAR(only(scene)->metallic, 1);
    rnd_scene_destroy(scene);
}

/* Values that a material cannot have, and types that its keys do not: a line that names the place, and the
 * nearest value or the default. */
static void broken_values(void **state)
{
    (void)state;
    static const struct {
        const char *material, *named; /* NULL: no line */
    } cases[] = {
        {"{\"pbrMetallicRoughness\":{\"baseColorFactor\":[1,1,2,1]}}",
         ".pbrMetallicRoughness.baseColorFactor: 2,"},
        {"{\"pbrMetallicRoughness\":{\"baseColorFactor\":[1,1,-1,1]}}",
         ".baseColorFactor: -1, expected 0 to 1; 0"},
        {"{\"pbrMetallicRoughness\":{\"roughnessFactor\":1.2}}",
         ".roughnessFactor: 1.2, expected 0 to 1; 1 is"},
        {"{\"pbrMetallicRoughness\":{\"metallicFactor\":1e300}}", ".metallicFactor: 1e+300,"},
        {"{\"emissiveFactor\":[-1,0,0]}", "materials[0].emissiveFactor: -1,"},
        {"{\"alphaCutoff\":-1}", "materials[0].alphaCutoff: -1"},
        {"{\"extensions\":{\"KHR_materials_ior\":{\"ior\":0.5}}}",
         ".KHR_materials_ior.ior: 0.5, expected 1 to"},
        {"{\"extensions\":{\"KHR_materials_volume\":{\"attenuationDistance\":0}}}",
         ".attenuationDistance: 0, expected"},
        {"{\"normalTexture\":{\"index\":9}}",
         ".normalTexture.index: expected the index of one of 1 textures"},
        {"{\"normalTexture\":{}}", ".normalTexture.index: expected the index"},
        {"{\"pbrMetallicRoughness\":{\"baseColorFactor\":\"red\"}}", ".baseColorFactor: expected 4 numbers"},
        {"{\"pbrMetallicRoughness\":{\"baseColorFactor\":[1,2],\"baseColorTexture\":7}}",
         "expected 4 numbers"},
        {"{\"pbrMetallicRoughness\":{\"metallicFactor\":\"x\"}}", ".metallicFactor: expected a number"},
        {"{\"emissiveFactor\":[1,\"x\",1],\"normalTexture\":\"x\",\"extensions\":{\"KHR_materials_sheen\":1}"
         "}",
         ".emissiveFactor: expected 3 numbers"},
        {"{\"pbrMetallicRoughness\":[],\"extensions\":3,\"alphaMode\":5,\"name\":{},\"doubleSided\":\"no\"}",
         NULL},
        {"7", NULL},
        {"{\"extensions\":{\"KHR_materials_ior\":{\"ior\":0}}}", NULL},     /* means a mirror */
        {"{\"pbrMetallicRoughness\":{\"roughnessFactor\":1.00005}}", NULL}, /* rounded */
        {"{\"normalTexture\":{\"index\":0,\"texCoord\":7}}", NULL},
    };
    write_halves("halves.png", 1, 1);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct rnd_scene *scene = with_material(cases[i].material, IMAGE);
        const char *lines = rnd_scene_info(scene)->warnings, *named = cases[i].named;
        if (named ? !strstr(lines, named) || !strstr(lines, "m.gltf: materials[0]") : *lines != 0)
            fail_msg("%s: \"%s\"", cases[i].material, lines);
        const struct rnd_material *m = only(scene);
        assert_true(m->roughness >= 0 && m->roughness <= 1 && m->metallic >= 0 && m->metallic <= 1);
        assert_true(m->base.z >= 0 && m->base.z <= 1 && m->emission.x >= 0 && m->ior >= 1);
        assert_true(isfinite(m->absorption.x) && m->alpha_cutoff >= 0);
        rnd_scene_destroy(scene);
    }
}

/* --- MTL --- */

static struct rnd_scene *with_mtl(const char *mtl)
{
    files_text("m.mtl", mtl);
    return files_load(files_text("m.obj",
                                 "mtllib m.mtl\nusemtl m\nv -1 0 -1\nv -1 0 1\nv 1 0 1\nvt 0 1\nvt 0 0\n"
                                 "vt 1 0\nf 1/1 2/2 3/3\n"),
                      files_env("env.exr", 1), NULL, NULL);
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

    scene = with_mtl("newmtl m\nKd 1 1 1\nNi 1.5\nillum 4\n"); /* "glass on", without refraction */
    assert_true(only(scene)->thin && only(scene)->pane);
    rnd_scene_destroy(scene);

    static const char *const bad[] = {"newmtl m\nKd -1 0 0\n", "newmtl m\nKe nan 0 0\n", "newmtl m\nd 2\n",
                                      "newmtl m\nNi 0.5\nillum 7\n"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        char error[RND_ERROR_SIZE] = "";
        files_text("m.mtl", bad[i]);
        const struct rnd_scene_options options = {.readers = files_readers(), .path = files_path("m.obj"),
                                                  .env_path = files_path("env.exr")};
        assert_null(rnd_scene_load(&options, error));
        print_message("%s\n", error);
        assert_non_null(strstr(error, "m.obj: material \"m\""));
    }
}

/* What assimp does not tell: options of maps, a map without its factor, the PBR keys, a library in a folder
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

/* Colours of 16 bits are sRGB as those of 8 are, in glTF whatever gAMA says; alpha and normals stay as they
 * are. */
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

/* --- coverage --- */

/* A black sheet at y = 0 under a white sky: what is seen of the sky below it, to the left and to the right.
 */
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
                           tolerance);
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

/* A floor that gets its light through a wide sheet above it, by shadow rays; the eye is in between. */
static void coverage_of_shadows(void **state)
{
    (void)state;
    files_text("s.mtl", "newmtl floor\nKd 0.5 0.5 0.5\nnewmtl sheet\nKd 0 0 0\nd 0.3\n");
    const char *path = files_text(
        "s.obj", "mtllib s.mtl\nv -99 -1 -99\nv -99 -1 99\nv 99 -1 99\nv 99 -1 -99\nv -99 1 -99\nv -99 1 99\n"
                 "v 99 1 99\nv 99 1 -99\nusemtl floor\nf 1 2 3 4\nusemtl sheet\nf 5 6 7 8\n");
    struct rnd_scene *scene = files_load(path, files_env("env.exr", 1), NULL, (float[]){0, 0, 0});
    const struct rnd_aim down = files_aim(0, -1, 0);
    assert_float_equal(files_radiance(scene, "fv", 0, 100000, &down, 30, NULL), 0.5 * 0.7, 0.01);
    rnd_scene_destroy(scene);
}

/* --- other people's files --- */

static void have(const char *folder)
{
    if (access(folder, R_OK) == 0) return;
    print_message("skipped: no %s\n", folder);
    skip();
}

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
                NEAR(m->base.x * m->base.x, 0.1); /* Tf 0.1, on the way in and out */
            }
        }
        print_message("%s: %d mirrors, %d glasses, %d glossy\n", cases[i].file, mirrors, glasses, glossy);
        assert_int_equal(mirrors, cases[i].mirrors);
        assert_int_equal(glasses, cases[i].glasses);
        assert_int_equal(glossy, cases[i].glossy);
        rnd_scene_destroy(scene);
    }
}

#define FIELD(name) offsetof(struct rnd_material, name)

static void blender_materials(void **state)
{
    (void)state;
    have(SHARED_DATA "/scenes/gltf-tests");
    static const struct {
        const char *file;
        int mesh; /* whose material, in the order of the scene's */
        size_t field;
        float value;
    } cases[] = {
        {"01_alpha_mask", 0, FIELD(alpha_cutoff), 0.42f},
        {"01_metallic_sphere", 0, FIELD(roughness), 0.0f},
        {"01_unlit", 1, FIELD(alpha), 0.5f},
        {"04_sphere_specular_glossiness", 0, FIELD(roughness), 1.0f},
        {"09_texture_transform", 0, FIELD(map[RND_MAP_BASE].transform[2]), 0.1f},
        {"09_texture_transform", 0, FIELD(map[RND_MAP_METAL_ROUGH].transform[5]), 0.3f},
        {"14_emission_strength", 3, FIELD(emission.x), 4.5f},
        {"15_transmission", 1, FIELD(transmission), 0.8f},
        {"16_volume", 0, FIELD(absorption.y), 0.693147f},
        {"17_ior", 2, FIELD(ior), 2.0f},
        {"19_sheen", 2, FIELD(sheen_roughness), 0.8f},
        {"20_specular", 4, FIELD(specular), 0.75f},
        {"20_specular", 6, FIELD(specular_colour.y), 0.3f},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char path[300];
        float value;
        snprintf(path, sizeof path, SHARED_DATA "/scenes/gltf-tests/%s/%s.gltf", cases[i].file,
                 cases[i].file);
        struct rnd_scene *scene = files_load(path, files_env("env.exr", 1), NULL, NULL);
        const struct rnd_material *m = &scene->material[scene->mesh[cases[i].mesh].material];
        memcpy(&value, (const char *)m + cases[i].field, sizeof value);
        print_message("%s: %g\n", cases[i].file, (double)value);
        NEAR(value, cases[i].value);
        rnd_scene_destroy(scene);
    }
}

/* A grey sheet under a white sky that has one side, on a floor of the same: an eye below the sheet sees the
 * sky through its back, and a floor that the sheet shades; what is mirrored shows its other side. */
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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(all_factors),
        cmocka_unit_test(defaults),
        cmocka_unit_test(kinds),
        cmocka_unit_test(maps),
        cmocka_unit_test(image_in_buffer),
        cmocka_unit_test(specular_glossiness),
        cmocka_unit_test(later),
        cmocka_unit_test(broken_values),
        cmocka_unit_test(mtl),
        cmocka_unit_test(wide_images),
        cmocka_unit_test(mtl_of_exporters),
        cmocka_unit_test(coverage),
        cmocka_unit_test(coverage_of_shadows),
        cmocka_unit_test(backs),
        cmocka_unit_test(cornell_boxes),
        cmocka_unit_test(blender_materials),
    };
    return cmocka_run_group_tests_name("renderer_materials_import", tests, files_setup, files_teardown);
}
