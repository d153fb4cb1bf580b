/* Coverage: whether a ray meets a masked or blended material, or a pane of glass, or passes through it.
 * Embree asks this for hits of such meshes alone: a scene without them pays nothing.
 *
 * A ray meets a blended material with the probability of its coverage, and a pane with the probability that
 * light does not pass it. The decision is a hash of the ray and the triangle, so nothing has to be
 * remembered: the same ray meets the same surface, however often and in whatever order Embree asks.
 */
#include "material/coverage.h"
#include "material/glass.h"
#include "material/shading.h"
#include "material/surface.h"

#include <stdlib.h>
#include <string.h>

struct rnd_alpha {
    const struct rnd_scene *scene;
    const struct rnd_mesh *mesh; /* NULL: it is there everywhere */
    const struct rnd_material *material;
    const struct rnd_texture *texture;
};

/* --- coverage --- */

static const struct rnd_map *coverage_map(const struct rnd_material *material)
{
    const struct rnd_map *own = &material->map[RND_MAP_COVERAGE];
    return own->texture >= 0 ? own : &material->map[RND_MAP_BASE];
}

static float coverage(const struct rnd_alpha *alpha, uint32_t triangle, float u, float v)
{
    const uint32_t *index = alpha->mesh->index[triangle];
    const struct rnd_map *map = coverage_map(alpha->material);
    float value = alpha->material->alpha;
    if (alpha->mesh->colour) value *= rnd_interpolate(alpha->mesh->colour, 4, 3, index, u, v);
    if (!alpha->texture) return value;

    float place[2];
    rnd_map_uv(map, alpha->mesh, index, u, v, place);
    const struct rnd_texel t = rnd_texture_at(alpha->texture, map->wrap, map->nearest, place[0], place[1]);
    return value * (alpha->texture->has_alpha ? t.a : t.r);
}

/* The chance with which a hit of that coverage counts. A coverage equal to the cut-off counts (glTF 2.0,
 * section 3.9.4). */
static float chance(const struct rnd_material *material, float there)
{
    if (material->alpha_mode == RND_MASK) return there >= material->alpha_cutoff ? 1.0f : 0.0f;
    return fminf(fmaxf(there, 0.0f), 1.0f);
}

bool rnd_has_coverage(const struct rnd_scene *scene, uint32_t mesh)
{
    const struct rnd_alpha *alpha = &scene->alpha[mesh];
    return alpha->mesh && !rnd_is_pane(alpha->mesh, alpha->material);
}

float rnd_coverage(const struct rnd_scene *scene, uint32_t mesh, uint32_t triangle, float u, float v)
{
    const struct rnd_alpha *alpha = &scene->alpha[mesh];
    return chance(alpha->material, coverage(alpha, triangle, u, v));
}

const struct rnd_texture *rnd_coverage_texture(const struct rnd_scene *scene, uint32_t mesh,
                                               const struct rnd_map **out_map, bool *out_by_alpha)
{
    const struct rnd_alpha *alpha = &scene->alpha[mesh];
    *out_map = coverage_map(alpha->material);
    *out_by_alpha = alpha->texture && alpha->texture->has_alpha;
    return alpha->mesh->uv[(*out_map)->uv_set] ? alpha->texture : NULL;
}

/* --- filters --- */

static uint32_t mix(uint32_t hash, uint32_t value)
{
    hash = (hash ^ value) * 0x9e3779b1u;
    hash ^= hash >> 15;
    hash *= 0x85ebca77u;
    return hash ^ hash >> 13;
}

/* Embree declares the parts of a packet of N rays in C++ alone. Their layout is documented: N values a row,
 * in the order of struct RTCRay8 and RTCHit8. */
enum {
    RAY_ORG_X = 0,
    RAY_DIR_X = 4,
    HIT_NORMAL_X = 0,
    HIT_U = 3,
    HIT_V,
    HIT_TRIANGLE,
    HIT_GEOMETRY,
    HIT_INSTANCE
};

/* A number in [0,1): a hash of the i-th ray and of the triangle that it hits. */
static float coin(const struct RTCFilterFunctionNArguments *args, unsigned i)
{
    const uint32_t *ray = (const uint32_t *)args->ray + i, *hit = (const uint32_t *)args->hit + i;
    const size_t n = args->N;
    uint32_t hash = 0x243f6a88u;
    for (size_t row = HIT_TRIANGLE; row <= HIT_INSTANCE; row++) hash = mix(hash, hit[row * n]);
    for (size_t axis = 0; axis < 3; axis++)
        hash = mix(mix(hash, ray[(RAY_ORG_X + axis) * n]), ray[(RAY_DIR_X + axis) * n]);
    return (float)(hash >> 8) * 0x1p-24f;
}

/* For rays that look for the nearest hit, and for shadow rays. */
static void coverage_filter(const struct RTCFilterFunctionNArguments *args)
{
    const struct rnd_alpha *alpha = args->geometryUserPtr;
    const struct rnd_material *material = alpha->material;
    const size_t n = args->N;
    for (unsigned i = 0; i < n; i++) {
        const float *hit = (const float *)args->hit + i;
        if (args->valid[i] == 0) continue;
        const uint32_t triangle = ((const uint32_t *)args->hit)[HIT_TRIANGLE * n + i];
        const float there = coverage(alpha, triangle, hit[HIT_U * n], hit[HIT_V * n]);
        const float hits = chance(material, there);
        if (hits < 1.0f && !(coin(args, i) < hits)) args->valid[i] = 0;
    }
}

/* Cosine between the i-th ray and the normal of what it hits. Embree gives both in the mesh's coordinates.
 * Their dot product is the same there as in the world, but their lengths are not. */
static float cosine(const struct RTCFilterFunctionNArguments *args, const struct rnd_scene *scene, unsigned i)
{
    const size_t n = args->N;
    const float *ray = (const float *)args->ray + i, *hit = (const float *)args->hit + i;
    vec3s direction = {{ray[RAY_DIR_X * n], ray[(RAY_DIR_X + 1) * n], ray[(RAY_DIR_X + 2) * n]}},
          normal = {{hit[HIT_NORMAL_X * n], hit[(HIT_NORMAL_X + 1) * n], hit[(HIT_NORMAL_X + 2) * n]}};
    const float product = fabsf(glms_vec3_dot(direction, normal));
    const uint32_t instance = ((const uint32_t *)args->hit)[HIT_INSTANCE * n + i];
    if (instance != RTC_INVALID_GEOMETRY_ID) {
        const struct rnd_instance *seen = &scene->instance[instance - scene->mesh_count];
        direction = rnd_instance_direction(seen, direction);
        normal = rnd_from_v3(rnd_normal_to_world(seen, rnd_to_v3(normal)));
    }
    return product / (glms_vec3_norm(direction) * glms_vec3_norm(normal));
}

static void pane_filter(const struct RTCFilterFunctionNArguments *args)
{
    const struct rnd_alpha *alpha = args->geometryUserPtr;
    for (unsigned i = 0; i < args->N; i++) {
        float passes;
        if (args->valid[i] == 0) continue;
        rnd_pane_reflects(alpha->material, cosine(args, alpha->scene, i), &passes);
        if (coin(args, i) < passes) args->valid[i] = 0;
    }
}

static void clear_filter(const struct RTCFilterFunctionNArguments *args)
{
    for (unsigned i = 0; i < args->N; i++) args->valid[i] = 0;
}

/* Is the texture transparent anywhere? */
static bool has_holes(const struct rnd_texture *texture, int channel)
{
    const size_t count = (size_t)texture->level[0].width * (size_t)texture->level[0].height;
    for (size_t i = 0; i < count; i++)
        if (texture->floats ? texture->floats[4 * i + channel] < 1.0f : texture->bytes[4 * i + channel] < 255)
            return true;
    return false;
}

/* The texture that a material's coverage comes from, or NULL if the texture is opaque everywhere. */
static const struct rnd_texture *coverage_texture(const struct rnd_scene *scene,
                                                  const struct rnd_material *material)
{
    const struct rnd_map *map = coverage_map(material);
    if (map->texture < 0) return NULL;
    const struct rnd_texture *texture = &scene->texture[map->texture];
    if (!texture->has_alpha && map != &material->map[RND_MAP_COVERAGE]) return NULL;
    return has_holes(texture, texture->has_alpha ? 3 : 0) ? texture : NULL;
}

bool rnd_alpha_build(struct rnd_scene *scene)
{
    const struct rnd_texture **texture = calloc(scene->material_count + 1, sizeof *texture);
    scene->alpha = calloc(scene->mesh_count + 1, sizeof *scene->alpha);
    const bool ok = texture && scene->alpha;
    for (uint32_t i = 0; ok && i < scene->material_count; i++)
        if (scene->material[i].alpha_mode != RND_OPAQUE)
            texture[i] = coverage_texture(scene, &scene->material[i]);
    for (uint32_t i = 0; ok && i < scene->mesh_count; i++) {
        const struct rnd_mesh *mesh = &scene->mesh[i];
        const struct rnd_material *material = &scene->material[mesh->material];
        if (rnd_is_pane(mesh, material))
            scene->alpha[i] = (struct rnd_alpha){.scene = scene, .mesh = mesh, .material = material};
        if (material->alpha_mode == RND_OPAQUE) continue;
        const float whole = material->alpha_mode == RND_MASK ? material->alpha_cutoff : 1.0f;
        if (material->alpha >= whole && !texture[mesh->material] && !mesh->colour) continue;
        scene->alpha[i] = (struct rnd_alpha){
            .scene = scene, .mesh = mesh, .material = material, .texture = texture[mesh->material]};
    }
    free(texture);
    return ok;
}

void rnd_alpha_attach(const struct rnd_scene *scene, uint32_t mesh, RTCGeometry geometry)
{
    struct rnd_alpha *alpha = &scene->alpha[mesh];
    if (rnd_is_clear(scene, mesh)) {
        rtcSetGeometryOccludedFilterFunction(geometry, clear_filter);
        return;
    }
    if (!alpha->mesh) return;
    const RTCFilterFunctionN passes =
        rnd_is_pane(alpha->mesh, alpha->material) ? pane_filter : coverage_filter;
    rtcSetGeometryUserData(geometry, alpha);
    rtcSetGeometryIntersectFilterFunction(geometry, passes);
    rtcSetGeometryOccludedFilterFunction(geometry, passes);
}
