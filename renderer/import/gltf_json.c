/* The JSON of a glTF file: the whole file, or the first chunk of a GLB. */
#include "import/gltf_json.h"
#include "import/open_file.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_JSON_BYTES = 256 << 20 };

/* --- reading --- */

static uint32_t little_endian(const uint8_t *b)
{
    return (uint32_t)b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}

/* Find the chunks of a GLB: 12 bytes of header, then length, kind and bytes of each. False and a line. */
static bool read_chunks(struct rnd_gltf *gltf, FILE *file, size_t size, size_t *out_start, size_t *out_length)
{
    uint8_t head[12];
    size_t at = 12;
    *out_length = 0;
    if (fread(head, 1, 12, file) != 12) return rnd_import_fail(gltf->in, "ends within the header of a GLB");
    if (little_endian(head + 4) != 2)
        return rnd_import_fail(gltf->in, "is glTF %u.0 as its header says, expected 2.0",
                               little_endian(head + 4));
    while (at + 8 <= size && fseek(file, (long)at, SEEK_SET) == 0 && fread(head, 1, 8, file) == 8) {
        const size_t length = little_endian(head), left = size - at - 8;
        at += 8;
        if (memcmp(head + 4, "JSON", 4) == 0 && *out_length == 0) {
            if (length > left)
                return rnd_import_fail(gltf->in, "ends within its JSON: %zu bytes of %zu", left, length);
            *out_start = at;
            *out_length = length;
        }
        if (memcmp(head + 4, "BIN", 4) == 0 && gltf->bin_start == 0) {
            gltf->bin_start = at;
            gltf->bin_size = length < left ? length : left;
        }
        if (length > left) break;
        at += length;
    }
    return *out_length > 0 || rnd_import_fail(gltf->in, "is a GLB without a chunk of JSON");
}

static bool parse(struct rnd_gltf *gltf, const char *text, size_t length)
{
    json_error_t why;
    if (length >= 3 && memcmp(text, "\xef\xbb\xbf", 3) == 0) {
        rnd_warn(&gltf->in->scene->warnings,
                 "%s: begins with a byte order mark, which glTF does not allow; it is passed over",
                 gltf->in->path);
        text += 3;
        length -= 3;
    }
    while (length > 0 && text[length - 1] == 0) length--; /* some exporters pad the chunk with zeros */
    if ((gltf->root = json_loadb(text, length, 0, &why))) return true;
    return rnd_import_fail(gltf->in, "line %d, column %d: expected JSON: %.150s", why.line, why.column,
                           why.text);
}

static bool load_json(struct rnd_gltf *gltf)
{
    const char *why;
    FILE *file = rnd_open_file(gltf->in->path, &why);
    if (!file) return rnd_import_fail(gltf->in, "%s", why);
    uint8_t magic[4] = {0};
    char *text = NULL;
    size_t start = 0;
    bool ok = false;
    const long end = fseek(file, 0, SEEK_END) == 0 ? ftell(file) : -1;
    size_t length = end > 0 ? (size_t)end : 0;
    if (end < 0 || fseek(file, 0, SEEK_SET) != 0) {
        rnd_import_fail(gltf->in, "cannot be read");
        goto end;
    }
    if (fread(magic, 1, 4, file) == 4 && memcmp(magic, "glTF", 4) == 0) {
        rewind(file);
        if (!read_chunks(gltf, file, (size_t)end, &start, &length)) goto end;
    }
    if (length > MAX_JSON_BYTES || fseek(file, (long)start, SEEK_SET) != 0 || !(text = malloc(length + 1)) ||
        fread(text, 1, length, file) != length)
        rnd_import_fail(gltf->in, "%s",
                        length > MAX_JSON_BYTES ? "more than 256 MiB of JSON" : "cannot be read");
    else
        ok = parse(gltf, text, length);
end:
    fclose(file);
    free(text);
    return ok;
}

/* --- looking into it --- */

const json_t *rnd_gltf_extension(const json_t *object, const char *name)
{
    return json_object_get(json_object_get(object, "extensions"), name);
}

size_t rnd_gltf_length(const struct rnd_gltf *gltf, const char *list)
{
    return json_array_size(json_object_get(gltf->root, list));
}

bool rnd_gltf_size(struct rnd_gltf *gltf, const json_t *object, const char *key, size_t otherwise,
                   size_t most, const char *where, size_t *out)
{
    const json_t *value = json_object_get(object, key);
    const double number = json_number_value(value);
    *out = otherwise;
    if (!value && otherwise != SIZE_MAX) return true;
    if (!json_is_number(value) || !(number >= 0.0 && number <= (double)most) || number != floor(number))
        return rnd_import_fail(gltf->in, "%s.%s: expected a whole number from 0 to %zu%s", where, key, most,
                               value ? "" : ", and there is none");
    *out = (size_t)number;
    return true;
}

const json_t *rnd_gltf_at(struct rnd_gltf *gltf, const char *list, const json_t *value, const char *where,
                          size_t *out_index)
{
    const size_t length = rnd_gltf_length(gltf, list);
    const json_int_t i = json_is_integer(value) ? json_integer_value(value) : -1;
    if (i >= 0 && (size_t)i < length) {
        if (out_index) *out_index = (size_t)i;
        return json_array_get(json_object_get(gltf->root, list), (size_t)i);
    }
    rnd_import_fail(gltf->in, "%s: expected the index of one of %zu %s", where, length, list);
    return NULL;
}

/* --- what it asks for --- */

/* Known extensions, and what of each is not done; NULL: nothing, or it is named where it is read. */
static const char *const known[][2] = {
    {"EXT_lights_image_based", "its own environment (see --env)"},
    {"EXT_mesh_gpu_instancing", NULL},
    {"EXT_texture_webp", NULL},
    {"KHR_animation_pointer", "animated properties"},
    {"KHR_draco_mesh_compression", NULL},
    {"KHR_lights_punctual", NULL},
    {"KHR_materials_anisotropy", NULL},
    {"KHR_materials_clearcoat", NULL},
    {"KHR_materials_diffuse_transmission", NULL},
    {"KHR_materials_dispersion", NULL},
    {"KHR_materials_emissive_strength", NULL},
    {"KHR_materials_ior", NULL},
    {"KHR_materials_iridescence", NULL},
    {"KHR_materials_pbrSpecularGlossiness", NULL},
    {"KHR_materials_sheen", NULL},
    {"KHR_materials_specular", NULL},
    {"KHR_materials_transmission", NULL},
    {"KHR_materials_unlit", NULL},
    {"KHR_materials_variants", "variants (the default is shown)"},
    {"KHR_materials_volume", NULL},
    {"KHR_mesh_quantization", NULL},
    {"KHR_node_visibility", NULL},
    {"KHR_texture_basisu", "Basis textures"},
    {"KHR_texture_transform", NULL},
    {"KHR_xmp", NULL},
    {"KHR_xmp_json_ld", NULL},
    {"MSFT_lod", "levels of detail (the finest is shown)"},
};

static bool is_known(const char *name, const char **out_left_out)
{
    for (size_t i = 0; i < sizeof known / sizeof *known; i++)
        if (strcmp(name, known[i][0]) == 0) {
            *out_left_out = known[i][1];
            return true;
        }
    *out_left_out = name;
    return false;
}

void rnd_gltf_name_unsupported(struct rnd_gltf *gltf)
{
    struct rnd_scene *scene = gltf->in->scene;
    const json_t *used = json_object_get(gltf->root, "extensionsUsed"),
                 *required = json_object_get(gltf->root, "extensionsRequired");
    const char *left_out;
    if (rnd_gltf_length(gltf, "animations") > 0)
        rnd_scene_unsupported(scene, "animation (its first frame is shown)");
    if (rnd_gltf_length(gltf, "skins") > 0) rnd_scene_unsupported(scene, "skins");
    if (gltf->morphs) rnd_scene_unsupported(scene, "morph targets");
    for (size_t i = 0; i < json_array_size(required); i++) {
        const char *name = json_string_value(json_array_get(required, i));
        if (name && !is_known(name, &left_out))
            rnd_warn(&scene->warnings,
                     "%s: extensionsRequired[%zu]: %s is not known here: what it means is left out",
                     gltf->in->path, i, name);
    }
    for (size_t i = 0; i < json_array_size(used); i++) {
        const char *name = json_string_value(json_array_get(used, i));
        if (!name) continue;
        is_known(name, &left_out);
        if (left_out) rnd_scene_unsupported(scene, left_out);
    }
}

/* Refuse a file of another version, or with geometry that cannot be read. */
static bool check_asset(struct rnd_gltf *gltf)
{
    const json_t *asset = json_object_get(gltf->root, "asset"),
                 *required = json_object_get(gltf->root, "extensionsRequired");
    const char *version = json_string_value(json_object_get(asset, "version"));
    const char *least = json_string_value(json_object_get(asset, "minVersion"));
    if (version && strncmp(version, "2.", 2) != 0)
        return rnd_import_fail(gltf->in, "asset.version: is glTF %.20s, expected 2.0", version);
    if (!version && json_is_object(json_object_get(gltf->root, "nodes")))
        return rnd_import_fail(gltf->in, "asset.version: is glTF 1.0 as it seems, expected 2.0");
    if (!version) return rnd_import_fail(gltf->in, "asset.version: expected \"2.0\", and there is none");
    if (least && strcmp(least, "2.0") != 0)
        return rnd_import_fail(gltf->in, "asset.minVersion: is %.20s, and 2.0 is what can be read", least);
    for (size_t i = 0; i < json_array_size(required); i++) {
        const char *name = json_string_value(json_array_get(required, i));
        if (!name || !strstr(name, "_meshopt_compression")) continue;
        return rnd_import_fail(gltf->in,
                               "extensionsRequired[%zu]: %.40s cannot be read: export the file without "
                               "compression",
                               i, name);
    }
    return true;
}

bool rnd_gltf_open(struct rnd_gltf *gltf, struct rnd_import *in)
{
    *gltf = (struct rnd_gltf){.in = in};
    if (!load_json(gltf) || !check_asset(gltf)) return false;
    const size_t nodes = rnd_gltf_length(gltf, "nodes");
    gltf->buffer = calloc(rnd_gltf_length(gltf, "buffers") + 1, sizeof *gltf->buffer);
    gltf->mesh = calloc(rnd_gltf_length(gltf, "meshes") + 1, sizeof *gltf->mesh);
    gltf->image = calloc(rnd_gltf_length(gltf, "images") + 1, sizeof *gltf->image);
    gltf->pose = calloc(nodes + 1, sizeof *gltf->pose);
    gltf->moved = calloc(nodes + 1, sizeof *gltf->moved);
    gltf->visited = calloc(nodes + 1, sizeof *gltf->visited);
    return (gltf->buffer && gltf->mesh && gltf->image && gltf->pose && gltf->moved && gltf->visited) ||
           rnd_import_fail(in, "not enough memory");
}

void rnd_gltf_close(struct rnd_gltf *gltf)
{
    for (size_t i = 0; gltf->buffer && i < rnd_gltf_length(gltf, "buffers"); i++) free(gltf->buffer[i].bytes);
    json_decref(gltf->root);
    free(gltf->buffer);
    free(gltf->mesh);
    free(gltf->image);
    free(gltf->node_root);
    free(gltf->pose);
    free(gltf->moved);
    free(gltf->visited);
}
