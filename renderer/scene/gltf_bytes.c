/* The bytes behind a glTF file's JSON: buffers in files, in the GLB and in data URIs, the views into them,
 * and the numbers that accessors say are there. Only what is asked for is read.
 */
#include "scene/gltf.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

void rnd_gltf_decode_percent(char *text)
{
    char *to = text;
    for (const char *from = text; *from; to++) {
        unsigned byte;
        if (*from == '%' && isxdigit((unsigned char)from[1]) && isxdigit((unsigned char)from[2]) &&
            sscanf(from + 1, "%2x", &byte) == 1 && byte != 0) {
            *to = (char)byte;
            from += 3;
        } else {
            *to = *from++;
        }
    }
    *to = 0;
}

/* --- data URIs --- */

static int base64_digit(char c)
{
    if (c >= 'A' && c <= 'Z') return c - 'A';
    if (c >= 'a' && c <= 'z') return c - 'a' + 26;
    if (c >= '0' && c <= '9') return c - '0' + 52;
    return c == '+' || c == '-' ? 62 : c == '/' || c == '_' ? 63 : -1;
}

/* Bytes offset .. offset + count of what the base64 text stands for; false where it ends before. */
static bool decode_base64(const char *text, size_t offset, size_t count, uint8_t *out)
{
    const size_t digits = strlen(text);
    for (size_t i = 0; i < count; i++) {
        const size_t bit = 8 * (offset + i), d = bit / 6;
        if (d + 1 >= digits) return false;
        const int high = base64_digit(text[d]), low = base64_digit(text[d + 1]);
        if (high < 0 || low < 0) return false;
        out[i] = (uint8_t)((high << 6 | low) >> (4 - bit % 6));
    }
    return true;
}

static const char *base64_of(const char *uri)
{
    const char *comma = strchr(uri, ',');
    if (strncmp(uri, "data:", 5) != 0 || !comma || comma - uri < 7 || memcmp(comma - 7, ";base64", 7) != 0)
        return NULL;
    return comma + 1;
}

uint8_t *rnd_gltf_data_uri(const char *uri, size_t *out_count)
{
    const char *text = base64_of(uri);
    if (!text) return NULL;
    size_t digits = strlen(text);
    while (digits > 0 && text[digits - 1] == '=') digits--;
    *out_count = digits / 4 * 3 + (digits % 4 > 0 ? digits % 4 - 1 : 0);
    uint8_t *bytes = malloc(*out_count + 1);
    if (bytes && decode_base64(text, 0, *out_count, bytes)) return bytes;
    free(bytes);
    return NULL;
}

/* --- buffers --- */

static FILE *open_uri(const struct rnd_gltf *gltf, const char *uri)
{
    char path[4096];
    if (snprintf(path, sizeof path, "%s%s", uri[0] == '/' ? "" : gltf->directory, uri) >= (int)sizeof path)
        return NULL;
    if (access(path, F_OK) != 0) rnd_gltf_decode_percent(path + strlen(path) - strlen(uri));
    return fopen(path, "rb");
}

/* Where the bytes of a GLB's second chunk begin, or 0: the header's 12 bytes, then chunks of length and kind.
 */
static size_t glb_start(FILE *file)
{
    uint8_t head[20];
    if (fread(head, 1, sizeof head, file) != sizeof head || memcmp(head, "glTF", 4) != 0) return 0;
    return 28 + ((size_t)head[12] | (size_t)head[13] << 8 | (size_t)head[14] << 16 | (size_t)head[15] << 24);
}

/* count bytes from offset of a buffer, count no more than there are. The caller frees. */
static uint8_t *read_buffer(struct rnd_gltf *gltf, const json_t *buffer, size_t offset, size_t count)
{
    const char *uri = json_string_value(json_object_get(buffer, "uri"));
    const char *text = uri ? base64_of(uri) : NULL;
    uint8_t *bytes = NULL;
    if (text) {
        const size_t all = strlen(text) / 4 * 3 + 3;
        if (count <= all && offset <= all - count && (bytes = malloc(count + 1)) &&
            !decode_base64(text, offset, count, bytes)) {
            free(bytes);
            bytes = NULL;
        }
    } else if (buffer) {
        FILE *file = uri ? open_uri(gltf, uri) : fopen(gltf->path, "rb");
        if (!file) goto end;
        const size_t start = uri ? 0 : glb_start(file);
        const long end = fseek(file, 0, SEEK_END) == 0 ? ftell(file) : -1;
        if ((uri || start > 0) && end >= 0 && start <= (size_t)end && count <= (size_t)end - start &&
            offset <= (size_t)end - start - count && fseek(file, (long)(start + offset), SEEK_SET) == 0 &&
            (bytes = malloc(count + 1)) && fread(bytes, 1, count, file) != count) {
            free(bytes);
            bytes = NULL;
        }
        fclose(file);
    }
end:
    if (!bytes) rnd_gltf_fail(gltf, "a buffer is not there or shorter than what is looked for in it");
    return bytes;
}

/* A count, size or offset; SIZE_MAX if it is not one. */
static size_t size_of(const json_t *object, const char *key, size_t otherwise)
{
    const json_t *value = json_object_get(object, key);
    if (!value) return otherwise;
    if (!json_is_integer(value) || json_integer_value(value) < 0 || json_integer_value(value) > UINT32_MAX)
        return SIZE_MAX;
    return (size_t)json_integer_value(value);
}

uint8_t *rnd_gltf_view(struct rnd_gltf *gltf, const json_t *index, size_t *out_count)
{
    const json_t *view = rnd_gltf_at(gltf, "bufferViews", index);
    const size_t offset = size_of(view, "byteOffset", 0), count = size_of(view, "byteLength", SIZE_MAX);
    if (offset == SIZE_MAX || count == SIZE_MAX) {
        rnd_gltf_fail(gltf, "a buffer view is not there or has no length");
        return NULL;
    }
    *out_count = count;
    return read_buffer(gltf, rnd_gltf_at(gltf, "buffers", json_object_get(view, "buffer")), offset, count);
}

/* --- accessors --- */

enum { BYTE = 5120, UNSIGNED_BYTE, SHORT, UNSIGNED_SHORT, FLOAT = 5126 };

/* A number as a float, integers normalised as glTF 2.0 section 3.6.2.2 says. */
static float element(const uint8_t *from, size_t component)
{
    union {
        int8_t i8;
        int16_t i16;
        uint16_t u16;
        float f;
    } value;
    memcpy(&value, from, component == FLOAT ? 4 : component >= SHORT ? 2 : 1);
    switch (component) {
    case BYTE:
        return fmaxf(value.i8 / 127.0f, -1.0f);
    case UNSIGNED_BYTE:
        return from[0] / 255.0f;
    case SHORT:
        return fmaxf(value.i16 / 32767.0f, -1.0f);
    case UNSIGNED_SHORT:
        return value.u16 / 65535.0f;
    default:
        return value.f;
    }
}

size_t rnd_gltf_count(const struct rnd_gltf *gltf, const json_t *accessor)
{
    const size_t count = size_of(rnd_gltf_at(gltf, "accessors", accessor), "count", 0);
    return count == SIZE_MAX ? 0 : count;
}

bool rnd_gltf_floats(struct rnd_gltf *gltf, const json_t *index, size_t first, size_t count, int n,
                     float *out)
{
    static const char *const types[] = {NULL, "SCALAR", "VEC2", "VEC3", "VEC4"};
    const json_t *accessor = rnd_gltf_at(gltf, "accessors", index);
    const json_t *view = rnd_gltf_at(gltf, "bufferViews", json_object_get(accessor, "bufferView"));
    const char *type = json_string_value(json_object_get(accessor, "type"));
    const size_t component = size_of(accessor, "componentType", 0);
    const bool normalised = json_is_true(json_object_get(accessor, "normalized"));
    if (!view || !type || strcmp(type, types[n]) != 0 || json_object_get(accessor, "sparse") ||
        !(component == FLOAT || (normalised && component >= BYTE && component <= UNSIGNED_SHORT)) ||
        first + count > rnd_gltf_count(gltf, index))
        return rnd_gltf_fail(gltf, "an accessor of an animation or of instances is not of their kind");
    if (count == 0) return true;

    const size_t size = component == FLOAT ? 4 : component >= SHORT ? 2 : 1, packed = size * (size_t)n;
    const size_t stride = size_of(view, "byteStride", packed), base = size_of(view, "byteOffset", 0),
                 offset = size_of(accessor, "byteOffset", 0), length = size_of(view, "byteLength", SIZE_MAX);
    if (stride < packed || stride > 252 || base == SIZE_MAX || offset == SIZE_MAX || length == SIZE_MAX ||
        offset + (first + count - 1) * stride + packed > length)
        return rnd_gltf_fail(gltf, "an accessor goes beyond its buffer view");
    uint8_t *bytes = read_buffer(gltf, rnd_gltf_at(gltf, "buffers", json_object_get(view, "buffer")),
                                 base + offset + first * stride, (count - 1) * stride + packed);
    if (!bytes) return false;
    bool finite = true;
    for (size_t i = 0; i < count; i++)
        for (int k = 0; k < n; k++) {
            out[i * (size_t)n + (size_t)k] = element(bytes + i * stride + (size_t)k * size, component);
            finite = finite && isfinite(out[i * (size_t)n + (size_t)k]);
        }
    free(bytes);
    return finite || rnd_gltf_fail(gltf, "a number of an animation or of instances is not finite");
}
