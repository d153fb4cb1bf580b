/* A look around before the work: how much of each group of lights really arrives.
 *
 * A shading point asks one group for light. The noise is least when each is asked as often as the root mean
 * square of what it then gives (Veach 1997, section 9.2), and that is not its power: most of a sky is hidden
 * from a room. A few thousand paths from the eye ask all groups at every point and see. What they find
 * changes the noise and never the mean.
 */
#include "path/shade.h"
#include "render.h"
#include "sampler.h"

enum { PATHS = 4096, BOUNCES = 3, SEED = 0x5eed };

/* No group is asked less often than this share of an even choice: the survey may have missed a place. */
#define LEAST 0.2f

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

/* What a group gives to a surface if it is asked: luminance, weighted as the integrator weights it. */
static float ask(const struct rnd_scene *scene, int group, const struct rnd_surface *surface, vec3s wo,
                 const float u[4])
{
    struct rnd_light_sample light;
    float pdf;
    const vec3s p = surface->position;
    if (!rnd_light_draw(scene, group, rnd_v3(p.x, p.y, p.z), u, &light)) return 0.0f;
    const vec3s to = {{light.direction.x, light.direction.y, light.direction.z}},
                radiance = {{light.radiance.x, light.radiance.y, light.radiance.z}};
    const vec3s f = glms_vec3_mul(rnd_bsdf(surface, wo, to, &pdf), radiance);
    const float given =
        rnd_luminance(f.raw) / light.pdf * (light.delta ? 1.0f : rnd_power_heuristic(light.pdf, pdf));
    if (!(given > 0.0f)) return 0.0f;
    struct RTCIntersectContext context;
    const vec3s from = rnd_leave(surface, to);
    struct RTCRay shadow = ray(from, to, INFINITY);
    if (light.distance < INFINITY) { /* to the very place on it, as shadows go in the integrator */
        const vec3s rest = glms_vec3_sub(glms_vec3_muladds(to, light.distance, p), from);
        shadow = ray(from, glms_vec3_normalize(rest), glms_vec3_norm(rest) * (1.0f - 1e-4f));
    }
    rtcInitIntersectContext(&context);
    rtcOccluded1(scene->tree, &context, &shadow);
    return shadow.tfar < 0.0f ? 0.0f : given;
}

static void walk(const struct rnd_scene *scene, const float eye[3], uint32_t index,
                 float square[RND_LIGHT_GROUPS])
{
    float u[4];
    rnd_pair(SEED, 0, index, u);
    vec3s origin = rnd_vec(eye), direction, throughput = glms_vec3_one();
    rnd_direction(2.0f * (float)M_PI * u[0], asinf(2.0f * u[1] - 1.0f), direction.raw);
    for (uint32_t depth = 0; depth < BOUNCES; depth++) {
        struct RTCIntersectContext context;
        struct RTCRayHit hit = {.ray = ray(origin, direction, INFINITY),
                                .hit = {.geomID = RTC_INVALID_GEOMETRY_ID}};
        rtcInitIntersectContext(&context);
        rtcIntersect1(scene->tree, &context, &hit);
        if (hit.hit.geomID == RTC_INVALID_GEOMETRY_ID) return;

        struct rnd_surface surface;
        struct rnd_bsdf_sample sample;
        uint32_t mesh;
        const struct rnd_instance *instance =
            rnd_resolve_hit(scene, hit.hit.geomID, hit.hit.instID[0], &mesh);
        rnd_surface_at(scene,
                       &(struct rnd_hit){.mesh = mesh,
                                         .instance = instance,
                                         .triangle = hit.hit.primID,
                                         .u = hit.hit.u,
                                         .v = hit.hit.v,
                                         .distance = hit.ray.tfar,
                                         .normal = {{hit.hit.Ng_x, hit.hit.Ng_y, hit.hit.Ng_z}}},
                       direction, &surface);
        const vec3s wo = glms_vec3_negate(direction);
        for (int g = 0; g < RND_LIGHT_GROUPS; g++) {
            if (!scene->lights.has[g]) continue;
            rnd_pair(SEED, 1 + 8 * depth + 2 * (uint32_t)g, index, u);
            rnd_pair(SEED, 2 + 8 * depth + 2 * (uint32_t)g, index, u + 2);
            const float given = ask(scene, g, &surface, wo, u) * rnd_luminance(throughput.raw);
            square[g] += given * given;
        }
        rnd_pair(SEED, 100 + 2 * depth, index, u);
        rnd_pair(SEED, 101 + 2 * depth, index, u + 2);
        if (!rnd_bsdf_draw(&surface, wo, u, &sample)) return;
        throughput = glms_vec3_mul(throughput, sample.weight);
        origin = rnd_leave(&surface, sample.wi);
        direction = sample.wi;
    }
}

struct survey {
    const struct rnd_scene *scene;
    const float *eye;
    int workers;
    float square[PATHS][RND_LIGHT_GROUPS]; /* of what each path was given; summed in their order, by one */
};

/* One thread's share of the paths. */
static void walk_share(void *context, int worker)
{
    struct survey *survey = context;
    const uint32_t first = (uint32_t)(PATHS * worker / survey->workers),
                   end = (uint32_t)(PATHS * (worker + 1) / survey->workers);
    for (uint32_t i = first; i < end; i++) walk(survey->scene, survey->eye, i, survey->square[i]);
}

void rnd_survey_lights(const struct rnd_scene *scene, const float eye[3], struct rnd_pool *pool, int workers,
                       float out_choose[RND_LIGHT_GROUPS])
{
    struct survey survey = {.scene = scene, .eye = eye, .workers = workers};
    const bool *has = scene->lights.has;
    double root[RND_LIGHT_GROUPS] = {0}, sum = 0.0;
    int groups = 0;
    rnd_pool_run(pool, walk_share, &survey);
    for (int g = 0; g < RND_LIGHT_GROUPS; g++) {
        for (uint32_t i = 0; i < PATHS; i++) root[g] += (double)survey.square[i][g];
        sum += root[g] = sqrt(root[g]);
        groups += has[g];
    }
    for (int g = 0; g < RND_LIGHT_GROUPS; g++) {
        const float even = 1.0f / (float)groups, share = sum > 0.0 ? (float)(root[g] / sum) : even;
        out_choose[g] = has[g] ? LEAST * even + (1.0f - LEAST) * share : 0.0f;
    }
}
