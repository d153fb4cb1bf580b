/* A glTF file as assimp gets to see it: its geometry and nodes, and materials that are numbers.
 *
 * assimp 5.2.5 aborts on JSON whose types are wrong in places that it is not needed for (materials, textures,
 * animations), renumbers materials, and leaves a light or camera at the last of the nodes that it is at. So
 * it is given a copy of the JSON without those, through its file callbacks; all other bytes come from the
 * files as they are.
 */
#include "scene/gltf.h"

#include <assimp/cfileio.h>
#include <assimp/cimport.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* --- the JSON --- */

/* A new object with those of the keys that are there. */
static json_t *pick(const json_t *from, const char *const *keys)
{
    json_t *to = json_object();
    for (; *keys; keys++)
        if (json_object_get(from, *keys)) json_object_set(to, *keys, json_object_get(from, *keys));
    return to;
}

static void keep_extension(json_t *to, const json_t *from, const char *name)
{
    const json_t *extension = rnd_gltf_extension(from, name);
    if (extension) json_object_set_new(to, "extensions", json_pack("{s:O}", name, extension));
}

/* What has its place in a list for a name. */
static void name_by_place(json_t *to, size_t place)
{
    char name[24];
    snprintf(name, sizeof name, "%zu", place);
    json_object_set_new(to, "name", json_string(name));
}

static json_t *slim_nodes(const json_t *nodes)
{
    static const char *const keys[] = {"children", "mesh",  "matrix", "translation",
                                       "rotation", "scale", NULL};
    json_t *list = json_array();
    for (size_t i = 0; i < json_array_size(nodes); i++) {
        json_t *to = pick(json_array_get(nodes, i), keys);
        name_by_place(to, i);
        json_array_append_new(list, to);
    }
    return list;
}

static json_t *slim_meshes(const json_t *meshes)
{
    static const char *const mesh_keys[] = {"name", NULL}, *const keys[] = {"attributes", "indices",
                                                                            "material", "mode", NULL};
    json_t *list = json_array();
    for (size_t i = 0; i < json_array_size(meshes); i++) {
        const json_t *mesh = json_array_get(meshes, i), *from = json_object_get(mesh, "primitives");
        json_t *to = pick(mesh, mesh_keys), *primitives = json_array();
        for (size_t k = 0; k < json_array_size(from); k++) {
            json_t *primitive = pick(json_array_get(from, k), keys);
            keep_extension(primitive, json_array_get(from, k), "KHR_draco_mesh_compression");
            json_array_append_new(primitives, primitive);
        }
        json_object_set_new(to, "primitives", primitives);
        json_array_append_new(list, to);
    }
    return list;
}

/* Materials of which only that is left: rnd_gltf_materials() knows them by it. */
static json_t *numbered(size_t count)
{
    json_t *list = json_array();
    for (size_t i = 0; i < count; i++) {
        json_t *to = json_object();
        name_by_place(to, i);
        json_array_append_new(list, to);
    }
    return list;
}

/* The text that assimp gets, padded to a multiple of four bytes. The caller frees. */
static char *slim_text(const json_t *root, size_t *out_length)
{
    static const char *const keys[] = {"asset",       "scene",   "scenes", "accessors",
                                       "bufferViews", "buffers", NULL};
    json_t *slim = pick(root, keys);
    json_object_set_new(slim, "nodes", slim_nodes(json_object_get(root, "nodes")));
    json_object_set_new(slim, "meshes", slim_meshes(json_object_get(root, "meshes")));
    json_object_set_new(slim, "materials", numbered(json_array_size(json_object_get(root, "materials"))));
    json_object_set_new(slim, "extensionsUsed", json_pack("[s]", "KHR_draco_mesh_compression"));
    char *text = json_dumps(slim, JSON_COMPACT);
    json_decref(slim);
    if (!text) return NULL;
    const size_t length = strlen(text), padded = (length + 3) & ~(size_t)3;
    char *grown = realloc(text, padded + 1);
    if (!grown) {
        free(text);
        return NULL;
    }
    memset(grown + length, ' ', padded - length);
    grown[padded] = 0;
    *out_length = padded;
    return grown;
}

/* --- files --- */

/* What assimp opens: bytes in memory, then those of a file from some place on. */
struct source {
    const char *head; /* struct view's */
    size_t head_size, tail_start, tail_size, at;
    FILE *tail; /* or NULL: there are none */
};

/* The file under its own name, but for the JSON. */
struct view {
    const char *path;
    char *head;
    size_t head_size, tail_start; /* 0: the head is all */
};

static size_t source_size(struct aiFile *file)
{
    const struct source *s = (const struct source *)file->UserData;
    return s->head_size + s->tail_size;
}

static size_t source_tell(struct aiFile *file)
{
    return ((const struct source *)file->UserData)->at;
}

static enum aiReturn source_seek(struct aiFile *file, size_t offset, enum aiOrigin origin)
{
    struct source *s = (struct source *)file->UserData;
    const size_t base = origin == aiOrigin_CUR ? s->at : origin == aiOrigin_END ? source_size(file) : 0;
    if (offset > source_size(file) - base) return aiReturn_FAILURE;
    s->at = base + offset;
    return aiReturn_SUCCESS;
}

static size_t source_read(struct aiFile *file, char *out, size_t size, size_t count)
{
    struct source *s = (struct source *)file->UserData;
    const size_t left = source_size(file) - s->at;
    if (size == 0) return 0;
    if (count > left / size) count = left / size;
    size_t bytes = size * count;
    if (s->at < s->head_size) {
        const size_t n = bytes < s->head_size - s->at ? bytes : s->head_size - s->at;
        memcpy(out, s->head + s->at, n);
        out += n;
        s->at += n;
        bytes -= n;
    }
    if (bytes == 0) return count;
    if (fseek(s->tail, (long)(s->tail_start + s->at - s->head_size), SEEK_SET) != 0) return 0;
    const size_t n = fread(out, 1, bytes, s->tail);
    s->at += n;
    return n == bytes ? count : 0;
}

static size_t no_write(struct aiFile *file, const char *bytes, size_t size, size_t count)
{
    (void)file, (void)bytes, (void)size, (void)count;
    return 0;
}

static void no_flush(struct aiFile *file)
{
    (void)file;
}

static void close_source(struct aiFileIO *io, struct aiFile *file)
{
    (void)io;
    if (!file) return;
    struct source *s = (struct source *)file->UserData;
    if (s->tail) fclose(s->tail);
    free(s);
    free(file);
}

static struct aiFile *open_source(struct aiFileIO *io, const char *path, const char *mode)
{
    const struct view *view = (const struct view *)io->UserData;
    const bool own = strcmp(path, view->path) == 0;
    struct aiFile *file = malloc(sizeof *file);
    struct source *s = calloc(1, sizeof *s);
    (void)mode;
    if (!file || !s) goto fail;
    *file = (struct aiFile){source_read, no_write, source_tell,  source_size,
                            source_seek, no_flush, (aiUserData)s};
    if (own) {
        s->head = view->head;
        s->head_size = view->head_size;
        s->tail_start = view->tail_start;
    }
    if (own && view->tail_start == 0) return file;
    if (!(s->tail = fopen(path, "rb"))) goto fail;
    const long end = fseek(s->tail, 0, SEEK_END) == 0 ? ftell(s->tail) : -1;
    if (end < 0 || end == LONG_MAX) goto fail; /* a pipe, a directory */
    s->tail_size = (size_t)end > s->tail_start ? (size_t)end - s->tail_start : 0;
    return file;
fail:
    if (s && s->tail) fclose(s->tail);
    free(s);
    free(file);
    return NULL;
}

/* --- both --- */

static void put_little_endian(char *to, size_t value)
{
    for (int i = 0; i < 4; i++) to[i] = (char)(value >> 8 * i & 255);
}

/* For a GLB, put its header and that of its first chunk before the text, and the rest of the file after it.
 */
static bool wrap_glb(struct view *view, size_t json_end, size_t file_size)
{
    char *whole = malloc(view->head_size + 20);
    if (!whole) return false;
    const size_t rest = file_size > json_end ? file_size - json_end : 0;
    memcpy(whole, "glTF\2\0\0\0", 8);
    put_little_endian(whole + 8, 20 + view->head_size + rest);
    put_little_endian(whole + 12, view->head_size);
    memcpy(whole + 16, "JSON", 4);
    memcpy(whole + 20, view->head, view->head_size);
    free(view->head);
    view->head = whole;
    view->head_size += 20;
    view->tail_start = json_end;
    return true;
}

const struct aiScene *rnd_gltf_import(struct rnd_gltf *gltf, unsigned flags)
{
    struct view view = {.path = gltf->path};
    const struct aiScene *scene = NULL;
    view.head = slim_text(gltf->root, &view.head_size);
    if (view.head && (gltf->json_end == 0 || wrap_glb(&view, gltf->json_end, gltf->file_size))) {
        struct aiFileIO io = {open_source, close_source, (aiUserData)&view};
        scene = aiImportFileEx(gltf->path, flags, &io);
    }
    free(view.head);
    return scene;
}
