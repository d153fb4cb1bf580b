/* Nodes of a glTF file: their poses, at the first key of the first animation; their meshes, lights and
 * cameras; and the instances of EXT_mesh_gpu_instancing. */
#include "import/gltf_node.h"
#include "import/gltf_accessor.h"
#include "import/gltf_bytes.h"
#include "import/gltf_json.h"
#include "import/gltf_mesh.h"
#include "light/drop.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_INSTANCES = 10000000 }; /* of a node */

static const struct rnd_pose rest = {.rotation = {0, 0, 0, 1}, .scale = {1, 1, 1}};

static const json_t *node_at(const struct rnd_gltf *gltf, size_t i)
{
    return json_array_get(json_object_get(gltf->root, "nodes"), i);
}

/* Read n numbers; without them out stays as it is. */
static bool read_array(const json_t *object, const char *key, size_t n, float *out)
{
    const json_t *array = json_object_get(object, key);
    if (json_array_size(array) != n) return false;
    for (size_t i = 0; i < n; i++)
        if (!json_is_number(json_array_get(array, i))) return false;
    for (size_t i = 0; i < n; i++) out[i] = (float)json_number_value(json_array_get(array, i));
    return true;
}

/* --- the trees --- */

/* Find the parent of each node; SIZE_MAX: none. */
static bool find_parents(struct rnd_gltf *gltf, size_t count, size_t *parent)
{
    char where[RND_WHERE_SIZE];
    for (size_t i = 0; i < count; i++) parent[i] = SIZE_MAX;
    for (size_t i = 0; i < count; i++) {
        const json_t *children = json_object_get(node_at(gltf, i), "children");
        for (size_t k = 0; k < json_array_size(children); k++) {
            size_t child;
            snprintf(where, sizeof where, "nodes[%zu].children[%zu]", i, k);
            if (!rnd_gltf_at(gltf, "nodes", json_array_get(children, k), where, &child)) return false;
            if (parent[child] != SIZE_MAX)
                return rnd_import_fail(gltf->in,
                                       "%s: node %zu is a child of node %zu already: expected one parent",
                                       where, child, parent[child]);
            parent[child] = i;
        }
    }
    for (size_t i = 0; i < count; i++) {
        int depth = 0;
        for (size_t k = parent[i]; k != SIZE_MAX; k = parent[k]) {
            if (k == i) return rnd_import_fail(gltf->in, "nodes[%zu]: is a child of its own descendants", i);
            if (++depth < RND_NODE_DEPTH) continue;
            return rnd_import_fail(gltf->in, "nodes[%zu]: nested more than %d deep", i, RND_NODE_DEPTH);
        }
    }
    return true;
}

/* Find the root nodes of the scene that the file names, else of its first scene; in a file without scenes,
 * all nodes without a parent. Roots that are also children (UniGLTF writes such) come last: if their tree is
 * shown, they are met there first. */
static bool find_roots(struct rnd_gltf *gltf, size_t count, const size_t *parent)
{
    const size_t scenes = rnd_gltf_length(gltf, "scenes");
    const json_t *first = json_object_get(gltf->root, "scene"), *roots = NULL;
    size_t scene = 0, repeated = 0;
    char where[RND_WHERE_SIZE];
    if (first && scenes && !rnd_gltf_at(gltf, "scenes", first, "scene", &scene)) return false;
    if (scenes)
        roots = json_object_get(json_array_get(json_object_get(gltf->root, "scenes"), scene), "nodes");
    const size_t all = scenes ? json_array_size(roots) : count;
    if (all == 0)
        return rnd_import_fail(gltf->in, "scenes[%zu].nodes: expected nodes, and there are none", scene);
    if (!(gltf->node_root = malloc(all * sizeof *gltf->node_root)))
        return rnd_import_fail(gltf->in, "not enough memory");
    for (int children = 0; children < 2; children++)
        for (size_t i = 0; i < all; i++) {
            size_t node = i;
            snprintf(where, sizeof where, "scenes[%zu].nodes[%zu]", scene, i);
            if (scenes && !rnd_gltf_at(gltf, "nodes", json_array_get(roots, i), where, &node)) return false;
            if ((parent[node] != SIZE_MAX) != children) continue;
            if (children && !scenes) continue;
            gltf->node_root[gltf->root_count++] = node;
            repeated += (size_t)children;
        }
    if (repeated > 0)
        rnd_warn(&gltf->in->scene->warnings,
                 "%s: scenes[%zu].nodes: %zu of them %s of another node: each is shown once, in its tree",
                 gltf->in->path, scene, repeated, repeated == 1 ? "is a child" : "are children");
    return true;
}

bool rnd_gltf_check_nodes(struct rnd_gltf *gltf)
{
    const size_t count = rnd_gltf_length(gltf, "nodes");
    size_t *parent = malloc((count + 1) * sizeof *parent);
    const bool ok = parent ? find_parents(gltf, count, parent) && find_roots(gltf, count, parent)
                           : rnd_import_fail(gltf->in, "not enough memory");
    free(parent);
    return ok;
}

/* --- the first frame --- */

/* Read count elements from first on, of n numbers each. False and a line if there are fewer, or not finite
 * ones. */
static bool read_floats(struct rnd_gltf *gltf, const json_t *index, const char *where, size_t n, size_t first,
                        size_t count, float *out)
{
    struct rnd_gltf_accessor a;
    if (!rnd_gltf_accessor(gltf, index, where, &a)) return false;
    if (a.n != n || first + count > a.count)
        return rnd_import_fail(gltf->in, "%s: expected %zu elements of %zu numbers, found %zu of %zu", where,
                               first + count, n, a.count, a.n);
    if (!rnd_gltf_ask(gltf, count * n, where)) return false;
    rnd_gltf_floats(&a, first, count, out);
    for (size_t i = 0; i < count * n; i++)
        if (!isfinite(out[i])) return rnd_import_fail(gltf->in, "%s: number %zu is not finite", where, i);
    return true;
}

/* Does the first key have a weight that is not 0? */
static bool read_weights(struct rnd_gltf *gltf, const json_t *node, const json_t *output, const char *where,
                         bool spline)
{
    const json_t *index = json_object_get(node, "mesh"), *meshes = json_object_get(gltf->root, "meshes"),
                 *mesh = rnd_gltf_element(meshes, index);
    const json_t *primitive = json_array_get(json_object_get(mesh, "primitives"), 0);
    const size_t targets = json_array_size(json_object_get(primitive, "targets"));
    for (size_t i = 0; i < targets && !gltf->morphs; i++) {
        float weight;
        if (!read_floats(gltf, output, where, 1, (spline ? targets : 0) + i, 1, &weight)) return false;
        gltf->morphs = weight != 0.0f;
    }
    return true;
}

/* Do meshes or nodes have weights that are not 0? */
static bool has_weights(const json_t *list)
{
    for (size_t i = 0; i < json_array_size(list); i++) {
        const json_t *weights = json_object_get(json_array_get(list, i), "weights");
        for (size_t k = 0; k < json_array_size(weights); k++)
            if (json_number_value(json_array_get(weights, k)) != 0.0) return true;
    }
    return false;
}

static void read_pose(const json_t *node, struct rnd_pose *pose)
{
    *pose = rest;
    read_array(node, "translation", 3, pose->translation);
    read_array(node, "rotation", 4, pose->rotation);
    read_array(node, "scale", 3, pose->scale);
}

/* Read the first key of one channel. */
static bool read_channel(struct rnd_gltf *gltf, const json_t *animation, size_t channel_index)
{
    char where[RND_WHERE_SIZE], inside[RND_WHERE_SIZE];
    const json_t *channel = json_array_get(json_object_get(animation, "channels"), channel_index),
                 *target = json_object_get(channel, "target"), *index = json_object_get(channel, "sampler");
    const size_t s = json_is_integer(index) ? (size_t)json_integer_value(index) : SIZE_MAX;
    const json_t *sampler = json_array_get(json_object_get(animation, "samplers"), s);
    const char *path = json_string_value(json_object_get(target, "path"));
    size_t i;
    snprintf(where, sizeof where, "animations[0].channels[%zu].target.node", channel_index);
    snprintf(inside, sizeof inside, "animations[0].samplers[%zu].output", s);
    if (!json_object_get(target, "node") || !path) return true;
    if (!rnd_gltf_at(gltf, "nodes", json_object_get(target, "node"), where, &i)) return false;
    if (!sampler)
        return rnd_import_fail(
            gltf->in, "animations[0].channels[%zu].sampler: expected the index of a sampler", channel_index);

    const char *way = json_string_value(json_object_get(sampler, "interpolation"));
    /* a key of a cubic spline is three values: tangent, value, tangent */
    const bool spline = way && strcmp(way, "CUBICSPLINE") == 0, turns = strcmp(path, "rotation") == 0;
    const json_t *output = json_object_get(sampler, "output");
    if (strcmp(path, "weights") == 0) return read_weights(gltf, node_at(gltf, i), output, inside, spline);
    struct rnd_pose *pose = &gltf->pose[i];
    float *to = turns                              ? pose->rotation
                : strcmp(path, "translation") == 0 ? pose->translation
                : strcmp(path, "scale") == 0       ? pose->scale
                                                   : NULL;
    if (!to) return true;
    if (!gltf->moved[i]) read_pose(node_at(gltf, i), pose);
    gltf->moved[i] = true;
    return read_floats(gltf, output, inside, turns ? 4 : 3, spline, 1, to);
}

bool rnd_gltf_first_frame(struct rnd_gltf *gltf)
{
    const json_t *animation = json_array_get(json_object_get(gltf->root, "animations"), 0);
    const size_t channels = json_array_size(json_object_get(animation, "channels"));
    gltf->morphs = has_weights(json_object_get(gltf->root, "meshes")) ||
                   has_weights(json_object_get(gltf->root, "nodes"));
    for (size_t i = 0; i < channels; i++)
        if (!read_channel(gltf, animation, i)) return false;
    return true;
}

/* --- instances within a node --- */

/* Read an attribute of the instances into poses, which are allocated by the count of the first attribute. */
static bool read_instances(struct rnd_gltf *gltf, const json_t *index, const char *where, size_t n,
                           size_t offset, struct rnd_pose **pose, size_t *count)
{
    struct rnd_gltf_accessor a;
    if (!rnd_gltf_accessor(gltf, index, where, &a)) return false;
    if (a.count == 0 || a.count > MAX_INSTANCES || (*pose && a.count != *count))
        return rnd_import_fail(gltf->in, "%s: %zu instances: expected as many as others have, 1 to %d", where,
                               a.count, MAX_INSTANCES);
    if (!*pose && (*pose = malloc(a.count * sizeof **pose)))
        for (size_t i = 0; i < a.count; i++) (*pose)[i] = rest;
    *count = a.count;
    float *value = malloc(a.count * n * sizeof *value);
    const bool ok = value && *pose ? read_floats(gltf, index, where, n, 0, a.count, value)
                                   : rnd_import_fail(gltf->in, "not enough memory");
    for (size_t i = 0; ok && i < a.count; i++)
        memcpy((char *)&(*pose)[i] + offset, value + i * n, n * sizeof *value);
    free(value);
    return ok;
}

/* Read the poses of EXT_mesh_gpu_instancing; *out_count is 0 if the node has none. The caller frees them also
 * on failure. */
static bool read_poses(struct rnd_gltf *gltf, size_t node, struct rnd_pose **out_pose, size_t *out_count)
{
    static const struct {
        const char *key;
        size_t n, offset;
    } parts[] = {
        {"TRANSLATION", 3, offsetof(struct rnd_pose, translation)},
        {"ROTATION", 4, offsetof(struct rnd_pose, rotation)},
        {"SCALE", 3, offsetof(struct rnd_pose, scale)},
    };
    const json_t *attributes =
        json_object_get(rnd_gltf_extension(node_at(gltf, node), "EXT_mesh_gpu_instancing"), "attributes");
    char where[RND_WHERE_SIZE];
    *out_pose = NULL;
    *out_count = 0;
    for (size_t p = 0; p < 3; p++) {
        const json_t *index = json_object_get(attributes, parts[p].key);
        snprintf(where, sizeof where, "nodes[%zu].extensions.EXT_mesh_gpu_instancing.attributes.%s", node,
                 parts[p].key);
        if (index && !read_instances(gltf, index, where, parts[p].n, parts[p].offset, out_pose, out_count))
            return false;
    }
    return true;
}

static bool place_mesh(struct rnd_gltf *gltf, size_t node, const struct rnd_affine *world)
{
    struct rnd_pose *pose = NULL;
    size_t poses = 0, index;
    char where[RND_WHERE_SIZE];
    const json_t *mesh_index = json_object_get(node_at(gltf, node), "mesh");
    snprintf(where, sizeof where, "nodes[%zu].mesh", node);
    if (!mesh_index) return true;
    if (!rnd_gltf_at(gltf, "meshes", mesh_index, where, &index) || !rnd_gltf_read_mesh(gltf, index))
        return false;
    const struct rnd_gltf_mesh *mesh = &gltf->mesh[index];
    bool ok = read_poses(gltf, node, &pose, &poses);
    for (uint32_t i = 0; ok && i < mesh->count; i++) {
        if (poses == 0) ok = rnd_import_place(gltf->in, mesh->first + i, world);
        for (size_t k = 0; ok && k < poses; k++) {
            const struct rnd_affine within =
                                        rnd_affine_pose(pose[k].translation, pose[k].rotation, pose[k].scale),
                                    at = rnd_affine_multiply(world, &within);
            ok = rnd_import_place(gltf->in, mesh->first + i, &at);
        }
    }
    free(pose);
    return ok;
}

/* --- lights --- */

/* Read a number that is not negative. False if it is something else; without it out stays as it is. */
static bool read_amount(const json_t *object, const char *key, float *out)
{
    const json_t *value = json_object_get(object, key);
    if (value) *out = json_is_number(value) ? (float)json_number_value(value) : -1.0f;
    return *out >= 0.0f && isfinite(*out);
}

/* The light of KHR_lights_punctual at a node: it shines along the node's -Z. */
static bool place_light(struct rnd_gltf *gltf, size_t node, const struct rnd_affine *world)
{
    static const char extension[] = "KHR_lights_punctual";
    const json_t *index = json_object_get(rnd_gltf_extension(node_at(gltf, node), extension), "light"),
                 *lights = json_object_get(rnd_gltf_extension(gltf->root, extension), "lights");
    const size_t i = json_is_integer(index) ? (size_t)json_integer_value(index) : SIZE_MAX;
    const json_t *light = json_array_get(lights, i), *spot = json_object_get(light, "spot");
    const char *type = json_string_value(json_object_get(light, "type"));
    float intensity = 1.0f, colour[3] = {1.0f, 1.0f, 1.0f}, inner = 0.0f, outer = (float)M_PI / 4.0f;
    char where[RND_WHERE_SIZE];
    if (!index) return true;
    if (!light)
        return rnd_import_fail(gltf->in,
                               "nodes[%zu].extensions.%s.light: expected the index of one of %zu lights",
                               node, extension, json_array_size(lights));
    snprintf(where, sizeof where, "extensions.%s.lights[%zu]", extension, i);
    if (!type ||
        (strcmp(type, "point") != 0 && strcmp(type, "spot") != 0 && strcmp(type, "directional") != 0))
        return rnd_import_fail(gltf->in, "%s.type: expected point, spot or directional", where);
    read_array(light, "color", 3, colour);
    if (!read_amount(light, "intensity", &intensity) || !read_amount(spot, "innerConeAngle", &inner) ||
        !read_amount(spot, "outerConeAngle", &outer))
        return rnd_import_fail(
            gltf->in, "%s: intensity and cone angles: expected finite numbers, none negative", where);
    for (int c = 0; c < 3; c++)
        if (!(colour[c] >= 0.0f && isfinite(colour[c] * intensity)))
            return rnd_import_fail(gltf->in, "%s.color: expected finite numbers, none negative", where);
    const struct rnd_punctual at = {
        .direction = {0, 0, -1},
        .kind = type[0] == 'p'   ? RND_POINT
                : type[0] == 's' ? RND_SPOT
                                 : RND_DIRECTIONAL,
        .intensity = rnd_v3(colour[0] * intensity, colour[1] * intensity, colour[2] * intensity),
        .drop_inner = rnd_drop_of((double)inner),
        .drop_outer = rnd_drop_of((double)outer)};
    return rnd_import_light(gltf->in, at, world);
}

/* --- all --- */

static struct rnd_affine local_map(const struct rnd_gltf *gltf, size_t node)
{
    struct rnd_pose pose = gltf->pose[node];
    float matrix[16];
    if (!gltf->moved[node] && read_array(node_at(gltf, node), "matrix", 16, matrix)) {
        struct rnd_affine map;
        for (int c = 0; c < 4; c++)
            for (int r = 0; r < 3; r++) map.m[3 * c + r] = (double)matrix[4 * c + r];
        return map;
    }
    if (!gltf->moved[node]) read_pose(node_at(gltf, node), &pose);
    return rnd_affine_pose(pose.translation, pose.rotation, pose.scale);
}

/* Walk a node and those below it, unless KHR_node_visibility hides it. */
static bool walk_node(struct rnd_gltf *gltf, size_t node, const struct rnd_affine *parent)
{
    static const float origin[3] = {0, 0, 0};
    const json_t *json = node_at(gltf, node), *children = json_object_get(json, "children"),
                 *camera = json_object_get(json, "camera");
    const struct rnd_affine local = local_map(gltf, node), world = rnd_affine_multiply(parent, &local);
    char where[RND_WHERE_SIZE];
    if (gltf->visited[node]) return true;
    gltf->visited[node] = true;
    if (json_is_false(json_object_get(rnd_gltf_extension(json, "KHR_node_visibility"), "visible")))
        return true;
    snprintf(where, sizeof where, "nodes[%zu].camera", node);
    if (camera && !rnd_gltf_at(gltf, "cameras", camera, where, NULL)) return false;
    if (camera) rnd_import_camera(gltf->in, &world, origin);
    if (!place_mesh(gltf, node, &world) || !place_light(gltf, node, &world)) return false;
    for (size_t i = 0; i < json_array_size(children); i++) {
        const size_t child = (size_t)json_integer_value(json_array_get(children, i));
        if (!walk_node(gltf, child, &world)) return false;
    }
    return true;
}

bool rnd_gltf_walk(struct rnd_import *in, void *file)
{
    struct rnd_gltf *gltf = file;
    const struct rnd_affine identity = rnd_affine_identity();
    (void)in;
    memset(gltf->visited, 0, rnd_gltf_length(gltf, "nodes") * sizeof *gltf->visited);
    for (size_t i = 0; i < gltf->root_count; i++)
        if (!walk_node(gltf, gltf->node_root[i], &identity)) return false;
    return true;
}
