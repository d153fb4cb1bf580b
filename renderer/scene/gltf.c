/* What assimp drops of a glTF file, read from its JSON: emissive strength, specular factor, and what is asked
 * for that the renderer does not do.
 */
#include "scene/scene.h"

#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_JSON_BYTES = 256 << 20 };

static uint32_t little_endian(const uint8_t *b)
{
    return (uint32_t)b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}

/* The JSON of a .gltf file, or of the first chunk of a .glb one (12 bytes of header, then length, "JSON"). */
static json_t *load_json(const char *path, char out_error[RND_ERROR_SIZE])
{
    json_t *root = NULL;
    char *text = NULL;
    json_error_t why = {.text = "unreadable"};
    FILE *file = fopen(path, "rb");
    if (!file) goto end;
    uint8_t head[20];
    long length = 0;
    if (fread(head, 1, sizeof head, file) == sizeof head && memcmp(head, "glTF", 4) == 0) {
        length = little_endian(head + 12) <= MAX_JSON_BYTES ? (long)little_endian(head + 12) : 0;
    } else if (fseek(file, 0, SEEK_END) == 0) {
        length = ftell(file);
        rewind(file);
    }
    if (length <= 0 || length > MAX_JSON_BYTES || !(text = malloc((size_t)length))) goto end;
    if (fread(text, 1, (size_t)length, file) == (size_t)length)
        root = json_loadb(text, (size_t)length, 0, &why);
end:
    if (file) fclose(file);
    free(text);
    if (!root)
        snprintf(out_error, RND_ERROR_SIZE, "%.200s:%d: not readable as glTF JSON: %.100s", path,
                 why.line > 0 ? why.line : 1, why.text);
    return root;
}

static const json_t *extension(const json_t *object, const char *name)
{
    return json_object_get(json_object_get(object, "extensions"), name);
}

static float number(const json_t *object, const char *name, float otherwise)
{
    const json_t *value = json_object_get(object, name);
    return json_is_number(value) ? (float)json_number_value(value) : otherwise;
}

static void read_material(struct rnd_scene *scene, const json_t *json, struct rnd_material *material)
{
    /* By extension or property: what is asked for, and the name under which it is reported. */
    static const struct {
        const char *extension, *name;
    } missing[] = {
        {"KHR_materials_volume", "volume absorption"},
        {"KHR_materials_clearcoat", "clearcoat"},
        {"KHR_materials_sheen", "sheen"},
        {"KHR_materials_anisotropy", "anisotropy"},
        {"KHR_materials_iridescence", "iridescence"},
        {"KHR_materials_unlit", "unlit"},
        {"KHR_materials_pbrSpecularGlossiness", "specular-glossiness"},
        {"KHR_materials_variants", "variants"},
    };
    material->emission =
        glms_vec3_scale(material->emission,
                        number(extension(json, "KHR_materials_emissive_strength"), "emissiveStrength", 1.0f));
    material->specular = number(extension(json, "KHR_materials_specular"), "specularFactor", 1.0f);

    for (size_t i = 0; i < sizeof missing / sizeof *missing; i++)
        if (extension(json, missing[i].extension)) rnd_scene_unsupported(scene, missing[i].name);
    if (json_object_get(json, "normalTexture")) rnd_scene_unsupported(scene, "normal maps");
    const char *alpha = json_string_value(json_object_get(json, "alphaMode"));
    if (alpha && strcmp(alpha, "MASK") == 0) rnd_scene_unsupported(scene, "alpha mask");
    if (alpha && strcmp(alpha, "BLEND") == 0) rnd_scene_unsupported(scene, "alpha blending");
    if (extension(json_object_get(json_object_get(json, "pbrMetallicRoughness"), "baseColorTexture"),
                  "KHR_texture_transform"))
        rnd_scene_unsupported(scene, "texture transforms");
}

/* Make parent the parent of children[], or of the scene's roots if it is the number of nodes. False if one is
 * not there or has a parent already; *out_bad is which. */
static bool adopt(const json_t *children, json_int_t parent, json_int_t *parents, json_int_t nodes,
                  json_int_t *out_bad)
{
    for (size_t i = 0; i < json_array_size(children); i++) {
        const json_int_t child = *out_bad = json_integer_value(json_array_get(children, i));
        if (child < 0 || child >= nodes || parents[child] >= 0) return false;
        parents[child] = parent;
    }
    return true;
}

static bool check_nodes(const json_t *root, const char *path, char out_error[RND_ERROR_SIZE])
{
    const json_t *nodes = json_object_get(root, "nodes");
    const json_t *scene = json_array_get(json_object_get(root, "scenes"),
                                         (size_t)json_integer_value(json_object_get(root, "scene")));
    const json_int_t count = (json_int_t)json_array_size(nodes);
    json_int_t *parents = malloc(((size_t)count + 1) * sizeof *parents), bad = 0;
    if (!parents) {
        snprintf(out_error, RND_ERROR_SIZE, "%.200s: not enough memory", path);
        return false;
    }
    for (json_int_t i = 0; i < count; i++) parents[i] = -1;
    bool ok = adopt(json_object_get(scene, "nodes"), count, parents, count, &bad);
    for (json_int_t i = 0; ok && i < count; i++)
        ok = adopt(json_object_get(json_array_get(nodes, (size_t)i), "children"), i, parents, count, &bad);
    if (!ok)
        snprintf(out_error, RND_ERROR_SIZE,
                 "%.200s: node %" JSON_INTEGER_FORMAT " is not there or has two parents", path, bad);
    for (json_int_t i = 0; ok && i < count; i++) {
        int depth = 0;
        for (json_int_t k = i; k >= 0 && k < count && depth <= RND_NODE_DEPTH; k = parents[k]) depth++;
        if (depth <= RND_NODE_DEPTH) continue;
        snprintf(out_error, RND_ERROR_SIZE, "%.200s: nodes are nested more than %d deep", path,
                 RND_NODE_DEPTH);
        ok = false;
    }
    free(parents);
    return ok;
}

bool rnd_gltf_check(const char *path, char out_error[RND_ERROR_SIZE])
{
    json_t *root = load_json(path, out_error);
    const bool ok = root && check_nodes(root, path, out_error);
    json_decref(root);
    return ok;
}

/* --- which material is which ---
 *
 * assimp numbers materials in the order in which meshes first name them, children before parents, and leaves
 * out those that nothing names; their names need not be there, nor differ. */

struct order {
    size_t *material; /* indices in the file */
    size_t count, size;
};

static void visit_mesh(struct order *order, const json_t *mesh)
{
    const json_t *primitives = json_object_get(mesh, "primitives");
    for (size_t p = 0; p < json_array_size(primitives); p++) {
        const json_t *index = json_object_get(json_array_get(primitives, p), "material");
        const json_int_t m = json_is_integer(index) ? json_integer_value(index) : -1;
        if (m < 0 || (size_t)m >= order->size) continue;
        bool seen = false;
        for (size_t i = 0; i < order->count && !seen; i++) seen = order->material[i] == (size_t)m;
        if (!seen) order->material[order->count++] = (size_t)m;
    }
}

static const json_t *indexed(const json_t *root, const char *list, const json_t *index)
{
    const json_int_t i = json_is_integer(index) ? json_integer_value(index) : -1;
    return i < 0 ? NULL : json_array_get(json_object_get(root, list), (size_t)i);
}

static void visit_nodes(struct order *order, const json_t *root, const json_t *nodes, int depth)
{
    if (depth > RND_NODE_DEPTH) return;
    for (size_t i = 0; i < json_array_size(nodes); i++) {
        const json_t *node = indexed(root, "nodes", json_array_get(nodes, i));
        visit_nodes(order, root, json_object_get(node, "children"), depth + 1);
        visit_mesh(order, indexed(root, "meshes", json_object_get(node, "mesh")));
    }
}

static bool same_name(const json_t *material, const char *name)
{
    const char *own = json_string_value(json_object_get(material, "name"));
    return strcmp(own ? own : "", name) == 0;
}

/* The file's material that assimp made into its i-th, or NULL (its default material). */
static const json_t *material_of(const json_t *materials, const struct order *order, size_t i,
                                 const char *name)
{
    if (i < order->count) {
        const json_t *material = json_array_get(materials, order->material[i]);
        if (same_name(material, name)) return material;
    }
    for (size_t k = 0; k < json_array_size(materials); k++)
        if (*name && same_name(json_array_get(materials, k), name)) return json_array_get(materials, k);
    return NULL;
}

static bool read_materials(struct rnd_scene *scene, const json_t *root,
                           const char *(*name)(const void *, uint32_t), const void *names)
{
    const json_t *materials = json_object_get(root, "materials");
    const json_t *first = json_object_get(root, "scene");
    const json_t *start =
        first ? indexed(root, "scenes", first) : json_array_get(json_object_get(root, "scenes"), 0);
    struct order order = {.size = json_array_size(materials)};
    if (!(order.material = malloc((order.size + 1) * sizeof *order.material))) return false;
    visit_nodes(&order, root, json_object_get(start, "nodes"), 0);
    for (uint32_t i = 0; i < scene->material_count; i++) {
        const json_t *material = material_of(materials, &order, i, name(names, i));
        if (material) read_material(scene, material, &scene->material[i]);
    }
    free(order.material);
    return true;
}

bool rnd_import_gltf_extras(struct rnd_scene *scene, const char *path,
                            const char *(*name)(const void *, uint32_t), const void *names,
                            char out_error[RND_ERROR_SIZE])
{
    const char *dot = strrchr(path, '.');
    if (!dot || (strcasecmp(dot, ".gltf") != 0 && strcasecmp(dot, ".glb") != 0)) return true;
    json_t *root = load_json(path, out_error);
    if (!root) return false;

    const bool ok = read_materials(scene, root, name, names);
    if (!ok) snprintf(out_error, RND_ERROR_SIZE, "%.200s: not enough memory", path);
    if (json_array_size(json_object_get(root, "animations")) > 0) rnd_scene_unsupported(scene, "animations");
    if (json_array_size(json_object_get(root, "skins")) > 0) rnd_scene_unsupported(scene, "skins");
    const json_t *used = json_object_get(root, "extensionsUsed");
    for (size_t i = 0; i < json_array_size(used); i++) {
        const char *extension_name = json_string_value(json_array_get(used, i));
        if (extension_name && strcmp(extension_name, "EXT_mesh_gpu_instancing") == 0)
            rnd_scene_unsupported(scene, "GPU instancing");
    }
    json_decref(root);
    return ok;
}
