/* The bytes behind a glTF file's JSON: buffers in files, in the GLB and in data URIs, and the views into
 * them. A buffer is read when it is first asked for.
 */
#include "import/gltf_bytes.h"
#include "import/find_file.h"
#include "import/gltf_json.h"
#include "import/open_file.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* --- data URIs --- */

static int base64_digit(char c)
{
    if (c >= 'A' && c <= 'Z') return c - 'A';
    if (c >= 'a' && c <= 'z') return c - 'a' + 26;
    if (c >= '0' && c <= '9') return c - '0' + 52;
    return c == '+' || c == '-' ? 62 : c == '/' || c == '_' ? 63 : -1;
}

uint8_t *rnd_gltf_data_uri(const char *uri, size_t *out_count)
{
    const char *comma = strchr(uri, ',');
    if (strncmp(uri, "data:", 5) != 0 || !comma || comma - uri < 7 || memcmp(comma - 7, ";base64", 7) != 0)
        return NULL;
    const char *text = comma + 1;
    size_t digits = strlen(text), n = 0;
    while (digits > 0 && text[digits - 1] == '=') digits--;
    uint8_t *bytes = malloc(digits / 4 * 3 + 4);
    uint32_t bits = 0;
    for (size_t i = 0; bytes && i < digits; i++) {
        const int digit = base64_digit(text[i]);
        if (digit < 0) {
            free(bytes);
            return NULL;
        }
        bits = bits << 6 | (uint32_t)digit;
        if (i % 4 > 0) bytes[n++] = (uint8_t)(bits >> (6 - 2 * (i % 4)));
    }
    *out_count = n;
    return bytes;
}

/* --- buffers --- */

bool rnd_gltf_ask(struct rnd_gltf *gltf, size_t numbers, const char *where)
{
    enum { TIMES = 64, LEAST = 100000000 };
    const uint64_t asked = gltf->asked + numbers;
    if (asked > TIMES * gltf->bytes + LEAST)
        return rnd_import_fail(
            gltf->in, "%s: the file asks for the same numbers over and over: %llu, and it has %llu bytes",
            where, (unsigned long long)asked, (unsigned long long)gltf->bytes);
    gltf->asked = asked;
    return true;
}

/* Read size bytes of a file from start on. NULL if there are fewer; *out_there says how many. */
static uint8_t *read_file(const char *path, size_t start, size_t size, size_t *out_there)
{
    const char *why;
    FILE *file = rnd_open_file(path, &why);
    struct stat status;
    uint8_t *bytes = NULL;
    *out_there = 0;
    if (file && fstat(fileno(file), &status) == 0 && (size_t)status.st_size >= start) {
        *out_there = (size_t)status.st_size - start;
        if (*out_there >= size && fseek(file, (long)start, SEEK_SET) == 0 && (bytes = malloc(size + 1)) &&
            fread(bytes, 1, size, file) != size) {
            free(bytes);
            bytes = NULL;
        }
    }
    if (file) fclose(file);
    return bytes;
}

/* Read the bytes of a buffer's URI. NULL and a line. */
static uint8_t *read_uri(struct rnd_gltf *gltf, const char *uri, size_t size, const char *where)
{
    char path[RND_PATH_SIZE];
    size_t there = 0;
    uint8_t *bytes = NULL;
    if (strncmp(uri, "data:", 5) == 0) {
        if (!(bytes = rnd_gltf_data_uri(uri, &there))) {
            rnd_import_fail(gltf->in, "%s.uri: expected a data URI of base64", where);
        } else if (there < size) {
            rnd_import_fail(gltf->in, "%s.byteLength: %zu, but its URI holds %zu bytes", where, size, there);
            free(bytes);
            bytes = NULL;
        }
        return bytes;
    }
    const bool found = rnd_find_file(gltf->in->directory, uri, true, path);
    rnd_files_add(&gltf->in->scene->files, path);
    if (!found)
        rnd_import_fail(gltf->in, "%s.uri: %.120s: %s", where, path, rnd_why_not_found(path));
    else if (!(bytes = read_file(path, 0, size, &there)))
        rnd_import_fail(gltf->in, "%s.byteLength: %zu, but %.120s holds %zu bytes", where, size, path, there);
    return bytes;
}

static const struct rnd_gltf_buffer *read_buffer(struct rnd_gltf *gltf, const json_t *index, const char *from)
{
    size_t i, size;
    char where[RND_WHERE_SIZE];
    const json_t *json = rnd_gltf_at(gltf, "buffers", index, from, &i);
    if (!json) return NULL;
    struct rnd_gltf_buffer *buffer = &gltf->buffer[i];
    if (buffer->bytes) return buffer;
    const char *uri = json_string_value(json_object_get(json, "uri"));
    snprintf(where, sizeof where, "buffers[%zu]", i);
    if (!rnd_gltf_size(gltf, json, "byteLength", SIZE_MAX, (size_t)1 << 40, where, &size)) return NULL;
    if (uri) {
        buffer->bytes = read_uri(gltf, uri, size, where);
    } else if (i == 0 && gltf->bin_start > 0 && size <= gltf->bin_size) {
        size_t there;
        buffer->bytes = read_file(gltf->in->path, gltf->bin_start, size, &there);
        if (!buffer->bytes) rnd_import_fail(gltf->in, "%s: its bytes cannot be read", where);
    } else if (i == 0 && gltf->bin_start > 0) {
        rnd_import_fail(gltf->in, "%s.byteLength: %zu, but the file's chunk holds %zu bytes", where, size,
                        gltf->bin_size);
    } else {
        rnd_import_fail(gltf->in, "%s.uri: expected one, since there is no chunk for it in the file", where);
    }
    if (!buffer->bytes) return NULL;
    buffer->size = size;
    gltf->bytes += size;
    gltf->in->most += RND_TRIANGLES_A_BYTE * size;
    return buffer;
}

/* --- views --- */

const uint8_t *rnd_gltf_view(struct rnd_gltf *gltf, const json_t *index, const char *from, size_t *out_size,
                             size_t *out_stride)
{
    size_t i, offset;
    char where[RND_WHERE_SIZE], inside[RND_WHERE_SIZE + 16];
    const json_t *view = rnd_gltf_at(gltf, "bufferViews", index, from, &i);
    if (!view) return NULL;
    snprintf(where, sizeof where, "bufferViews[%zu]", i);
    snprintf(inside, sizeof inside, "%s.buffer", where);
    const struct rnd_gltf_buffer *buffer = read_buffer(gltf, json_object_get(view, "buffer"), inside);
    if (!buffer || !rnd_gltf_size(gltf, view, "byteOffset", 0, (size_t)1 << 40, where, &offset) ||
        !rnd_gltf_size(gltf, view, "byteLength", SIZE_MAX, (size_t)1 << 40, where, out_size) ||
        !rnd_gltf_size(gltf, view, "byteStride", 0, 252, where, out_stride))
        return NULL;
    if (offset + *out_size <= buffer->size) return buffer->bytes + offset;
    rnd_import_fail(gltf->in, "%s: %zu bytes from %zu on, but its buffer has %zu", where, *out_size, offset,
                    buffer->size);
    return NULL;
}
