/* Meshes of a glTF file: each primitive of triangles becomes a shape. */
#include "import/gltf_mesh.h"
#include "import/gltf_accessor.h"
#include "import/gltf_bytes.h"
#include "import/gltf_draco.h"
#include "import/gltf_json.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* glTF 2.0 section 3.7.2.1 */
enum { POINTS, LINES, LINE_LOOP, LINE_STRIP, TRIANGLES, TRIANGLE_STRIP, TRIANGLE_FAN };

/* The primitive that is being read. */
struct primitive {
    struct rnd_gltf *gltf;
    const json_t *json;
    char where[RND_WHERE_SIZE]; /* its place in the file */
    struct rnd_gltf_accessor position;
    uint32_t *vertex; /* the vertices of the file that it uses; NULL: all from first on */
    uint32_t first;
    struct rnd_mesh mesh;
};

/* --- triangles --- */

/* Read the vertex indices, in the file's order. NULL and a line. The caller frees. */
static uint32_t *read_corners(struct primitive *p, size_t *out_count)
{
    char where[RND_WHERE_SIZE + 16];
    const json_t *index = json_object_get(p->json, "indices");
    struct rnd_gltf_accessor a = {.count = p->position.count};
    snprintf(where, sizeof where, "%s.indices", p->where);
    if (index && !rnd_gltf_accessor(p->gltf, index, where, &a)) return NULL;
    if (index &&
        (a.n != 1 || (a.component != RND_GLTF_UNSIGNED_BYTE && a.component != RND_GLTF_UNSIGNED_SHORT &&
                      a.component != RND_GLTF_UNSIGNED_INT))) {
        rnd_import_fail(p->gltf->in, "%s: expected SCALAR of component 5121, 5123 or 5125", where);
        return NULL;
    }
    if (!rnd_gltf_ask(p->gltf, a.count, where)) return NULL;
    uint32_t *corner = malloc((a.count + 1) * sizeof *corner);
    if (!corner) {
        rnd_import_fail(p->gltf->in, "not enough memory");
        return NULL;
    }
    if (index)
        rnd_gltf_integers(&a, corner);
    else
        for (size_t i = 0; i < a.count; i++) corner[i] = (uint32_t)i;
    *out_count = a.count;
    for (size_t i = 0; i < a.count; i++) {
        if (corner[i] < p->position.count) continue;
        rnd_import_fail(p->gltf->in, "%s: number %zu is vertex %u: expected one below %zu", where, i,
                        corner[i], p->position.count);
        free(corner);
        return NULL;
    }
    return corner;
}

/* Make triangles of vertex indices, without those of a strip or fan that have no area and only lead to the
 * next. */
static bool make_triangles(struct primitive *p, const uint32_t *corner, size_t count, size_t mode)
{
    struct rnd_mesh *mesh = &p->mesh;
    const size_t most = mode == TRIANGLES ? count / 3 : count < 3 ? 0 : count - 2;
    if (!(mesh->index = malloc((most + 1) * sizeof *mesh->index))) return false;
    for (size_t i = 0; i < most; i++) {
        const size_t k = mode == TRIANGLES ? 3 * i : i, odd = mode == TRIANGLE_STRIP ? i % 2 : 0;
        const uint32_t a = mode == TRIANGLE_FAN ? corner[i + 1] : corner[k],
                       b = mode == TRIANGLE_FAN ? corner[i + 2] : corner[k + 1 + odd],
                       c = mode == TRIANGLE_FAN ? corner[0] : corner[k + 2 - odd];
        if (mode != TRIANGLES && (a == b || b == c || c == a)) continue;
        uint32_t *to = mesh->index[mesh->triangles++];
        to[0] = a, to[1] = b, to[2] = c;
    }
    return true;
}

static int compare(const void *a, const void *b)
{
    const uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;
    return (x > y) - (x < y);
}

/* Choose the part of shared vertices that this primitive gets: a range of them, or only those that it uses if
 * most of the range are others. corner has count indices, and is sorted. */
static void choose_vertices(struct primitive *p, uint32_t *corner, size_t count)
{
    struct rnd_mesh *mesh = &p->mesh;
    uint32_t low = UINT32_MAX, high = 0;
    for (size_t i = 0; i < count; i++) {
        low = corner[i] < low ? corner[i] : low;
        high = corner[i] > high ? corner[i] : high;
    }
    p->first = low;
    mesh->vertices = high - low + 1;
    if (mesh->vertices / 4 > count) {
        qsort(corner, count, sizeof *corner, compare);
        mesh->vertices = 0;
        for (size_t i = 0; i < count; i++)
            if (i == 0 || corner[i] != corner[i - 1]) corner[mesh->vertices++] = corner[i];
        p->vertex = corner;
    }
    for (uint32_t t = 0; t < mesh->triangles; t++)
        for (int k = 0; k < 3; k++) {
            uint32_t *index = &mesh->index[t][k];
            const uint32_t *found =
                p->vertex ? bsearch(index, p->vertex, mesh->vertices, sizeof *index, compare) : NULL;
            *index = found ? (uint32_t)(found - p->vertex) : *index - low;
        }
}

/* --- attributes --- */

/* Find an attribute, with elements of least to most numbers. *out_any: is there one? */
static bool find_attribute(struct primitive *p, const char *name, size_t least, size_t most,
                           struct rnd_gltf_accessor *out, bool *out_any)
{
    char where[RND_WHERE_SIZE + 40];
    const json_t *index = json_object_get(json_object_get(p->json, "attributes"), name);
    snprintf(where, sizeof where, "%s.attributes.%s", p->where, name);
    if (!(*out_any = index != NULL)) return true;
    if (!rnd_gltf_accessor(p->gltf, index, where, out)) return false;
    if (out->n < least || out->n > most)
        return rnd_import_fail(p->gltf->in, "%s: expected an accessor of VEC%zu, found %zu numbers", where,
                               most, out->n);
    if (p->position.n && out->count < p->position.count)
        return rnd_import_fail(p->gltf->in, "%s: expected %zu elements, as POSITION has, found %zu", where,
                               p->position.count, out->count);
    return true;
}

/* Read the primitive's part of an attribute: n floats per vertex, and one float more. NULL and a line. */
static float *read_floats(struct primitive *p, const struct rnd_gltf_accessor *a)
{
    const size_t count = p->mesh.vertices;
    if (!rnd_gltf_ask(p->gltf, a->n * count, p->where)) return NULL;
    float *out = malloc((a->n * count + 1) * sizeof *out);
    if (!out) {
        rnd_import_fail(p->gltf->in, "not enough memory");
        return NULL;
    }
    if (!p->vertex) rnd_gltf_floats(a, p->first, count, out);
    for (size_t i = 0; p->vertex && i < count; i++) rnd_gltf_floats(a, p->vertex[i], 1, out + i * a->n);
    out[a->n * count] = 0.0f;
    return out;
}

static bool read_attribute(struct primitive *p, const char *name, size_t n, float **out)
{
    struct rnd_gltf_accessor a;
    bool any;
    if (!find_attribute(p, name, n, n, &a, &any)) return false;
    return !any || (*out = read_floats(p, &a));
}

/* Read colours of three or four numbers. Integers are normalised even if the accessor does not say so. */
static bool read_colour(struct primitive *p)
{
    struct rnd_gltf_accessor a;
    bool any;
    const size_t count = p->mesh.vertices;
    if (!find_attribute(p, "COLOR_0", 3, 4, &a, &any)) return false;
    if (!any) return true;
    a.normalised = true;
    float *from = read_floats(p, &a);
    if (!from) return false;
    float *to = malloc(4 * count * sizeof *to);
    for (size_t i = 0; to && i < count; i++) {
        to[4 * i + 3] = 1.0f;
        for (size_t k = 0; k < a.n; k++) to[4 * i + k] = from[i * a.n + k];
    }
    free(from);
    p->mesh.colour = to;
    return to || rnd_import_fail(p->gltf->in, "not enough memory");
}

/* Read all attributes; tangents only if the material has a normal map. */
static bool read_attributes(struct primitive *p)
{
    struct rnd_mesh *mesh = &p->mesh;
    const struct rnd_map *map = p->gltf->in->scene->material[mesh->material].map;
    const bool bends = map[RND_MAP_NORMAL].texture >= 0 || map[RND_MAP_CLEARCOAT_NORMAL].texture >= 0;
    return (mesh->position = read_floats(p, &p->position)) && read_attribute(p, "NORMAL", 3, &mesh->normal) &&
           (!bends || !mesh->normal || read_attribute(p, "TANGENT", 4, &mesh->tangent)) &&
           read_attribute(p, "TEXCOORD_0", 2, &mesh->uv[0]) &&
           read_attribute(p, "TEXCOORD_1", 2, &mesh->uv[1]) && read_colour(p);
}

/* --- primitives --- */

static bool read_material(struct primitive *p)
{
    char where[RND_WHERE_SIZE + 16];
    size_t index = rnd_gltf_length(p->gltf, "materials"); /* the default material is there */
    const json_t *material = json_object_get(p->json, "material");
    snprintf(where, sizeof where, "%s.material", p->where);
    if (material && !rnd_gltf_at(p->gltf, "materials", material, where, &index)) return false;
    p->mesh.material = (uint32_t)index;
    return true;
}

static bool fill(struct primitive *p, size_t mode)
{
    size_t count;
    if (p->position.count == 0) return true;
    uint32_t *corner = read_corners(p, &count);
    if (!corner) return false;
    bool ok = make_triangles(p, corner, count, mode) || rnd_import_fail(p->gltf->in, "not enough memory");
    if (ok && p->mesh.triangles > 0) {
        choose_vertices(p, corner, count);
        ok = read_attributes(p);
    }
    free(corner);
    return ok;
}

static bool read_primitive(struct primitive *p, const char *name)
{
    struct rnd_import *in = p->gltf->in;
    size_t mode;
    bool any;
    if (!rnd_gltf_size(p->gltf, p->json, "mode", TRIANGLES, TRIANGLE_FAN, p->where, &mode)) return false;
    if (mode < TRIANGLES) {
        rnd_scene_unsupported(in->scene, "points and lines");
        return true;
    }
    if (rnd_gltf_is_draco(p->gltf, p->json))
        return read_material(p) && rnd_gltf_draco(p->gltf, p->json, p->where, p->mesh.material, name);
    if (!find_attribute(p, "POSITION", 3, 3, &p->position, &any) || !read_material(p)) return false;
    if (!any) {
        rnd_scene_unsupported(in->scene, "primitives without positions");
        return true;
    }
    const bool ok = fill(p, mode);
    if (ok && p->mesh.triangles > 0) return rnd_import_shape(in, &p->mesh, name);
    rnd_mesh_finish(&p->mesh);
    return ok;
}

bool rnd_gltf_read_mesh(struct rnd_gltf *gltf, size_t index)
{
    struct rnd_gltf_mesh *mesh = &gltf->mesh[index];
    const json_t *json = json_array_get(json_object_get(gltf->root, "meshes"), index),
                 *primitives = json_object_get(json, "primitives");
    if (mesh->read) return true;
    mesh->read = true;
    mesh->first = gltf->in->shape_count;
    for (size_t i = 0; i < json_array_size(primitives); i++) {
        struct primitive p = {.gltf = gltf, .json = json_array_get(primitives, i)};
        snprintf(p.where, sizeof p.where, "meshes[%zu].primitives[%zu]", index, i);
        if (!read_primitive(&p, json_string_value(json_object_get(json, "name")))) return false;
    }
    mesh->count = gltf->in->shape_count - mesh->first;
    return true;
}
