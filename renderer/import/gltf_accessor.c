/* Numbers in a glTF file's buffers: every component type, normalised or not, at any stride, dense or sparse.
 */
#include "import/gltf_accessor.h"
#include "import/gltf_bytes.h"
#include "import/gltf_json.h"

#include <stdio.h>
#include <string.h>

/* Most elements of an accessor without a buffer view, whose count no bytes of the file bound. */
enum { MAX_ZEROS = 1 << 20 };

/* Bytes of a component; 0 if there is no such type. */
static size_t size_of(size_t component)
{
    switch (component) {
    case RND_GLTF_BYTE:
    case RND_GLTF_UNSIGNED_BYTE:
        return 1;
    case RND_GLTF_SHORT:
    case RND_GLTF_UNSIGNED_SHORT:
        return 2;
    case RND_GLTF_UNSIGNED_INT:
    case RND_GLTF_FLOAT:
        return 4;
    default:
        return 0;
    }
}

/* --- one number --- */

static uint32_t integer_at(const uint8_t *from, size_t component)
{
    uint16_t u16;
    uint32_t u32;
    if (component == RND_GLTF_UNSIGNED_BYTE) return *from;
    if (component == RND_GLTF_UNSIGNED_SHORT) return memcpy(&u16, from, 2), u16;
    return memcpy(&u32, from, 4), u32;
}

static float float_at(const uint8_t *from, size_t component, bool normalised)
{
    int16_t i16;
    float f;
    switch (component) {
    case RND_GLTF_BYTE:
        return normalised ? fmaxf((float)(int8_t)*from / 127.0f, -1.0f) : (float)(int8_t)*from;
    case RND_GLTF_UNSIGNED_BYTE:
        return (float)*from / (normalised ? 255.0f : 1.0f);
    case RND_GLTF_SHORT:
        memcpy(&i16, from, 2);
        return normalised ? fmaxf((float)i16 / 32767.0f, -1.0f) : (float)i16;
    case RND_GLTF_FLOAT:
        return memcpy(&f, from, 4), f;
    case RND_GLTF_UNSIGNED_SHORT:
        return (float)integer_at(from, component) / (normalised ? 65535.0f : 1.0f);
    default:
        return normalised ? (float)(integer_at(from, component) / 4294967295.0)
                          : (float)integer_at(from, component);
    }
}

/* --- what is elsewhere --- */

static uint32_t sparse_at(const struct rnd_gltf_accessor *a, size_t i)
{
    return integer_at(a->sparse_index + i * size_of(a->sparse_component), a->sparse_component);
}

static bool open_sparse(struct rnd_gltf *gltf, const json_t *json, const char *accessor,
                        struct rnd_gltf_accessor *a)
{
    const json_t *indices = json_object_get(json, "indices"), *values = json_object_get(json, "values");
    char where[RND_WHERE_SIZE], part[2][RND_WHERE_SIZE + 32], view[2][RND_WHERE_SIZE + 64];
    size_t size[2], stride, offset[2], packed = a->n * size_of(a->component);
    snprintf(where, sizeof where, "%.100s.sparse", accessor);
    for (int i = 0; i < 2; i++) {
        snprintf(part[i], sizeof part[i], "%s.%s", where, i ? "values" : "indices");
        snprintf(view[i], sizeof view[i], "%s.bufferView", part[i]);
    }
    if (!rnd_gltf_size(gltf, json, "count", SIZE_MAX, a->count, where, &a->sparse) ||
        !rnd_gltf_size(gltf, indices, "componentType", SIZE_MAX, RND_GLTF_FLOAT, part[0],
                       &a->sparse_component) ||
        !rnd_gltf_size(gltf, indices, "byteOffset", 0, (size_t)1 << 40, part[0], &offset[0]) ||
        !rnd_gltf_size(gltf, values, "byteOffset", 0, (size_t)1 << 40, part[1], &offset[1]))
        return false;
    if (a->sparse_component != RND_GLTF_UNSIGNED_BYTE && a->sparse_component != RND_GLTF_UNSIGNED_SHORT &&
        a->sparse_component != RND_GLTF_UNSIGNED_INT)
        return rnd_import_fail(gltf->in, "%s.componentType: expected 5121, 5123 or 5125", part[0]);
    if (!(a->sparse_index =
              rnd_gltf_view(gltf, json_object_get(indices, "bufferView"), view[0], &size[0], &stride)) ||
        !(a->sparse_value =
              rnd_gltf_view(gltf, json_object_get(values, "bufferView"), view[1], &size[1], &stride)))
        return false;
    if (offset[0] + a->sparse * size_of(a->sparse_component) > size[0] ||
        offset[1] + a->sparse * packed > size[1])
        return rnd_import_fail(gltf->in, "%s.count: %zu, beyond the end of a buffer view", where, a->sparse);
    if (!rnd_gltf_ask(gltf, a->sparse, where)) return false;
    a->sparse_index += offset[0];
    a->sparse_value += offset[1];
    for (size_t i = 0; i < a->sparse; i++)
        if (sparse_at(a, i) >= a->count || (i > 0 && sparse_at(a, i) <= sparse_at(a, i - 1)))
            return rnd_import_fail(gltf->in, "%s: number %zu is %u: expected rising ones below %zu", part[0],
                                   i, sparse_at(a, i), a->count);
    return true;
}

/* The first sparse element at i or after it. */
static size_t first_sparse(const struct rnd_gltf_accessor *a, size_t i)
{
    size_t low = 0, high = a->sparse;
    while (low < high) {
        const size_t middle = (low + high) / 2;
        if (sparse_at(a, middle) < i)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

/* --- all --- */

bool rnd_gltf_accessor(struct rnd_gltf *gltf, const json_t *index, const char *from,
                       struct rnd_gltf_accessor *out)
{
    static const char *const types[] = {"SCALAR", "VEC2", "VEC3", "VEC4"};
    char where[RND_WHERE_SIZE], inside[RND_WHERE_SIZE + 16];
    size_t i, offset, size;
    const json_t *json = rnd_gltf_at(gltf, "accessors", index, from, &i);
    *out = (struct rnd_gltf_accessor){0};
    if (!json) return false;
    const json_t *view = json_object_get(json, "bufferView"), *sparse = json_object_get(json, "sparse");
    const char *type = json_string_value(json_object_get(json, "type"));
    snprintf(where, sizeof where, "accessors[%zu]", i);
    snprintf(inside, sizeof inside, "%s.bufferView", where);
    for (size_t k = 0; type && k < 4; k++)
        if (strcmp(type, types[k]) == 0) out->n = k + 1;
    if (out->n == 0) return rnd_import_fail(gltf->in, "%s.type: expected SCALAR or VEC2 to VEC4", where);
    if (!rnd_gltf_size(gltf, json, "count", SIZE_MAX, UINT32_MAX - 1, where, &out->count) ||
        !rnd_gltf_size(gltf, json, "componentType", SIZE_MAX, RND_GLTF_FLOAT, where, &out->component) ||
        !rnd_gltf_size(gltf, json, "byteOffset", 0, (size_t)1 << 40, where, &offset))
        return false;
    if (size_of(out->component) == 0)
        return rnd_import_fail(gltf->in, "%s.componentType: expected 5120 to 5123, 5125 or 5126", where);
    out->normalised = json_is_true(json_object_get(json, "normalized"));
    if (view) {
        const size_t packed = out->n * size_of(out->component);
        if (!(out->at = rnd_gltf_view(gltf, view, inside, &size, &out->stride))) return false;
        if (out->stride == 0) out->stride = packed;
        if (out->stride < packed ||
            offset + (out->count > 0 ? (out->count - 1) * out->stride + packed : 0) > size)
            return rnd_import_fail(gltf->in, "%s.count: %zu of %zu bytes, beyond the %zu of its buffer view",
                                   where, out->count, packed, size);
        out->at += offset;
    } else if (out->count > MAX_ZEROS || !sparse) {
        return rnd_import_fail(gltf->in, "%s.bufferView: expected one", where);
    }
    return !sparse || open_sparse(gltf, sparse, where, out);
}

void rnd_gltf_floats(const struct rnd_gltf_accessor *a, size_t first, size_t count, float *out)
{
    const size_t size = size_of(a->component), packed = size * a->n;
    if (!a->at) {
        memset(out, 0, count * a->n * sizeof *out);
    } else if (a->component == RND_GLTF_FLOAT && a->stride == packed) {
        memcpy(out, a->at + first * packed, count * packed);
    } else {
        for (size_t i = 0; i < count; i++)
            for (size_t k = 0; k < a->n; k++)
                out[i * a->n + k] =
                    float_at(a->at + (first + i) * a->stride + k * size, a->component, a->normalised);
    }
    if (a->sparse == 0) return;
    for (size_t s = first_sparse(a, first); s < a->sparse && sparse_at(a, s) < first + count; s++)
        for (size_t k = 0; k < a->n; k++)
            out[(sparse_at(a, s) - first) * a->n + k] =
                float_at(a->sparse_value + s * packed + k * size, a->component, a->normalised);
}

void rnd_gltf_integers(const struct rnd_gltf_accessor *a, uint32_t *out)
{
    const size_t packed = size_of(a->component) * a->n;
    for (size_t i = 0; i < a->count; i++)
        out[i] = a->at ? integer_at(a->at + i * a->stride, a->component) : 0;
    for (size_t s = 0; s < a->sparse; s++)
        out[sparse_at(a, s)] = integer_at(a->sparse_value + s * packed, a->component);
}
