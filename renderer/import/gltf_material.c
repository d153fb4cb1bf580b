/* glTF 2.0 materials and their Khronos extensions. */
#include "import/gltf_material.h"
#include "import/find_file.h"
#include "import/gltf_bytes.h"
#include "import/gltf_json.h"
#include "material/material.h"

#include <float.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The material that is being read. */
struct reader {
    struct rnd_gltf *gltf;
    struct rnd_scene *scene;
    size_t index;     /* in the file */
    const char *part; /* place within the material, as ".extensions.KHR_materials_ior" */
    struct rnd_material *to;
};

/* "path: materials[3].pbrMetallicRoughness.metallicFactor: what" as a warning. */
static void warn(struct reader *r, const char *key, const char *what)
{
    rnd_warn(&r->scene->warnings, "%.200s: materials[%zu]%s.%s: %s", r->gltf->in->path, r->index, r->part,
             key, what);
}

/* --- numbers --- */

static float check(struct reader *r, const char *key, double value, double low, double high)
{
    const double clamped = fmin(fmax(value, low), high), slack = high < FLT_MAX ? 1e-4 * high : 0.0;
    if (!(value >= low - slack && value <= high + slack)) { /* within slack: an exporter has rounded */
        char what[120];
        snprintf(what, sizeof what, "%g, expected %g to %g; %g is used", value, low, high, clamped);
        warn(r, key, what);
    }
    return (float)clamped;
}

static float number(struct reader *r, const json_t *object, const char *key, float otherwise, double low,
                    double high)
{
    const json_t *value = json_object_get(object, key);
    if (json_is_number(value)) return check(r, key, json_number_value(value), low, high);
    if (value) warn(r, key, "expected a number; the default is used");
    return otherwise;
}

/* Read a list of n numbers; without it out stays as it is. */
static void numbers(struct reader *r, const json_t *object, const char *key, size_t n, double low,
                    double high, float *out)
{
    const json_t *list = json_object_get(object, key);
    bool good = json_array_size(list) == n;
    for (size_t i = 0; i < n; i++) good = good && json_is_number(json_array_get(list, i));
    if (list && !good)
        warn(r, key,
             n == 4   ? "expected 4 numbers; the default is used"
             : n == 3 ? "expected 3 numbers; the default is used"
                      : "expected 2 numbers; the default is used");
    for (size_t i = 0; good && i < n; i++)
        out[i] = check(r, key, json_number_value(json_array_get(list, i)), low, high);
}

/* --- maps --- */

/* A file name extension from an image's bytes, by which OpenImageIO chooses its reader. */
static const char *ending(const uint8_t *bytes, size_t count, const json_t *image)
{
    const char *mime = json_string_value(json_object_get(image, "mimeType"));
    if (count >= 4 && memcmp(bytes, "\x89PNG", 4) == 0) return "png";
    if (count >= 2 && memcmp(bytes, "\xff\xd8", 2) == 0) return "jpg";
    if (count >= 12 && memcmp(bytes + 8, "WEBP", 4) == 0) return "webp";
    return mime && strcmp(mime, "image/jpeg") == 0 ? "jpg" : "png";
}

/* Index of the scene's texture for an image of the file, or -1 after a warning. */
static int read_image(struct reader *r, size_t index, const json_t *image, bool srgb)
{
    const enum rnd_pixels_use use = srgb ? RND_PIXELS_SRGB : RND_PIXELS_DATA;
    const struct rnd_import *in = r->gltf->in;
    const char *uri = json_string_value(json_object_get(image, "uri"));
    char path[RND_PATH_SIZE], where[RND_WHERE_SIZE];
    uint8_t *own = NULL;
    size_t count = 0, stride;
    if (uri && strncmp(uri, "data:", 5) != 0) {
        const bool found = rnd_find_file(in->directory, uri, true, path);
        rnd_files_add(&r->scene->files, path);
        if (found) {
            const int texture = rnd_texture_add(r->scene, path, NULL, 0, use, in->error);
            if (texture < 0) rnd_warn(&r->scene->warnings, "%s", in->error);
            return texture;
        }
        rnd_warn(&r->scene->warnings, "%s: images[%zu].uri: %s: %s; the material's factor is used alone",
                 in->path, index, path, rnd_why_not_found(path));
        return -1;
    }
    snprintf(where, sizeof where, "images[%zu].bufferView", index);
    const uint8_t *bytes =
        uri ? (own = rnd_gltf_data_uri(uri, &count))
            : rnd_gltf_view(r->gltf, json_object_get(image, "bufferView"), where, &count, &stride);
    if (!bytes) {
        if (uri) rnd_import_fail(r->gltf->in, "images[%zu].uri: expected a file or base64", index);
        rnd_warn(&r->scene->warnings, "%s; the material's factor is used alone", in->error);
        return -1;
    }
    if (!rnd_gltf_ask(r->gltf, count / 4, where)) {
        rnd_warn(&r->scene->warnings, "%s", in->error);
        free(own);
        return -1;
    }
    snprintf(path, sizeof path, "%.200s: image %zu.%s", in->path, index, ending(bytes, count, image));
    const int texture = rnd_texture_add(r->scene, path, bytes, count, use, in->error);
    if (texture < 0) rnd_warn(&r->scene->warnings, "%s", in->error);
    free(own);
    return texture;
}

/* The same, but read once for all maps that share the image. */
static int add_image(struct reader *r, size_t index, const json_t *image, bool srgb)
{
    struct rnd_gltf_image *known = &r->gltf->image[index][srgb];
    if (!known->read) *known = (struct rnd_gltf_image){true, read_image(r, index, image, srgb)};
    return known->texture;
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

/* The image of a texture that a map names. NULL after a warning if there is none that can be read. */
static const json_t *find_image(struct reader *r, const json_t *info, const char *key,
                                const json_t **out_texture, size_t *out_index)
{
    char where[RND_WHERE_SIZE];
    snprintf(where, sizeof where, "materials[%zu]%s.%s.index", r->index, r->part, key);
    const json_t *texture = *out_texture =
        rnd_gltf_at(r->gltf, "textures", json_object_get(info, "index"), where, NULL);
    const json_t *source = json_object_get(texture, "source"), *image = NULL;
    if (!source) source = json_object_get(rnd_gltf_extension(texture, "EXT_texture_webp"), "source");
    snprintf(where, sizeof where, "materials[%zu]%s.%s: its texture's source", r->index, r->part, key);
    if (texture && !source)
        rnd_scene_unsupported(r->scene, "textures without a PNG, JPEG or WebP image");
    else if (!texture || !(image = rnd_gltf_at(r->gltf, "images", source, where, out_index)))
        rnd_warn(&r->scene->warnings, "%s; the material's factor is used alone", r->gltf->in->error);
    return image;
}

static void read_map(struct reader *r, const json_t *object, const char *key, enum rnd_map_use use, bool srgb)
{
    const json_t *info = json_object_get(object, key), *texture;
    struct rnd_map *map = &r->to->map[use];
    size_t index;
    if (!json_is_object(info)) return;
    const json_t *image = find_image(r, info, key, &texture, &index);
    if (!image) return;
    const json_t *transform = rnd_gltf_extension(info, "KHR_texture_transform");
    const json_t *set = json_object_get(transform, "texCoord");
    if (!json_is_integer(set)) set = json_object_get(info, "texCoord");
    const json_int_t n = json_integer_value(set);
    if (n < 0 || n > 1) {
        rnd_scene_unsupported(r->scene, "texture coordinates beyond the second set");
        return;
    }
    map->texture = add_image(r, index, image, srgb);
    const json_t *sampler =
        rnd_gltf_element(json_object_get(r->gltf->root, "samplers"), json_object_get(texture, "sampler"));
    map->wrap[0] = wrap_of(sampler, "wrapS");
    map->wrap[1] = wrap_of(sampler, "wrapT");
    map->nearest = json_integer_value(json_object_get(sampler, "magFilter")) == 9728;
    map->uv_set = n == 1;
    read_transform(r, transform, map);
}

/* --- extensions --- */

static void read_volume(struct reader *r, const json_t *json)
{
    struct rnd_material *to = r->to;
    const float thickness = number(r, json, "thicknessFactor", 0.0f, 0.0, FLT_MAX);
    float distance = number(r, json, "attenuationDistance", INFINITY, 0.0, FLT_MAX);
    vec3s colour = glms_vec3_one();
    numbers(r, json, "attenuationColor", 3, 0.0, 1.0, colour.raw);
    if (distance == 0.0f) {
        warn(r, "attenuationDistance", "0, expected more; nothing is absorbed");
        distance = INFINITY;
    }
    to->thin = !(thickness > 0.0f);
    /* no finite absorption makes black; this leaves a millionth */
    for (int c = 0; !to->thin && c < 3; c++)
        to->absorption.raw[c] = fminf(-logf(fmaxf(colour.raw[c], 1e-6f)) / distance, FLT_MAX);
}

/* The older workflow: its diffuse and specular colours become base colour and reflectance. */
static void read_specular_glossiness(struct reader *r, const json_t *json)
{
    struct rnd_material *to = r->to;
    float diffuse[4] = {1, 1, 1, 1};
    const float gloss = number(r, json, "glossinessFactor", 1.0f, 0.0, 1.0);
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
    to->glossiness_mapped = texture >= 0;
    to->roughness = 1.0f - gloss;
}

static void read_extensions(struct reader *r, const json_t *json)
{
    /* Features that are not done, and the names under which they are reported. */
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
    r->part = ".extensions.KHR_materials_ior";
    float ior = number(r, e, "ior", 1.5f, 0.0, 1e3);
    if (ior > 0.0f && ior < 1.0f) ior = check(r, "ior", (double)ior, 1.0, 1e3);
    if (ior == 0.0f) rnd_material_set_f0(to, glms_vec3_one()); /* KHR_materials_ior: reflects all */
    if (ior >= 1.0f) to->ior = ior;

    r->part = ".extensions.KHR_materials_specular";
    if ((e = rnd_gltf_extension(json, "KHR_materials_specular"))) {
        to->specular = number(r, e, "specularFactor", 1.0f, 0.0, 1.0);
        numbers(r, e, "specularColorFactor", 3, 0.0, FLT_MAX, to->specular_colour.raw);
        read_map(r, e, "specularTexture", RND_MAP_SPECULAR, false);
        read_map(r, e, "specularColorTexture", RND_MAP_SPECULAR_COLOUR, true);
    }
    r->part = ".extensions.KHR_materials_transmission";
    if ((e = rnd_gltf_extension(json, "KHR_materials_transmission"))) {
        to->transmission = number(r, e, "transmissionFactor", 0.0f, 0.0, 1.0);
        if (to->transmission > 0.0f) read_map(r, e, "transmissionTexture", RND_MAP_TRANSMISSION, false);
    }
    r->part = ".extensions.KHR_materials_volume";
    if ((e = rnd_gltf_extension(json, "KHR_materials_volume"))) read_volume(r, e);
    r->part = ".extensions.KHR_materials_clearcoat";
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
    r->part = ".extensions.KHR_materials_sheen";
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

static bool read_material(struct rnd_gltf *gltf, size_t index, struct rnd_material *to)
{
    const json_t *json = json_array_get(json_object_get(gltf->root, "materials"), index);
    struct reader r = {.gltf = gltf, .scene = gltf->in->scene, .index = index, .part = "", .to = to};
    const json_t *pbr = json_object_get(json, "pbrMetallicRoughness"),
                 *gloss = rnd_gltf_extension(json, "KHR_materials_pbrSpecularGlossiness"),
                 *strength = rnd_gltf_extension(json, "KHR_materials_emissive_strength"),
                 *normal = json_object_get(json, "normalTexture");
    const char *alpha = json_string_value(json_object_get(json, "alphaMode"));
    if (gloss) {
        r.part = ".extensions.KHR_materials_pbrSpecularGlossiness";
        read_specular_glossiness(&r, gloss);
    } else {
        float base[4] = {1, 1, 1, 1};
        r.part = ".pbrMetallicRoughness";
        numbers(&r, pbr, "baseColorFactor", 4, 0.0, 1.0, base);
        to->base = rnd_vec(base);
        to->alpha = base[3];
        to->metallic = number(&r, pbr, "metallicFactor", 1.0f, 0.0, 1.0);
        to->roughness = number(&r, pbr, "roughnessFactor", 1.0f, 0.0, 1.0);
        read_map(&r, pbr, "baseColorTexture", RND_MAP_BASE, true);
        read_map(&r, pbr, "metallicRoughnessTexture", RND_MAP_METAL_ROUGH, false);
        read_extensions(&r, json);
    }
    r.part = "";
    to->normal_scale = number(&r, normal, "scale", 1.0f, -1e3, 1e3);
    read_map(&r, json, "normalTexture", RND_MAP_NORMAL, false);

    /* A factor above 1 is used as it is, though by the specification the strength should say so. */
    numbers(&r, json, "emissiveFactor", 3, 0.0, FLT_MAX, to->emission.raw);
    to->emission =
        glms_vec3_scale(to->emission, number(&r, strength, "emissiveStrength", 1.0f, 0.0, FLT_MAX));
    if (!isfinite(rnd_luminance(to->emission.raw)))
        return rnd_import_fail(gltf->in, "materials[%zu]: its emission is not finite", index);
    if (glms_vec3_max(to->emission) > 0.0f) read_map(&r, json, "emissiveTexture", RND_MAP_EMISSION, true);

    if (alpha && strcmp(alpha, "MASK") == 0) to->alpha_mode = RND_MASK;
    if (alpha && strcmp(alpha, "BLEND") == 0) to->alpha_mode = RND_BLEND;
    to->alpha_cutoff = number(&r, json, "alphaCutoff", 0.5f, 0.0, FLT_MAX);
    to->double_sided = json_is_true(json_object_get(json, "doubleSided"));
    to->one_sided = !to->double_sided && !(to->transmission > 0.0f); /* through glass its back is seen */
    rnd_material_set_kind(to);
    return true;
}

bool rnd_gltf_materials(struct rnd_gltf *gltf)
{
    struct rnd_scene *scene = gltf->in->scene;
    const size_t count = rnd_gltf_length(gltf, "materials");
    scene->material = calloc(count + 1, sizeof *scene->material);
    if (!scene->material) return rnd_import_fail(gltf->in, "not enough memory");
    scene->material_count = (uint32_t)count + 1;
    for (size_t i = 0; i <= count; i++) rnd_material_init(&scene->material[i]);
    for (size_t i = 0; i < count; i++)
        if (!read_material(gltf, i, &scene->material[i])) return false;
    return true;
}
