/* The survey: before the first batch, a few thousand paths measure how much light each group of lights, each
 * region of the environment and each part of the emitters gives around the camera.
 *
 * A shading point asks one group for light. Noise is least if each group is asked in proportion to the root
 * mean square of what it gives (Veach 1997, section 9.2). That differs from the group's power: most of a sky
 * is hidden from a room. The same holds for regions of the environment, which a room sees through its
 * windows, and for the emitters of a house, most of which are in other rooms. The paths of the survey start
 * at the camera and ask all groups at every point. The survey changes the noise of the picture, and never its
 * mean. */
#include "path/survey.h"
#include "path/clear.h"
#include "light/env.h"
#include "light/light.h"
#include "path/ray.h"
#include "material/closure.h"
#include "math/sampler.h"

#include <stdatomic.h>
#include <stdlib.h>

enum { PATHS = 4096, BOUNCES = 3, SEED = 0x5eed };

/* The survey may have missed a place. So a group is asked at least this share as often as if all groups were
 * asked equally, a region at least this share as often as by its weight, and an emitter at least this share
 * as often as by its power. */
#define LEAST_OF_GROUP   0.2f
#define LEAST_OF_REGION  0.1f
#define LEAST_OF_EMITTER 0.2f

/* What a path found at a step. */
struct step {
    float given[RND_LIGHT_GROUPS];    /* luminance that each group gave when asked */
    uint32_t asked[RND_LIGHT_GROUPS]; /* part of the group, or region, that was drawn */
    /* Two estimates of the light that the environment would give if it were white: from the region that was
     * asked, and from the region that the path escaped to. MIS weights them so that their sum is unbiased. */
    uint32_t left;
    float arrived, escaped;
};

struct survey {
    const struct rnd_scene *scene;
    const struct rnd_camera *camera;
    struct rnd_light_choice choice;   /* how often groups and their lights are asked */
    struct step step[PATHS][BOUNCES]; /* one thread sums them in this order */
};

static struct RTCRayHit ray(vec3s origin, vec3s direction, float far)
{
    return rnd_ray(rnd_v3(origin.x, origin.y, origin.z), rnd_v3(direction.x, direction.y, direction.z), 0.0f,
                   far);
}

/* Share of the light along a shadow ray that reaches a surface through clear glass. Surfaces of glass get
 * none through other glass. */
static float through_glass(const struct rnd_scene *scene, const struct rnd_surface *surface,
                           const struct RTCRay *shadow)
{
    const struct rnd_v3 from = {shadow->org_x, shadow->org_y, shadow->org_z},
                        to = {shadow->dir_x, shadow->dir_y, shadow->dir_z};
    bool any;
    if (surface->material->kind == RND_RICH && surface->material->transmission > 0.0f)
        return rnd_clear_is_free(scene, from, to, shadow->tfar) ? 1.0f : 0.0f;
    return rnd_v3_luminance(rnd_clear_transmittance(scene, 0, from, to, shadow->tfar, &any));
}

/* A point of a path. */
struct vertex {
    float distance; /* of the ray that found it, m */
    struct rnd_surface surface;
    struct rnd_closure closure;
};

/* Where a ray that leaves the point in that direction begins. */
static vec3s leave_surface(const struct vertex *at, vec3s direction)
{
    const struct rnd_v3 p = rnd_to_v3(at->surface.position),
                        step = rnd_step_off(p, at->distance, rnd_to_v3(at->surface.geometric),
                                            rnd_to_v3(direction));
    return rnd_from_v3(rnd_v3_add(p, step));
}

/* Luminance that a group gives to a point if it is asked, with the integrator's MIS weights. (Where glass is
 * clear the weights are approximate.) *out_light is the light that was drawn, if it gives anything. */
static float ask(const struct survey *survey, int group, const struct vertex *at, const float u[4],
                 struct rnd_light_sample *out_light)
{
    const struct rnd_scene *scene = survey->scene;
    const vec3s p = at->surface.position;
    float pdf;
    if (!rnd_light_draw(scene, &survey->choice, group, rnd_to_v3(p), u, out_light)) return 0.0f;
    const struct rnd_light_sample *light = out_light;
    const vec3s to = rnd_from_v3(light->direction);
    const vec3s f = glms_vec3_mul(rnd_closure_evaluate(&at->closure, to, &pdf), rnd_from_v3(light->radiance));
    const float given =
        rnd_luminance(f.raw) / light->pdf * (light->delta ? 1.0f : rnd_power_heuristic(light->pdf, pdf));
    if (!(given > 0.0f)) return 0.0f;
    const vec3s from = leave_surface(at, to);
    struct RTCRay shadow = ray(from, to, INFINITY).ray;
    if (light->distance < INFINITY) { /* to the drawn point of the light, as in the integrator */
        const vec3s rest = glms_vec3_sub(glms_vec3_muladds(to, light->distance, p), from);
        shadow = ray(from, glms_vec3_normalize(rest), glms_vec3_norm(rest) * (1.0f - 1e-4f)).ray;
    }
    if (rnd_embree_occluded1(scene->tree, &shadow)) return 0.0f;
    return scene->clear_tree ? given * through_glass(scene, &at->surface, &shadow) : given;
}

/* The path escaped along a direction that was drawn with density pdf; 0: it was the only possible direction.
 */
static void leave(const struct rnd_env *env, vec3s direction, float pdf, float throughput, struct step *step)
{
    float other;
    rnd_env_radiance(env, rnd_v3(direction.x, direction.y, direction.z), &step->left, &other);
    step->escaped = throughput * (pdf > 0.0f ? rnd_power_heuristic(pdf, other) : 1.0f);
}

/* The surface that a ray hit, with its textures at their finest level. */
static void meet(const struct rnd_scene *scene, const struct RTCRayHit *hit, uint32_t seed,
                 struct vertex *out)
{
    struct rnd_filter filter = {.footprint = 0.0f};
    struct rnd_facing facing;
    const struct rnd_point point = rnd_point_of(scene, hit, &facing);
    rnd_dither(SEED, seed, 0, &filter.pick[0], &filter.pick[1]);
    out->distance = hit->ray.tfar;
    rnd_surface_at(scene, &point, &facing, &filter, &out->surface);
    rnd_closure_at(&out->surface, rnd_from_v3(rnd_v3_scale(facing.direction, -1.0f)), &out->closure);
}

static void walk(const struct survey *survey, uint32_t index, struct step step[BOUNCES])
{
    const struct rnd_scene *scene = survey->scene;
    const struct rnd_env *env = scene->lights.env;
    float u[4], pdf = 0.0f;
    rnd_pair(SEED, 0, index, u);
    vec3s origin = rnd_vec(survey->camera->position), direction, throughput = glms_vec3_one();
    rnd_direction(2.0f * (float)M_PI * u[0], asinf(2.0f * u[1] - 1.0f), direction.raw);
    for (uint32_t depth = 0; depth <= BOUNCES; depth++) {
        struct RTCRayHit hit = ray(origin, direction, INFINITY);
        rnd_embree_intersect1(scene->tree, &hit);
        if (hit.hit.geomID == RTC_INVALID_GEOMETRY_ID) {
            if (env && depth > 0) leave(env, direction, pdf, rnd_luminance(throughput.raw), &step[depth - 1]);
            return;
        }
        if (depth == BOUNCES) return;

        struct vertex at;
        struct rnd_scattered sample;
        struct rnd_light_sample light;
        meet(scene, &hit, rnd_hash2(index, depth), &at);
        for (int g = 0; g < RND_LIGHT_GROUPS; g++) {
            if (!scene->lights.has[g]) continue;
            rnd_pair(SEED, 1 + 8 * depth + 2 * (uint32_t)g, index, u);
            rnd_pair(SEED, 2 + 8 * depth + 2 * (uint32_t)g, index, u + 2);
            const float given = ask(survey, g, &at, u, &light) * rnd_luminance(throughput.raw);
            if (!(given > 0.0f)) continue;
            step[depth].given[g] = given;
            step[depth].asked[g] = light.part;
            if (g == RND_LIGHT_ENV) step[depth].arrived = given / rnd_v3_luminance(light.radiance);
        }
        rnd_pair(SEED, 100 + 2 * depth, index, u);
        rnd_pair(SEED, 101 + 2 * depth, index, u + 2);
        if (!rnd_closure_sample(&at.closure, u, &sample)) return;
        throughput = glms_vec3_mul(throughput, sample.weight);
        origin = leave_surface(&at, sample.wi);
        direction = sample.wi;
        pdf = sample.delta ? 0.0f : sample.pdf;
    }
}

/* Walk paths first to end. */
static void walk_some(void *context, uint32_t first, uint32_t end)
{
    struct survey *survey = context;
    for (uint32_t i = first; i < end; i++) walk(survey, i, survey->step[i]);
}

/* --- what was found --- */

/* Solid angle of a region, sr. */
static double angle_of(const struct rnd_env *env, const struct rnd_env_region *r)
{
    if (r->texels == 0) return 0.0;
    const double down = M_PI / env->height, rows = (double)r->texels / r->width;
    return 2.0 * M_PI * r->width / env->width * (cos(down * r->y) - cos(down * (r->y + rows)));
}

/* Mean over a region and its eight neighbours of what they give per steradian. So few paths know too little
 * of a single region. */
static double around(const double sum[RND_ENV_REGIONS], const double angle[RND_ENV_REGIONS], int number)
{
    const int column = number % RND_ENV_COLUMNS, row = number / RND_ENV_COLUMNS;
    double given = 0.0, seen = 0.0;
    for (int y = row > 0 ? row - 1 : 0; y <= row + 1 && y < RND_ENV_ROWS; y++)
        for (int dx = -1; dx <= 1; dx++) {
            const int i = y * RND_ENV_COLUMNS + (column + dx + RND_ENV_COLUMNS) % RND_ENV_COLUMNS;
            given += sum[i];
            seen += angle[i];
        }
    return seen > 0.0 ? given / seen : 0.0;
}

/* Choose regions by their weight times the square root of the share of their light that arrives. */
static void choose_regions(const struct survey *survey, struct rnd_env_choice *out)
{
    const struct rnd_env *env = survey->scene->lights.env;
    double sum[RND_ENV_REGIONS] = {0}, angle[RND_ENV_REGIONS], root[RND_ENV_REGIONS], all = 0.0;
    float probability[RND_ENV_REGIONS];
    for (int i = 0; i < PATHS; i++)
        for (int k = 0; k < BOUNCES; k++) {
            const struct step *step = &survey->step[i][k];
            sum[step->asked[RND_LIGHT_ENV]] += (double)step->arrived;
            sum[step->left] += (double)step->escaped;
        }
    for (int i = 0; i < RND_ENV_REGIONS; i++) angle[i] = angle_of(env, &env->region[i]);
    for (int i = 0; i < RND_ENV_REGIONS; i++)
        all += root[i] = (double)env->weight[i] * sqrt(around(sum, angle, i));
    for (int i = 0; i < RND_ENV_REGIONS; i++)
        probability[i] = LEAST_OF_REGION * env->weight[i] +
                         (all > 0.0 ? (1.0f - LEAST_OF_REGION) * (float)(root[i] / all) : 0.0f);
    if (!rnd_env_choose(env, probability, out)) *out = env->by_weight;
}

/* Choose emitters by their power times the root mean square of what emitters of their part gave per power.
 * out_factor: for each part, how many times more often it is drawn than by power. */
static void choose_emitters(const struct survey *survey, int group, struct rnd_light_choice *out,
                            float out_factor[RND_LIGHT_PARTS])
{
    const struct rnd_emitters *emitters = &survey->scene->lights.emitters[group];
    const struct rnd_alias *by_power = &emitters->by_power;
    double power[RND_LIGHT_PARTS] = {0}, root[RND_LIGHT_PARTS] = {0}, all = 0.0;
    for (uint32_t i = 0; i < by_power->count; i++)
        power[emitters->part[i]] += (double)by_power->probability[i];
    for (int i = 0; i < PATHS; i++)
        for (int k = 0; k < BOUNCES; k++) {
            const struct step *step = &survey->step[i][k];
            root[step->asked[group]] += (double)step->given[group] * (double)step->given[group];
        }
    for (int i = 0; i < RND_LIGHT_PARTS; i++) all += root[i] = sqrt(root[i] * power[i]);
    for (int i = 0; i < RND_LIGHT_PARTS; i++)
        out_factor[i] = all > 0.0 && power[i] > 0.0
                            ? LEAST_OF_EMITTER + (1.0f - LEAST_OF_EMITTER) * (float)(root[i] / power[i] / all)
                            : 1.0f;
    float *probability = malloc(by_power->count * sizeof *probability);
    struct rnd_alias own = {0};
    for (uint32_t i = 0; probability && i < by_power->count; i++)
        probability[i] = by_power->probability[i] * out_factor[emitters->part[i]];
    if (probability && rnd_alias_init(&own, probability, by_power->count)) {
        rnd_alias_finish(&out->own[group]);
        out->own[group] = own;
        out->emitters[group] = &out->own[group];
    } else { /* memory is short: keep the choice by power */
        for (int i = 0; i < RND_LIGHT_PARTS; i++) out_factor[i] = 1.0f;
    }
    free(probability);
}

/* factor: for each part of a group, how many times more often it is drawn than the survey drew it. */
static void choose_groups(const struct survey *survey, const float *factor[RND_LIGHT_GROUPS],
                          struct rnd_light_choice *out)
{
    const bool *has = survey->scene->lights.has;
    double root[RND_LIGHT_GROUPS] = {0}, sum = 0.0;
    int groups = 0;
    for (int g = 0; g < RND_LIGHT_GROUPS; g++) {
        for (uint32_t i = 0; i < PATHS; i++) {
            double path = 0.0;
            for (int k = 0; k < BOUNCES; k++) {
                const struct step *step = &survey->step[i][k];
                const double square = (double)step->given[g] * (double)step->given[g];
                /* a part that is drawn more often gives less each time */
                path += factor[g] && square > 0.0 ? square / (double)factor[g][step->asked[g]] : square;
            }
            root[g] += path;
        }
        sum += root[g] = sqrt(root[g]);
        groups += has[g];
    }
    for (int g = 0; g < RND_LIGHT_GROUPS; g++) {
        const float even = 1.0f / (float)groups, share = sum > 0.0 ? (float)(root[g] / sum) : even;
        out->group[g] = has[g] ? LEAST_OF_GROUP * even + (1.0f - LEAST_OF_GROUP) * share : 0.0f;
    }
}

void rnd_survey_lights(const struct rnd_scene *scene, const struct rnd_camera *camera, struct rnd_pool *pool,
                       struct rnd_light_choice *out)
{
    struct survey survey = {.scene = scene, .camera = camera};
    float emitters[RND_LIGHT_GROUPS][RND_LIGHT_PARTS];
    const float *factor[RND_LIGHT_GROUPS] = {0};
    rnd_light_choose_evenly(&scene->lights, out);
    survey.choice = *out;
    rnd_pool_share(pool, PATHS, 64, walk_some, &survey);
    if (scene->lights.env) choose_regions(&survey, &out->env), factor[RND_LIGHT_ENV] = out->env.factor;
    for (int g = 0; g < RND_LIGHT_GROUPS; g++)
        if (scene->lights.emitters[g].by_power.count > 1)
            choose_emitters(&survey, g, out, emitters[g]), factor[g] = emitters[g];
    choose_groups(&survey, factor, out);
}
