/* The path integrator, a wave at a time: all rays, then all surfaces, then all shadow rays, and again. */
#include "path/trace.h"
#include "path/shade.h"
#include "sampler.h"

#include <stdlib.h>

/* Bounces before Russian roulette begins: shorter paths carry most of the light. */
enum { SURE_BOUNCES = 3 };

/* Dimensions that a vertex of a path uses, from RND_DIMENSION_PATH on. */
enum { DIM_DIRECTION, DIM_LOBE, DIM_LIGHT, DIM_LIGHT_PLACE, DIM_COUNT };

/* A light that was chosen for a path, and what it brings if nothing is in between. */
struct shadow {
    uint32_t path;
    vec3s radiance;
};

struct rnd_tracer {
    const struct rnd_scene *scene;
    int max_bounces;
    uint32_t alive[RND_WAVE];     /* indices of the paths that go on */
    struct rnd_hit hit[RND_WAVE]; /* of alive paths, in their order */
    struct shadow shadow[RND_WAVE];
    struct RTCRay ray[RND_WAVE]; /* of the shadows, in their order */
};

struct rnd_tracer *rnd_tracer_create(const struct rnd_scene *scene, int max_bounces)
{
    struct rnd_tracer *tracer = aligned_alloc(64, (sizeof *tracer + 63) & ~(size_t)63);
    if (!tracer) return NULL;
    tracer->scene = scene;
    tracer->max_bounces = max_bounces;
    return tracer;
}

void rnd_tracer_destroy(struct rnd_tracer *tracer)
{
    free(tracer);
}

/* --- rays --- */

static void resolve(const struct rnd_scene *scene, struct rnd_hit *hit, uint32_t inst_id)
{
    if (hit->mesh != RTC_INVALID_GEOMETRY_ID)
        hit->instance = rnd_resolve_hit(scene, hit->mesh, inst_id, &hit->mesh);
}

/* Find what alive paths hit, WIDTH rays at a time; Embree has a type and a function for every width. */
#define INTERSECT(name, WIDTH, coherence)                                                                    \
    static void name(struct rnd_tracer *tracer, const struct rnd_path *paths, uint32_t count)                \
    {                                                                                                        \
        struct RTCIntersectContext context;                                                                  \
        _Alignas(64) struct RTCRayHit##WIDTH packet;                                                         \
        _Alignas(64) int valid[WIDTH];                                                                       \
        rtcInitIntersectContext(&context);                                                                   \
        context.flags = coherence;                                                                           \
        for (uint32_t first = 0; first < count; first += WIDTH) {                                            \
            const uint32_t n = count - first < WIDTH ? count - first : WIDTH;                                \
            for (uint32_t i = 0; i < WIDTH; i++) {                                                           \
                const struct rnd_path *path = &paths[tracer->alive[first + (i < n ? i : 0)]];                \
                valid[i] = i < n ? -1 : 0;                                                                   \
                packet.ray.org_x[i] = path->origin.x, packet.ray.dir_x[i] = path->direction.x;               \
                packet.ray.org_y[i] = path->origin.y, packet.ray.dir_y[i] = path->direction.y;               \
                packet.ray.org_z[i] = path->origin.z, packet.ray.dir_z[i] = path->direction.z;               \
                packet.ray.tnear[i] = packet.ray.time[i] = 0.0f;                                             \
                packet.ray.tfar[i] = INFINITY;                                                               \
                packet.ray.mask[i] = UINT32_MAX;                                                             \
                packet.ray.id[i] = packet.ray.flags[i] = 0;                                                  \
                packet.hit.geomID[i] = packet.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;                    \
            }                                                                                                \
            rtcIntersect##WIDTH(valid, tracer->scene->tree, &context, &packet);                              \
            for (uint32_t i = 0; i < n; i++) {                                                               \
                tracer->hit[first + i] = (struct rnd_hit){                                                   \
                    .mesh = packet.hit.geomID[i],                                                            \
                    .triangle = packet.hit.primID[i],                                                        \
                    .u = packet.hit.u[i],                                                                    \
                    .v = packet.hit.v[i],                                                                    \
                    .distance = packet.ray.tfar[i],                                                          \
                    .normal = {{packet.hit.Ng_x[i], packet.hit.Ng_y[i], packet.hit.Ng_z[i]}}};               \
                resolve(tracer->scene, &tracer->hit[first + i], packet.hit.instID[0][i]);                    \
            }                                                                                                \
        }                                                                                                    \
    }

/* First rays of neighbouring pixels keep together; rays that have been scattered share nothing but the tree,
 * and go eight at a time only to keep its memory busy. */
INTERSECT(intersect_coherent, 16, RTC_INTERSECT_CONTEXT_FLAG_COHERENT)
INTERSECT(intersect_scattered, 8, RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT)

/* Shadow rays end at the first thing in the way, and go as one stream. */
static void occlude(struct rnd_tracer *tracer, struct rnd_path *paths, uint32_t count)
{
    struct RTCIntersectContext context;
    if (count == 0) return;
    rtcInitIntersectContext(&context);
    rtcOccluded1M(tracer->scene->tree, &context, tracer->ray, count, sizeof *tracer->ray);
    for (uint32_t i = 0; i < count; i++) {
        struct rnd_path *path = &paths[tracer->shadow[i].path];
        if (tracer->ray[i].tfar >= 0.0f)
            path->radiance = glms_vec3_add(path->radiance, tracer->shadow[i].radiance);
    }
}

/* --- light --- */

static void add(struct rnd_path *path, vec3s radiance, float weight)
{
    path->radiance = glms_vec3_muladds(glms_vec3_mul(path->throughput, radiance), weight, path->radiance);
}

/* The path left the scene: environment and sun. */
static void add_sky(const struct rnd_lights *lights, struct rnd_path *path)
{
    if (lights->env) {
        const float other = lights->choose[RND_LIGHT_ENV] * rnd_env_pdf(lights->env, path->direction);
        add(path, rnd_env_radiance(lights->env, path->direction),
            path->delta ? 1.0f : rnd_power_heuristic(path->pdf, other));
    }
    const struct rnd_sun *sun = lights->sun;
    if (sun && sun->cos_radius < 1.0f && glms_vec3_dot(path->direction, sun->direction) >= sun->cos_radius) {
        const float other = lights->choose[RND_LIGHT_SUN] * rnd_sun_pdf(sun);
        add(path, sun->radiance, path->delta ? 1.0f : rnd_power_heuristic(path->pdf, other));
    }
}

/* The surface that the path hit shines itself. */
static void add_emission(const struct rnd_scene *scene, struct rnd_path *path,
                         const struct rnd_surface *surface, const struct rnd_hit *hit)
{
    if (!(rnd_luminance(surface->emission.raw) > 0.0f)) return;
    float weight = 1.0f;
    if (!path->delta && !surface->material->unlit) /* which is no light that is ever chosen */
        weight = rnd_power_heuristic(
            path->pdf, rnd_area_pdf(scene, hit->mesh, hit->triangle, path->direction, hit->distance));
    add(path, surface->emission, weight);
}

/* Next-event estimation: one light, whose shadow ray is put down for later. True if there is one. */
static bool choose_light(const struct rnd_scene *scene, const struct rnd_path *path,
                         const struct rnd_surface *surface, uint32_t dimension, struct shadow *out_shadow,
                         struct RTCRay *out_ray)
{
    struct rnd_light_sample light;
    float u[4], pdf;
    rnd_pair(path->seed, dimension + DIM_LIGHT, path->index, u);
    rnd_pair(path->seed, dimension + DIM_LIGHT_PLACE, path->index, u + 2);
    if (!rnd_light_draw(scene, surface->position, u, &light)) return false;
    const vec3s f = rnd_bsdf(surface, glms_vec3_negate(path->direction), light.direction, &pdf);
    if (!(rnd_luminance(f.raw) > 0.0f)) return false;

    const float weight = (light.delta ? 1.0f : rnd_power_heuristic(light.pdf, pdf)) / light.pdf;
    out_shadow->radiance =
        glms_vec3_scale(glms_vec3_mul(path->throughput, glms_vec3_mul(f, light.radiance)), weight);
    const vec3s origin = rnd_leave(surface, light.direction);
    *out_ray = (struct RTCRay){.org_x = origin.x,
                               .org_y = origin.y,
                               .org_z = origin.z,
                               .dir_x = light.direction.x,
                               .dir_y = light.direction.y,
                               .dir_z = light.direction.z,
                               .tfar = light.distance * (1.0f - 1e-4f),
                               .mask = UINT32_MAX};
    return true;
}

/* Choose where the path goes on; false where it ends. */
static bool bounce(struct rnd_path *path, const struct rnd_surface *surface, int depth, uint32_t dimension)
{
    struct rnd_bsdf_sample sample;
    float u[4];
    rnd_pair(path->seed, dimension + DIM_DIRECTION, path->index, u);
    rnd_pair(path->seed, dimension + DIM_LOBE, path->index, u + 2);
    if (!rnd_bsdf_draw(surface, glms_vec3_negate(path->direction), u, &sample)) return false;
    path->throughput = glms_vec3_mul(path->throughput, sample.weight);
    if (depth >= SURE_BOUNCES) {
        const float go_on = fminf(glms_vec3_max(path->throughput), 0.95f);
        if (!(u[3] < go_on)) return false;
        path->throughput = glms_vec3_scale(path->throughput, 1.0f / go_on);
    }
    path->origin = rnd_leave(surface, sample.wi);
    path->direction = sample.wi;
    path->pdf = sample.pdf;
    path->delta = sample.delta;
    return glms_vec3_max(path->throughput) > 0.0f;
}

/* --- waves --- */

/* All surfaces of a step. Leaves in alive the paths that go on and returns their number. */
static uint32_t shade(struct rnd_tracer *tracer, struct rnd_path *paths, uint32_t count, int depth,
                      uint32_t *out_shadows)
{
    const struct rnd_scene *scene = tracer->scene;
    const uint32_t dimension = RND_DIMENSION_PATH + DIM_COUNT * (uint32_t)depth;
    const bool last = tracer->max_bounces > 0 && depth >= tracer->max_bounces;
    uint32_t alive = 0, shadows = 0;
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t p = tracer->alive[i];
        const struct rnd_hit *hit = &tracer->hit[i];
        struct rnd_path *path = &paths[p];
        if (hit->mesh == RTC_INVALID_GEOMETRY_ID) {
            add_sky(&scene->lights, path);
            continue;
        }
        struct rnd_surface surface;
        rnd_surface_at(scene, hit, path->direction, &surface);
        path->throughput = glms_vec3_mul(path->throughput, rnd_transmittance(&surface, hit->distance));
        add_emission(scene, path, &surface, hit);
        if (last) continue;
        if (choose_light(scene, path, &surface, dimension, &tracer->shadow[shadows], &tracer->ray[shadows]))
            tracer->shadow[shadows++].path = p;
        if (bounce(path, &surface, depth, dimension)) tracer->alive[alive++] = p;
    }
    *out_shadows = shadows;
    return alive;
}

uint64_t rnd_trace(struct rnd_tracer *tracer, struct rnd_path *paths, uint32_t count)
{
    uint64_t rays = 0;
    for (uint32_t i = 0; i < count; i++) {
        paths[i].radiance = glms_vec3_zero();
        paths[i].throughput = glms_vec3_one();
        paths[i].delta = true;
        tracer->alive[i] = i;
    }
    for (int depth = 0; count > 0; depth++) {
        uint32_t shadows;
        rays += count;
        (depth == 0 ? intersect_coherent : intersect_scattered)(tracer, paths, count);
        count = shade(tracer, paths, count, depth, &shadows);
        rays += shadows;
        occlude(tracer, paths, shadows);
    }
    return rays;
}
