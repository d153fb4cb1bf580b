/* Coverage: rays pass where a masked or blended material is not. Embree asks at every hit of such a mesh, and
 * of no other: a scene without them pays nothing.
 *
 * A blended hit counts with the probability of its coverage. The coin is a hash of the ray and the triangle,
 * so that nothing is remembered: the same ray meets the same surface however often and in whatever order
 * Embree asks.
 */
#include "scene/scene.h"

#include <stdlib.h>
#include <string.h>

struct rnd_alpha {
    const struct rnd_mesh *mesh; /* NULL: it is there everywhere */
    const struct rnd_material *material;
    const struct rnd_texture *texture;
};

/* --- textures --- */

/* A pixel's place along an axis of n, x being any. */
static int wrapped(int64_t x, int n, uint8_t wrap)
{
    if (wrap == RND_CLAMP) return (int)(x < 0 ? 0 : x >= n ? n - 1 : x);
    const int64_t period = wrap == RND_MIRROR ? 2 * (int64_t)n : n, m = (x % period + period) % period;
    return (int)(m < n ? m : period - 1 - m);
}

static float pixel_alpha(const struct rnd_pixels *p, int x, int y, int channel)
{
    const size_t i = ((size_t)y * (size_t)p->width + (size_t)x) * (size_t)p->channels + (size_t)channel;
    return p->floats ? p->floats[i] : p->bytes[i] / 255.0f;
}

/* Bilinear look at one channel. */
static float channel_at(const struct rnd_pixels *p, int channel, const uint8_t wrap[2], float u, float v)
{
    /* far out a float holds no place within a texel */
    const float far = 1e6f, x = fmaxf(-far, fminf(far, u)) * (float)p->width - 0.5f,
                y = fmaxf(-far, fminf(far, v)) * (float)p->height - 0.5f;
    const float x0 = floorf(x), y0 = floorf(y), fx = x - x0, fy = y - y0;
    const int xs[2] = {wrapped((int64_t)x0, p->width, wrap[0]), wrapped((int64_t)x0 + 1, p->width, wrap[0])},
              ys[2] = {wrapped((int64_t)y0, p->height, wrap[1]),
                       wrapped((int64_t)y0 + 1, p->height, wrap[1])};
    const float upper =
        (1.0f - fx) * pixel_alpha(p, xs[0], ys[0], channel) + fx * pixel_alpha(p, xs[1], ys[0], channel);
    const float lower =
        (1.0f - fx) * pixel_alpha(p, xs[0], ys[1], channel) + fx * pixel_alpha(p, xs[1], ys[1], channel);
    return (1.0f - fy) * upper + fy * lower;
}

static bool has_alpha(const struct rnd_pixels *p)
{
    return p->channels == 2 || p->channels == 4;
}

float rnd_texture_alpha(const struct rnd_texture *texture, const uint8_t wrap[2], float u, float v)
{
    const struct rnd_pixels *p = &texture->pixels;
    return has_alpha(p) ? channel_at(p, p->channels - 1, wrap, u, v) : 1.0f;
}

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
    const float *uv = alpha->mesh->uv[map->uv_set];
    float value = alpha->material->alpha;
    if (alpha->mesh->colour) value *= rnd_interpolate(alpha->mesh->colour, 4, 3, index, u, v);
    if (!alpha->texture || !uv) return value;

    const struct rnd_pixels *p = &alpha->texture->pixels;
    float s = rnd_interpolate(uv, 2, 0, index, u, v), t = rnd_interpolate(uv, 2, 1, index, u, v);
    if (map->has_transform) {
        const float *m = map->transform, s0 = s;
        s = m[0] * s0 + m[1] * t + m[2];
        t = m[3] * s0 + m[4] * t + m[5];
    }
    return value * channel_at(p, has_alpha(p) ? p->channels - 1 : 0, map->wrap, s, t);
}

/* --- filters --- */

static uint32_t mix(uint32_t hash, uint32_t value)
{
    hash = (hash ^ value) * 0x9e3779b1u;
    hash ^= hash >> 15;
    hash *= 0x85ebca77u;
    return hash ^ hash >> 13;
}

/* Embree's names for the parts of a packet of N are C++; their layout is documented: a row of N each (struct
 * RTCRayNp and RTCHitNp list them in order). */
enum { RAY_ORG_X = 0, RAY_DIR_X = 4, HIT_U = 3, HIT_V, HIT_TRIANGLE, HIT_GEOMETRY, HIT_INSTANCE };

/* In [0,1), of the i-th ray and what it hits. */
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

/* Of rays that meet and rays that are stopped alike. */
static void filter(const struct RTCFilterFunctionNArguments *args)
{
    const struct rnd_alpha *alpha = args->geometryUserPtr;
    const struct rnd_material *material = alpha->material;
    const size_t n = args->N;
    for (unsigned i = 0; i < n; i++) {
        const float *hit = (const float *)args->hit + i;
        if (args->valid[i] == 0) continue;
        const uint32_t triangle = ((const uint32_t *)args->hit)[HIT_TRIANGLE * n + i];
        const float there = coverage(alpha, triangle, hit[HIT_U * n], hit[HIT_V * n]);
        /* glTF 2.0 section 3.9.4: what equals the cut-off is there */
        const bool hits =
            material->alpha_mode == RND_MASK ? there >= material->alpha_cutoff : coin(args, i) < there;
        if (!hits) args->valid[i] = 0;
    }
}

/* Can a texture's coverage be less than whole? */
static bool has_holes(const struct rnd_pixels *p, int channel)
{
    const size_t count = (size_t)p->width * (size_t)p->height;
    for (size_t i = 0; i < count; i++) {
        const size_t k = i * (size_t)p->channels + (size_t)channel;
        if (p->floats ? p->floats[k] < 1.0f : p->bytes[k] < 255) return true;
    }
    return false;
}

/* The texture that a material's coverage comes from, or NULL where that is whole. */
static const struct rnd_texture *coverage_texture(const struct rnd_scene *scene,
                                                  const struct rnd_material *material)
{
    const struct rnd_map *map = coverage_map(material);
    if (map->texture < 0) return NULL;
    const struct rnd_texture *texture = &scene->texture[map->texture];
    const struct rnd_pixels *p = &texture->pixels;
    if (!has_alpha(p) && map != &material->map[RND_MAP_COVERAGE]) return NULL;
    return has_holes(p, has_alpha(p) ? p->channels - 1 : 0) ? texture : NULL;
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
        if (material->alpha_mode == RND_OPAQUE) continue;
        const float whole = material->alpha_mode == RND_MASK ? material->alpha_cutoff : 1.0f;
        if (material->alpha >= whole && !texture[mesh->material] && !mesh->colour) continue;
        scene->alpha[i] =
            (struct rnd_alpha){.mesh = mesh, .material = material, .texture = texture[mesh->material]};
    }
    free(texture);
    return ok;
}

void rnd_alpha_attach(const struct rnd_scene *scene, uint32_t mesh, RTCGeometry geometry)
{
    if (!scene->alpha[mesh].mesh) return;
    rtcSetGeometryUserData(geometry, &scene->alpha[mesh]);
    rtcSetGeometryIntersectFilterFunction(geometry, filter);
    rtcSetGeometryOccludedFilterFunction(geometry, filter);
}
