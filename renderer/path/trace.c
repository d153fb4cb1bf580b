/* The path integrator. */
#include "path/trace.h"
#include "path/shade.h"
#include "sampler.h"

/* Bounces before Russian roulette begins: shorter paths carry most of the light. */
enum { SURE_BOUNCES = 3 };

/* Dimensions that a vertex of a path uses, from RND_DIMENSION_PATH on. */
enum { DIM_DIRECTION, DIM_LOBE, DIM_LIGHT, DIM_LIGHT_PLACE, DIM_COUNT };

/* Where a path is. */
struct walk {
    struct rnd_tracer *tracer;
    vec3s origin, direction;
    vec3s throughput, radiance;
    float pdf;  /* of the direction, per steradian */
    bool delta; /* the direction could not have been found by next-event estimation */
    uint32_t seed, index;
};

static struct RTCRay ray(vec3s origin, vec3s direction, float far)
{
    return (struct RTCRay){.org_x = origin.x,
                           .org_y = origin.y,
                           .org_z = origin.z,
                           .dir_x = direction.x,
                           .dir_y = direction.y,
                           .dir_z = direction.z,
                           .tfar = far,
                           .mask = UINT32_MAX};
}

/* Veach 1997, power heuristic with exponent 2. */
static float power_heuristic(float pdf, float other)
{
    const float r = other / pdf;
    return 1.0f / (1.0f + r * r);
}

static void add(struct walk *walk, vec3s radiance, float weight)
{
    walk->radiance =
        glms_vec3_add(walk->radiance, glms_vec3_scale(glms_vec3_mul(walk->throughput, radiance), weight));
}

/* The path left the scene: environment and sun. */
static void add_sky(struct walk *walk)
{
    const struct rnd_lights *lights = &walk->tracer->scene->lights;
    if (lights->env) {
        const float other = lights->choose[RND_LIGHT_ENV] * rnd_env_pdf(lights->env, walk->direction);
        add(walk, rnd_env_radiance(lights->env, walk->direction),
            walk->delta ? 1.0f : power_heuristic(walk->pdf, other));
    }
    const struct rnd_sun *sun = lights->sun;
    if (sun && sun->cos_radius < 1.0f && glms_vec3_dot(walk->direction, sun->direction) >= sun->cos_radius) {
        const float other = lights->choose[RND_LIGHT_SUN] * rnd_sun_pdf(sun);
        add(walk, sun->radiance, walk->delta ? 1.0f : power_heuristic(walk->pdf, other));
    }
}

/* The surface that the path hit shines itself. */
static void add_emission(struct walk *walk, const struct rnd_surface *surface, const struct RTCRayHit *hit)
{
    if (!(rnd_luminance(surface->emission.raw) > 0.0f)) return;
    float weight = 1.0f;
    if (!walk->delta)
        weight = power_heuristic(walk->pdf, rnd_area_pdf(walk->tracer->scene, hit->hit.geomID,
                                                         hit->hit.primID, walk->direction, hit->ray.tfar));
    add(walk, surface->emission, weight);
}

/* Next-event estimation: one light, seen or not. */
static void add_light(struct walk *walk, const struct rnd_surface *surface, uint32_t dimension)
{
    struct rnd_tracer *tracer = walk->tracer;
    struct rnd_light_sample light;
    float u[4], pdf;
    rnd_pair(walk->seed, dimension + DIM_LIGHT, walk->index, u);
    rnd_pair(walk->seed, dimension + DIM_LIGHT_PLACE, walk->index, u + 2);
    if (!rnd_light_draw(tracer->scene, surface->position, u, &light)) return;
    const vec3s f = rnd_bsdf(surface, glms_vec3_negate(walk->direction), light.direction, &pdf);
    if (!(rnd_luminance(f.raw) > 0.0f)) return;

    struct RTCIntersectContext context;
    struct RTCRay shadow =
        ray(rnd_leave(surface, light.direction), light.direction, light.distance * (1.0f - 1e-4f));
    rtcInitIntersectContext(&context);
    rtcOccluded1(tracer->scene->tree, &context, &shadow);
    tracer->rays++;
    if (shadow.tfar < 0.0f) return;
    add(walk, glms_vec3_mul(f, light.radiance),
        (light.delta ? 1.0f : power_heuristic(light.pdf, pdf)) / light.pdf);
}

/* Choose where the path goes on; false where it ends. */
static bool bounce(struct walk *walk, const struct rnd_surface *surface, int depth, uint32_t dimension)
{
    struct rnd_bsdf_sample sample;
    float u[4];
    rnd_pair(walk->seed, dimension + DIM_DIRECTION, walk->index, u);
    rnd_pair(walk->seed, dimension + DIM_LOBE, walk->index, u + 2);
    if (!rnd_bsdf_draw(surface, glms_vec3_negate(walk->direction), u, &sample)) return false;
    walk->throughput = glms_vec3_mul(walk->throughput, sample.weight);
    if (depth >= SURE_BOUNCES) {
        const float go_on = fminf(glms_vec3_max(walk->throughput), 0.95f);
        if (!(u[3] < go_on)) return false;
        walk->throughput = glms_vec3_scale(walk->throughput, 1.0f / go_on);
    }
    walk->origin = rnd_leave(surface, sample.wi);
    walk->direction = sample.wi;
    walk->pdf = sample.pdf;
    walk->delta = sample.delta;
    return glms_vec3_max(walk->throughput) > 0.0f;
}

vec3s rnd_trace(struct rnd_tracer *tracer, vec3s origin, vec3s direction, uint32_t seed, uint32_t index)
{
    struct walk walk = {.tracer = tracer,
                        .origin = origin,
                        .direction = direction,
                        .throughput = glms_vec3_one(),
                        .radiance = glms_vec3_zero(),
                        .delta = true,
                        .seed = seed,
                        .index = index};
    for (int depth = 0;; depth++) {
        const uint32_t dimension = RND_DIMENSION_PATH + DIM_COUNT * (uint32_t)depth;
        struct RTCIntersectContext context;
        struct RTCRayHit hit = {.ray = ray(walk.origin, walk.direction, INFINITY),
                                .hit = {.geomID = RTC_INVALID_GEOMETRY_ID}};
        hit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        rtcInitIntersectContext(&context);
        rtcIntersect1(tracer->scene->tree, &context, &hit);
        tracer->rays++;
        if (hit.hit.geomID == RTC_INVALID_GEOMETRY_ID) {
            add_sky(&walk);
            break;
        }
        struct rnd_surface surface;
        rnd_surface_at(tracer->scene, &hit, &surface);
        add_emission(&walk, &surface, &hit);
        if (tracer->max_bounces > 0 && depth >= tracer->max_bounces) break;
        if (surface.material->kind != RND_DIELECTRIC) add_light(&walk, &surface, dimension);
        if (!bounce(&walk, &surface, depth, dimension)) break;
    }
    return walk.radiance;
}
