/* The JSON of a glTF file: read, and checked for what assimp would choke on. */
#include "scene/gltf.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_JSON_BYTES = 256 << 20 };

static uint32_t little_endian(const uint8_t *b)
{
    return (uint32_t)b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}

bool rnd_gltf_fail(struct rnd_gltf *gltf, const char *what)
{
    snprintf(gltf->error, RND_ERROR_SIZE, "%.200s: %.250s", gltf->path, what);
    for (char *c = gltf->error; *c; c++)
        if ((unsigned char)*c < ' ') *c = ' '; /* names of the file may hold anything */
    return false;
}

/* The JSON of a .gltf file, or of the first chunk of a .glb one (12 bytes of header, then length, "JSON"). */
static json_t *load_json(struct rnd_gltf *gltf)
{
    const char *path = gltf->path;
    json_t *root = NULL;
    char *text = NULL;
    json_error_t why = {.text = "unreadable"};
    FILE *file = fopen(path, "rb");
    if (!file) goto end;
    uint8_t head[20];
    long length = 0;
    if (fread(head, 1, sizeof head, file) == sizeof head && memcmp(head, "glTF", 4) == 0) {
        length = little_endian(head + 12) <= MAX_JSON_BYTES ? (long)little_endian(head + 12) : 0;
        if (memcmp(head + 16, "JSON", 4) != 0 || little_endian(head + 4) != 2) length = 0;
        gltf->json_end = 20 + (size_t)length;
        if (fseek(file, 0, SEEK_END) != 0) goto end;
        gltf->file_size = (size_t)ftell(file);
        if (fseek(file, 20, SEEK_SET) != 0) goto end;
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
        snprintf(gltf->error, RND_ERROR_SIZE, "%.200s:%d: not readable as glTF JSON: %.100s", path,
                 why.line > 0 ? why.line : 1, why.text);
    return root;
}

const json_t *rnd_gltf_extension(const json_t *object, const char *name)
{
    return json_object_get(json_object_get(object, "extensions"), name);
}

const json_t *rnd_gltf_at(const struct rnd_gltf *gltf, const char *list, const json_t *index)
{
    const json_int_t i = json_is_integer(index) ? json_integer_value(index) : -1;
    return i < 0 ? NULL : json_array_get(json_object_get(gltf->root, list), (size_t)i);
}

/* The nodes of the scene that is shown. */
static const json_t *roots_of(const struct rnd_gltf *gltf)
{
    const json_t *first = json_object_get(gltf->root, "scene");
    const json_t *scene = json_is_integer(first) ? rnd_gltf_at(gltf, "scenes", first)
                                                 : json_array_get(json_object_get(gltf->root, "scenes"), 0);
    return json_object_get(scene, "nodes");
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

static bool check_nodes(struct rnd_gltf *gltf)
{
    const json_t *nodes = json_object_get(gltf->root, "nodes");
    const json_int_t count = (json_int_t)json_array_size(nodes);
    json_int_t *parents = malloc(((size_t)count + 1) * sizeof *parents), bad = 0;
    char what[100];
    if (!parents) return rnd_gltf_fail(gltf, "not enough memory");
    for (json_int_t i = 0; i < count; i++) parents[i] = -1;
    bool ok = adopt(roots_of(gltf), count, parents, count, &bad);
    for (json_int_t i = 0; ok && i < count; i++)
        ok = adopt(json_object_get(json_array_get(nodes, (size_t)i), "children"), i, parents, count, &bad);
    if (!ok) {
        snprintf(what, sizeof what, "node %" JSON_INTEGER_FORMAT " is not there or has two parents", bad);
        rnd_gltf_fail(gltf, what);
    }
    for (json_int_t i = 0; ok && i < count; i++) {
        int depth = 0;
        for (json_int_t k = i; k >= 0 && k < count && depth <= RND_NODE_DEPTH; k = parents[k]) depth++;
        if (depth <= RND_NODE_DEPTH) continue;
        snprintf(what, sizeof what, "nodes are nested more than %d deep", RND_NODE_DEPTH);
        ok = rnd_gltf_fail(gltf, what);
    }
    free(parents);
    return ok;
}

/* Without these the geometry is not what the file means: no part of it can be shown. */
static bool check_required(struct rnd_gltf *gltf)
{
    static const char *const geometry[] = {"KHR_mesh_quantization", "EXT_meshopt_compression",
                                           "KHR_meshopt_compression"};
    const json_t *required = json_object_get(gltf->root, "extensionsRequired");
    for (size_t i = 0; i < json_array_size(required); i++) {
        const char *name = json_string_value(json_array_get(required, i));
        for (size_t k = 0; name && k < sizeof geometry / sizeof *geometry; k++) {
            char what[100];
            if (strcmp(name, geometry[k]) != 0) continue;
            snprintf(what, sizeof what, "requires %s, which is not supported", geometry[k]);
            return rnd_gltf_fail(gltf, what);
        }
    }
    return true;
}

bool rnd_gltf_open(struct rnd_gltf *gltf, const char *path, char out_error[RND_ERROR_SIZE])
{
    *gltf = (struct rnd_gltf){.path = path, .error = out_error};
    const char *slash = strrchr(path, '/');
    if (slash && snprintf(gltf->directory, sizeof gltf->directory, "%.*s", (int)(slash - path + 1), path) >=
                     (int)sizeof gltf->directory)
        return rnd_gltf_fail(gltf, "the path is too long");
    gltf->root = load_json(gltf);
    if (gltf->root && check_nodes(gltf) && check_required(gltf) && rnd_gltf_first_frame(gltf)) return true;
    rnd_gltf_close(gltf);
    return false;
}

void rnd_gltf_close(struct rnd_gltf *gltf)
{
    json_decref(gltf->root);
    free(gltf->pose);
    free(gltf->moved);
    *gltf = (struct rnd_gltf){0};
}
