/* glTF materials and maps, as the scene holds them. */
#include "renderer_materials.h"

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
    /* a quarter turn takes (u, v) to (v, -u), which looks anticlockwise, because v points down */
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
    assert_int_equal(scene->texture_count, 2); /* the one image is used both as colours and as data */
    rnd_scene_destroy(scene);
}

/* An image in a buffer, and an image whose view does not hold one. */
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
        const struct rnd_scene_options options = {
            .image_program = files_image_program(), .path = path, .env_path = files_env("env.exr", 1)};
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

/* Textures that are read after the scene: at first the scene has none; later it equals a scene that was
 * loaded with them. A texture that cannot be read gives a warning. A scene may be destroyed before its
 * textures have come. */
static void later(void **state)
{
    (void)state;
    static const char material[] =
        "{\"pbrMetallicRoughness\":{\"baseColorFactor\":[1,0.5,0.25,1],"
        "\"baseColorTexture\":{\"index\":0},\"metallicRoughnessTexture\":{\"index\":0}}}";
    const char *warnings;
    char error[RND_ERROR_SIZE] = "";
    write_halves("halves.png", 0, 1);
    struct rnd_scene_options options = {.image_program = files_image_program(),
                                        .path = files_gltf("later.gltf", 1, node, material, IMAGE),
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

/* Values that a material cannot have, or of a type that their key does not take: a warning names the place,
 * and the nearest value or the default is used. */
static void broken_values(void **state)
{
    (void)state;
    static const struct {
        const char *material, *named; /* NULL: no warning */
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

/* --- files from elsewhere --- */

#define FIELD(name) offsetof(struct rnd_material, name)

static void blender_materials(void **state)
{
    (void)state;
    have(SHARED_DATA "/scenes/gltf-tests");
    static const struct {
        const char *file;
        int mesh; /* the mesh with the material, in the scene's order */
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
        cmocka_unit_test(blender_materials),
    };
    return cmocka_run_group_tests_name("renderer_gltf_materials", tests, files_setup, files_teardown);
}
