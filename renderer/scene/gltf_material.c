/* glTF 2.0 materials and their Khronos extensions, from the JSON of the file. */
#include "scene/material.h"

#include <assimp/material.h>
#include <float.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The material that is being read. */
struct reader {
    struct rnd_gltf *gltf;
    struct rnd_scene *scene;
    int index; /* in the file */
    const json_t *json;
    struct rnd_material *to;
    bool ok; /* until the first error, which is in gltf->error */
};

static void fail(struct reader *r, const char *what)
{
    char text[240];
    const char *name = json_string_value(json_object_get(r->json, "name"));
    if (!r->ok) return;
    snprintf(text, sizeof text, "material %d \"%.60s\": %.150s", r->index, name ? name : "", what);
    r->ok = rnd_gltf_fail(r->gltf, text);
}

/* --- numbers --- */

static float check(struct reader *r, const char *key, double value, double low, double high)
{
    const double slack = high < FLT_MAX ? 1e-4 * high : 0.0; /* exporters round */
    if (!(value >= low - slack && value <= high + slack)) {
        char what[120];
        snprintf(what, sizeof what, "%s is %g, expected %g to %g", key, value, low, high);
        fail(r, what);
    }
    return (float)fmin(fmax(value, low), high);
}

static float number(struct reader *r, const json_t *object, const char *key, float otherwise, double low,
                    double high)
{
    const json_t *value = json_object_get(object, key);
    return json_is_number(value) ? check(r, key, json_number_value(value), low, high) : otherwise;
}

/* A list of n numbers, or else what out holds already. */
static void numbers(struct reader *r, const json_t *object, const char *key, size_t n, double low,
                    double high, float *out)
{
    const json_t *list = json_object_get(object, key);
    if (json_array_size(list) != n) return;
    for (size_t i = 0; i < n; i++)
        if (!json_is_number(json_array_get(list, i))) return;
    for (size_t i = 0; i < n; i++)
        out[i] = check(r, key, json_number_value(json_array_get(list, i)), low, high);
}

/* --- maps --- */

/* Name of an image by what its bytes say, since OpenImageIO goes by the ending. */
static const char *ending(const uint8_t *bytes, size_t count, const json_t *image)
{
    const char *mime = json_string_value(json_object_get(image, "mimeType"));
    if (count >= 4 && memcmp(bytes, "\x89PNG", 4) == 0) return "png";
    if (count >= 2 && memcmp(bytes, "\xff\xd8", 2) == 0) return "jpg";
    if (count >= 12 && memcmp(bytes + 8, "WEBP", 4) == 0) return "webp";
    return mime && strcmp(mime, "image/jpeg") == 0 ? "jpg" : "png";
}

/* Index of the scene's texture for an image of the file, or -1 after fail(). */
static int add_image(struct reader *r, const json_t *index, bool srgb)
{
    const json_t *image = rnd_gltf_at(r->gltf, "images", index);
    const char *uri = json_string_value(json_object_get(image, "uri"));
    const enum rnd_pixels_use use = srgb ? RND_PIXELS_SRGB : RND_PIXELS_DATA;
    char path[4096];
    int texture = -1;
    if (uri && strncmp(uri, "data:", 5) != 0) {
        if (snprintf(path, sizeof path, "%s%s", uri[0] == '/' ? "" : r->gltf->directory, uri) >=
            (int)sizeof path) {
            fail(r, "an image's path is too long");
            return -1;
        }
        FILE *file = fopen(path, "rb");
        if (file)
            fclose(file);
        else
            rnd_gltf_decode_percent(path + strlen(path) - strlen(uri));
        texture = rnd_texture_add(r->scene, path, NULL, 0, use, r->gltf->error);
    } else {
        size_t count = 0;
        uint8_t *bytes = uri ? rnd_gltf_data_uri(uri, &count)
                             : rnd_gltf_view(r->gltf, json_object_get(image, "bufferView"), &count);
        if (!bytes && uri) {
            rnd_warn(&r->scene->warnings,
                     "%s: images[%d].uri: expected base64; what it is for goes by its factor alone",
                     r->gltf->path, (int)json_integer_value(index));
            return -1;
        }
        if (bytes) {
            snprintf(path, sizeof path, "%.200s: image %d.%s", r->gltf->path, (int)json_integer_value(index),
                     ending(bytes, count, image));
            texture = rnd_texture_add(r->scene, path, bytes, count, use, r->gltf->error);
        }
        free(bytes);
    }
    if (texture < 0) r->ok = false; /* the line is there */
    return texture;
}

static uint8_t wrap_of(const json_t *sampler, const char *key)
{
    const json_int_t mode = json_integer_value(json_object_get(sampler, key));
    return mode == 33071 ? RND_CLAMP : mode == 33648 ? RND_MIRROR : RND_REPEAT;
}

/* KHR_texture_transform: scale, then turn anticlockwise as seen with v downwards, then move. */
static void read_transform(struct reader *r, const json_t *json, struct rnd_map *map)
{
    float offset[2] = {0, 0}, scale[2] = {1, 1};
    numbers(r, json, "offset", 2, -1e6, 1e6, offset);
    numbers(r, json, "scale", 2, -1e6, 1e6, scale);
    const float turn = number(r, json, "rotation", 0.0f, -1e6, 1e6), c = cosf(turn), s = sinf(turn);
    const float m[6] = {c * scale[0], s * scale[1], offset[0], -s * scale[0], c * scale[1], offset[1]};
    static const float identity[6] = {1, 0, 0, 0, 1, 0};
    for (int i = 0; i < 6; i++) {
        map->transform[i] = m[i];
        if (m[i] != identity[i]) map->has_transform = true;
    }
}

static void read_map(struct reader *r, const json_t *object, const char *key, enum rnd_map_use use, bool srgb)
{
    const json_t *info = json_object_get(object, key);
    struct rnd_map *map = &r->to->map[use];
    if (!r->ok || !json_is_object(info)) return;
    const json_t *texture = rnd_gltf_at(r->gltf, "textures", json_object_get(info, "index"));
    const json_t *image = json_object_get(texture, "source");
    if (!image) image = json_object_get(rnd_gltf_extension(texture, "EXT_texture_webp"), "source");
    if (!texture) {
        char what[80];
        snprintf(what, sizeof what, "%s names a texture that is not there", key);
        fail(r, what);
        return;
    }
    if (!image) {
        rnd_scene_unsupported(r->scene, "textures without a PNG, JPEG or WebP image");
        return;
    }
    map->texture = add_image(r, image, srgb);
    const json_t *sampler = rnd_gltf_at(r->gltf, "samplers", json_object_get(texture, "sampler"));
    map->wrap[0] = wrap_of(sampler, "wrapS");
    map->wrap[1] = wrap_of(sampler, "wrapT");
    const json_t *transform = rnd_gltf_extension(info, "KHR_texture_transform");
    const json_t *set = json_object_get(transform, "texCoord");
    if (!json_is_integer(set)) set = json_object_get(info, "texCoord");
    const json_int_t n = json_integer_value(set);
    if (n < 0 || n > 1) {
        rnd_scene_unsupported(r->scene, "texture coordinates beyond the second set");
        map->texture = -1;
    }
    map->uv_set = n == 1;
    read_transform(r, transform, map);
}

/* --- extensions --- */

static void read_volume(struct reader *r, const json_t *json)
{
    struct rnd_material *to = r->to;
    const float thickness = number(r, json, "thicknessFactor", 0.0f, 0.0, FLT_MAX);
    const float distance = number(r, json, "attenuationDistance", INFINITY, FLT_MIN, FLT_MAX);
    vec3s colour = glms_vec3_one();
    numbers(r, json, "attenuationColor", 3, 0.0, 1.0, colour.raw);
    to->thin = !(thickness > 0.0f);
    /* of black no finite absorption makes; this leaves a millionth */
    for (int c = 0; !to->thin && c < 3; c++)
        to->absorption.raw[c] = fminf(-logf(fmaxf(colour.raw[c], 1e-6f)) / distance, FLT_MAX);
}

/* The older workflow: diffuse and specular colours, which the newer one has too, as base and reflectance. */
static void read_specular_glossiness(struct reader *r, const json_t *json)
{
    struct rnd_material *to = r->to;
    float diffuse[4] = {1, 1, 1, 1}, gloss = number(r, json, "glossinessFactor", 1.0f, 0.0, 1.0);
    vec3s specular = glms_vec3_one();
    numbers(r, json, "diffuseFactor", 4, 0.0, 1.0, diffuse);
    numbers(r, json, "specularFactor", 3, 0.0, 1.0, specular.raw);
    read_map(r, json, "diffuseTexture", RND_MAP_BASE, true);
    read_map(r, json, "specularGlossinessTexture", RND_MAP_SPECULAR_COLOUR, true);
    to->base = rnd_vec(diffuse);
    to->alpha = diffuse[3];
    to->metallic = 0.0f;
    rnd_material_set_f0(to, specular);
    const int texture = to->map[RND_MAP_SPECULAR_COLOUR].texture;
    if (texture >= 0) { /* of the glossiness only the mean is taken: the texel of the coarsest mipmap */
        struct rnd_texture *t = &r->scene->texture[texture];
        if (t->levels > 0 || rnd_texture_load(t)) {
            gloss *= rnd_texture_texel(t, t->level[t->levels - 1].first).a;
            rnd_scene_unsupported(r->scene, "glossiness maps (their mean is taken)");
        }
    }
    to->roughness = 1.0f - gloss;
}

static void read_extensions(struct reader *r, const json_t *json)
{
    /* What is asked for and not done, and the name under which it is reported. */
    static const struct {
        const char *extension, *name;
    } missing[] = {
        {"KHR_materials_anisotropy", "anisotropy"},
        {"KHR_materials_iridescence", "iridescence"},
        {"KHR_materials_dispersion", "dispersion"},
        {"KHR_materials_diffuse_transmission", "diffuse transmission"},
    };
    struct rnd_material *to = r->to;
    const json_t *e = rnd_gltf_extension(json, "KHR_materials_ior");
    const float ior = number(r, e, "ior", 1.5f, 0.0, 1e3);
    if (ior > 0.0f && ior < 1.0f) fail(r, "ior is between 0 and 1, expected 0 or from 1 on");
    if (ior == 0.0f) rnd_material_set_f0(to, glms_vec3_one()); /* KHR_materials_ior: reflects all */
    if (ior >= 1.0f) to->ior = ior;

    if ((e = rnd_gltf_extension(json, "KHR_materials_specular"))) {
        to->specular = number(r, e, "specularFactor", 1.0f, 0.0, 1.0);
        numbers(r, e, "specularColorFactor", 3, 0.0, FLT_MAX, to->specular_colour.raw);
        read_map(r, e, "specularTexture", RND_MAP_SPECULAR, false);
        read_map(r, e, "specularColorTexture", RND_MAP_SPECULAR_COLOUR, true);
    }
    if ((e = rnd_gltf_extension(json, "KHR_materials_transmission"))) {
        to->transmission = number(r, e, "transmissionFactor", 0.0f, 0.0, 1.0);
        if (to->transmission > 0.0f) read_map(r, e, "transmissionTexture", RND_MAP_TRANSMISSION, false);
    }
    if ((e = rnd_gltf_extension(json, "KHR_materials_volume"))) read_volume(r, e);
    if ((e = rnd_gltf_extension(json, "KHR_materials_clearcoat"))) {
        to->clearcoat = number(r, e, "clearcoatFactor", 0.0f, 0.0, 1.0);
        to->clearcoat_roughness = number(r, e, "clearcoatRoughnessFactor", 0.0f, 0.0, 1.0);
        if (to->clearcoat > 0.0f) {
            const json_t *normal = json_object_get(e, "clearcoatNormalTexture");
            to->clearcoat_normal_scale = number(r, normal, "scale", 1.0f, -1e3, 1e3);
            read_map(r, e, "clearcoatTexture", RND_MAP_CLEARCOAT, false);
            read_map(r, e, "clearcoatRoughnessTexture", RND_MAP_CLEARCOAT_ROUGHNESS, false);
            read_map(r, e, "clearcoatNormalTexture", RND_MAP_CLEARCOAT_NORMAL, false);
        }
    }
    if ((e = rnd_gltf_extension(json, "KHR_materials_sheen"))) {
        numbers(r, e, "sheenColorFactor", 3, 0.0, 1.0, to->sheen_colour.raw);
        to->sheen_roughness = number(r, e, "sheenRoughnessFactor", 0.0f, 0.0, 1.0);
        if (glms_vec3_max(to->sheen_colour) > 0.0f) {
            read_map(r, e, "sheenColorTexture", RND_MAP_SHEEN_COLOUR, true);
            read_map(r, e, "sheenRoughnessTexture", RND_MAP_SHEEN_ROUGHNESS, false);
        }
    }
    to->unlit = rnd_gltf_extension(json, "KHR_materials_unlit") != NULL;
    for (size_t i = 0; i < sizeof missing / sizeof *missing; i++)
        if (rnd_gltf_extension(json, missing[i].extension)) rnd_scene_unsupported(r->scene, missing[i].name);
}

static bool read_material(struct rnd_gltf *gltf, struct rnd_scene *scene, int index, struct rnd_material *to)
{
    const json_t *json = json_array_get(json_object_get(gltf->root, "materials"), (size_t)index);
    struct reader r = {.gltf = gltf, .scene = scene, .index = index, .json = json, .to = to, .ok = true};
    const json_t *pbr = json_object_get(json, "pbrMetallicRoughness"),
                 *gloss = rnd_gltf_extension(json, "KHR_materials_pbrSpecularGlossiness"),
                 *strength = rnd_gltf_extension(json, "KHR_materials_emissive_strength"),
                 *normal = json_object_get(json, "normalTexture");
    const char *alpha = json_string_value(json_object_get(json, "alphaMode"));
    if (gloss) {
        read_specular_glossiness(&r, gloss);
    } else {
        float base[4] = {1, 1, 1, 1};
        numbers(&r, pbr, "baseColorFactor", 4, 0.0, 1.0, base);
        to->base = rnd_vec(base);
        to->alpha = base[3];
        to->metallic = number(&r, pbr, "metallicFactor", 1.0f, 0.0, 1.0);
        to->roughness = number(&r, pbr, "roughnessFactor", 1.0f, 0.0, 1.0);
        read_map(&r, pbr, "baseColorTexture", RND_MAP_BASE, true);
        read_map(&r, pbr, "metallicRoughnessTexture", RND_MAP_METAL_ROUGH, false);
        read_extensions(&r, json);
    }
    to->normal_scale = number(&r, normal, "scale", 1.0f, -1e3, 1e3);
    read_map(&r, json, "normalTexture", RND_MAP_NORMAL, false);

    /* Beyond 1 the factor means what it says, though the specification leaves that to the strength. */
    numbers(&r, json, "emissiveFactor", 3, 0.0, FLT_MAX, to->emission.raw);
    to->emission =
        glms_vec3_scale(to->emission, number(&r, strength, "emissiveStrength", 1.0f, 0.0, FLT_MAX));
    if (!isfinite(rnd_luminance(to->emission.raw))) fail(&r, "its emission is not finite");
    if (glms_vec3_max(to->emission) > 0.0f) read_map(&r, json, "emissiveTexture", RND_MAP_EMISSION, true);

    if (alpha && strcmp(alpha, "MASK") == 0) to->alpha_mode = RND_MASK;
    if (alpha && strcmp(alpha, "BLEND") == 0) to->alpha_mode = RND_BLEND;
    to->alpha_cutoff = number(&r, json, "alphaCutoff", 0.5f, 0.0, FLT_MAX);
    to->double_sided = json_is_true(json_object_get(json, "doubleSided"));
    to->one_sided = !to->double_sided && !(to->transmission > 0.0f); /* glass is seen through to its back */
    rnd_material_set_kind(to);
    return r.ok;
}

/* Which of the file's materials assimp's is, by its name, or -1: the default for what names none. */
static int index_of(const struct aiMaterial *material)
{
    struct aiString name;
    if (aiGetMaterialString(material, AI_MATKEY_NAME, &name) != aiReturn_SUCCESS) return -1;
    if (name.length == 0 || name.length > 9 || strspn(name.data, "0123456789") != name.length) return -1;
    return atoi(name.data);
}

bool rnd_gltf_materials(struct rnd_gltf *gltf, struct rnd_scene *scene, const struct aiScene *file)
{
    for (uint32_t i = 0; i < scene->material_count; i++) {
        const int index = index_of(file->mMaterials[i]);
        rnd_material_init(&scene->material[i]);
        if (index >= 0 && !read_material(gltf, scene, index, &scene->material[i])) return false;
    }
    return true;
}
