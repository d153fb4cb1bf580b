/* Where glTF nodes are: at the first key of the first animation, and many times over by
 * EXT_mesh_gpu_instancing; and the lights at them.
 */
#include "scene/gltf.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_INSTANCES = 10000000 }; /* of a node */

static const struct rnd_pose rest = {.rotation = {0, 0, 0, 1}, .scale = {1, 1, 1}};

static void read_array(const json_t *object, const char *key, size_t n, float *out)
{
    const json_t *array = json_object_get(object, key);
    if (json_array_size(array) != n) return;
    for (size_t i = 0; i < n; i++)
        if (!json_is_number(json_array_get(array, i))) return;
    for (size_t i = 0; i < n; i++) out[i] = (float)json_number_value(json_array_get(array, i));
}

/* Is any of the first key's weights not 0? */
static bool read_weights(struct rnd_gltf *gltf, const json_t *node, const json_t *output, bool spline)
{
    const json_t *mesh = rnd_gltf_at(gltf, "meshes", json_object_get(node, "mesh"));
    const json_t *primitive = json_array_get(json_object_get(mesh, "primitives"), 0);
    const size_t targets = json_array_size(json_object_get(primitive, "targets"));
    for (size_t i = 0; i < targets && !gltf->morphs; i++) {
        float weight;
        if (!rnd_gltf_floats(gltf, output, (spline ? targets : 0) + i, 1, 1, &weight)) return false;
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

/* One channel's first key. */
static bool read_channel(struct rnd_gltf *gltf, const json_t *animation, const json_t *channel)
{
    const json_t *target = json_object_get(channel, "target"),
                 *samplers = json_object_get(animation, "samplers");
    const json_t *node = rnd_gltf_at(gltf, "nodes", json_object_get(target, "node"));
    const char *path = json_string_value(json_object_get(target, "path"));
    const json_t *index = json_object_get(channel, "sampler");
    const json_t *sampler =
        json_is_integer(index) ? json_array_get(samplers, (size_t)json_integer_value(index)) : NULL;
    if (!node || !path || !sampler) return true;

    const size_t i = (size_t)json_integer_value(json_object_get(target, "node"));
    const char *way = json_string_value(json_object_get(sampler, "interpolation"));
    /* a cubic spline's key is three values: the tangents before and after stand around its own */
    const bool spline = way && strcmp(way, "CUBICSPLINE") == 0;
    const json_t *output = json_object_get(sampler, "output");
    if (strcmp(path, "weights") == 0) return read_weights(gltf, node, output, spline);
    struct rnd_pose *pose = &gltf->pose[i];
    const bool turns = strcmp(path, "rotation") == 0;
    float *to = turns                              ? pose->rotation
                : strcmp(path, "translation") == 0 ? pose->translation
                : strcmp(path, "scale") == 0       ? pose->scale
                                                   : NULL;
    if (!to) return true;
    if (!gltf->moved[i]) {
        *pose = rest;
        read_array(node, "translation", 3, pose->translation);
        read_array(node, "rotation", 4, pose->rotation);
        read_array(node, "scale", 3, pose->scale);
        gltf->moved[i] = true;
    }
    return rnd_gltf_floats(gltf, output, spline, 1, turns ? 4 : 3, to);
}

bool rnd_gltf_first_frame(struct rnd_gltf *gltf)
{
    const json_t *animation = json_array_get(json_object_get(gltf->root, "animations"), 0);
    const json_t *channels = json_object_get(animation, "channels");
    const size_t nodes = json_array_size(json_object_get(gltf->root, "nodes"));
    gltf->pose = calloc(nodes + 1, sizeof *gltf->pose);
    gltf->moved = calloc(nodes + 1, sizeof *gltf->moved);
    if (!gltf->pose || !gltf->moved) return rnd_gltf_fail(gltf, "not enough memory");
    gltf->morphs = has_weights(json_object_get(gltf->root, "meshes")) ||
                   has_weights(json_object_get(gltf->root, "nodes"));
    for (size_t i = 0; i < json_array_size(channels); i++)
        if (!read_channel(gltf, animation, json_array_get(channels, i))) return false;
    return true;
}

bool rnd_gltf_node_instances(struct rnd_gltf *gltf, const json_t *node, struct rnd_pose **out_pose,
                             size_t *out_count)
{
    static const struct {
        const char *key;
        int n;
        size_t offset;
    } parts[] = {
        {"TRANSLATION", 3, offsetof(struct rnd_pose, translation)},
        {"ROTATION", 4, offsetof(struct rnd_pose, rotation)},
        {"SCALE", 3, offsetof(struct rnd_pose, scale)},
    };
    const json_t *attributes =
        json_object_get(rnd_gltf_extension(node, "EXT_mesh_gpu_instancing"), "attributes");
    *out_pose = NULL;
    *out_count = 0;
    for (size_t p = 0; p < 3; p++) {
        const json_t *index = json_object_get(attributes, parts[p].key);
        const size_t count = rnd_gltf_count(gltf, index);
        if (!index) continue;
        if (count == 0 || count > MAX_INSTANCES || (*out_pose && count != *out_count)) {
            rnd_gltf_fail(gltf, "instances of a node do not agree in number, or are none or over 10 million");
            goto fail;
        }
        float *value = malloc(count * 4 * sizeof *value);
        if (!*out_pose && (*out_pose = malloc(count * sizeof **out_pose))) {
            *out_count = count;
            for (size_t i = 0; i < count; i++) (*out_pose)[i] = rest;
        }
        if (!value || !*out_pose) rnd_gltf_fail(gltf, "not enough memory");
        if (!value || !*out_pose || !rnd_gltf_floats(gltf, index, 0, count, parts[p].n, value)) {
            free(value);
            goto fail;
        }
        for (size_t i = 0; i < count; i++)
            memcpy((char *)&(*out_pose)[i] + parts[p].offset, value + i * (size_t)parts[p].n,
                   (size_t)parts[p].n * sizeof *value);
        free(value);
    }
    return true;
fail:
    free(*out_pose);
    *out_pose = NULL;
    *out_count = 0;
    return false;
}

/* A number that is not negative; false if it is there and is not that. */
static bool read_amount(const json_t *object, const char *key, float *out)
{
    const json_t *value = json_object_get(object, key);
    if (value) *out = json_is_number(value) ? (float)json_number_value(value) : -1.0f;
    return *out >= 0.0f && isfinite(*out);
}

bool rnd_gltf_node_light(struct rnd_gltf *gltf, const json_t *node, struct rnd_punctual *out, bool *out_any)
{
    static const char extension[] = "KHR_lights_punctual";
    const json_t *index = json_object_get(rnd_gltf_extension(node, extension), "light"),
                 *lights = json_object_get(rnd_gltf_extension(gltf->root, extension), "lights"),
                 *light = json_is_integer(index) ? json_array_get(lights, (size_t)json_integer_value(index))
                                                 : NULL,
                 *spot = json_object_get(light, "spot");
    const char *type = json_string_value(json_object_get(light, "type"));
    float intensity = 1.0f, colour[3] = {1.0f, 1.0f, 1.0f}, inner = 0.0f, outer = (float)M_PI / 4.0f;
    if (!(*out_any = index != NULL)) return true;
    if (!light) return rnd_gltf_fail(gltf, "a node has a light that is not there");
    if (!type ||
        (strcmp(type, "point") != 0 && strcmp(type, "spot") != 0 && strcmp(type, "directional") != 0))
        return rnd_gltf_fail(gltf, "a light's type: expected point, spot or directional");
    read_array(light, "color", 3, colour);
    if (!read_amount(light, "intensity", &intensity) || !read_amount(spot, "innerConeAngle", &inner) ||
        !read_amount(spot, "outerConeAngle", &outer))
        return rnd_gltf_fail(gltf, "a light's intensity and angles: expected finite numbers, none negative");
    for (int c = 0; c < 3; c++)
        if (!(colour[c] >= 0.0f && isfinite(colour[c] * intensity)))
            return rnd_gltf_fail(gltf, "a light's color: expected finite numbers, none negative");
    *out = (struct rnd_punctual){
        .kind = type[0] == 'p'   ? RND_POINT
                : type[0] == 's' ? RND_SPOT
                                 : RND_DIRECTIONAL,
        .intensity = rnd_v3(colour[0] * intensity, colour[1] * intensity, colour[2] * intensity),
        .drop_inner = rnd_drop_of(inner),
        .drop_outer = rnd_drop_of(outer)};
    return true;
}
