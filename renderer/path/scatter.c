/* What surfaces do with light: the second half of next-event estimation, and the directions in which paths go
 * on.
 *
 * Diffuse and metallic-roughness surfaces are done here, many at a time, by vector instructions.
 * material/closure.h does all others, one point at a time. */
#include "path/scatter.h"
#include "material/ggx.h"
#include "material/closure.h"
#include "material/glass.h"
#include "light/light.h"

/* Bounces before Russian roulette begins. From then on a path survives with a probability that is the square
 * root of its throughput: more and shorter paths give as little noise in the same time. Only the throughput
 * behind the first surface counts. An eye judges dark surfaces by their own brightness, so their paths must
 * not end sooner than those of bright ones. */
enum { SURE_BOUNCES = 1 };

/* --- light that arrives --- */

/* What the chosen light contributes if it is not hidden. f is the BSDF times cosine, pdf the density with
 * which the surface would have drawn the light's direction. 0 if no light was chosen. */
RND_INLINE struct rnd_v3 contribution(struct rnd_tracer *tracer, size_t j, struct rnd_v3 f, float pdf)
{
    const struct rnd_light_choices *lights = &tracer->lights;
    const float chosen = lights->pdf[j], safe = rnd_larger(chosen, 1e-37f);
    const float both = lights->delta[j] ? 1.0f : rnd_power_heuristic(safe, pdf);
    const float weight = chosen > 0.0f ? both / safe : 0.0f;
    tracer->scatters.share[j] = both;
    return rnd_v3_scale(
        rnd_v3_mul(rnd_v3_mul(f, rnd_get(&lights->radiance, j)), rnd_get(&tracer->paths[1].throughput, j)),
        weight);
}

static void light_diffuse(struct rnd_tracer *tracer, uint32_t begin, uint32_t end)
{
    const struct rnd_surfaces *s = &tracer->surfaces;
    struct rnd_scatters *to = &tracer->scatters;
#pragma GCC ivdep
    for (size_t j = begin; j < end; j++) {
        const struct rnd_v3 wi = rnd_get(&tracer->lights.direction, j);
        const float cosine = rnd_v3_dot(wi, rnd_get(&s->normal, j)),
                    above = rnd_v3_dot(wi, rnd_get(&s->geometric, j));
        const float pdf = (cosine > 0.0f) & (above > 0.0f) ? cosine / RND_PI : 0.0f;
        rnd_put(&to->contribution, j, contribution(tracer, j, rnd_v3_scale(rnd_get(&s->base, j), pdf), pdf));
    }
}

/* --- where paths go on --- */

static void draw_diffuse(struct rnd_tracer *tracer, uint32_t begin, uint32_t end)
{
    const struct rnd_surfaces *s = &tracer->surfaces;
    struct rnd_scatters *to = &tracer->scatters;
#pragma GCC ivdep
    for (size_t j = begin; j < end; j++) {
        const struct rnd_v3_frame frame = rnd_v3_frame(rnd_get(&s->normal, j));
        const struct rnd_v3 local = rnd_draw_cosine(tracer->number[0][j], tracer->number[1][j]);
        const struct rnd_v3 wi = rnd_v3_to_world(&frame, local);
        const float above = rnd_v3_dot(wi, rnd_get(&s->geometric, j));
        rnd_put(&to->direction, j, wi);
        rnd_put(&to->weight, j, rnd_get(&s->base, j));
        to->pdf[j] = above > 0.0f ? local.z / RND_PI : -1.0f;
    }
}

RND_INLINE struct rnd_mr metal_rough_at(const struct rnd_surfaces *s, size_t j)
{
    return rnd_mr(rnd_get(&s->base, j), s->metallic[j], s->alpha[j], rnd_v3(s->f0[j], s->f0[j], s->f0[j]),
                  s->f90[j]);
}

/* For a point where part of the glossy lobe is below the triangle, and is folded onto the light's direction
 * or onto the drawn one. */
static void folded(struct rnd_tracer *tracer, size_t j)
{
    const struct rnd_surfaces *s = &tracer->surfaces;
    struct rnd_scatters *to = &tracer->scatters;
    const struct rnd_v3_frame frame = rnd_v3_frame(rnd_get(&s->normal, j));
    const struct rnd_v3 geometric = rnd_v3_to_local(&frame, rnd_get(&s->geometric, j)),
                        light = rnd_v3_to_local(&frame, rnd_get(&tracer->lights.direction, j)),
                        wo = rnd_v3_scale(rnd_v3_to_local(&frame, rnd_get(&tracer->paths[1].direction, j)),
                                          -1.0f);
    const struct rnd_mr m = metal_rough_at(s, j);
    struct rnd_v3 f, local, weight;
    float pdf;
    rnd_mr_eval_folded(&m, geometric, wo, light, &f, &pdf);
    rnd_put(&to->contribution, j, contribution(tracer, j, f, pdf));
    rnd_mr_draw_folded(&m, geometric, wo,
                       rnd_v3(tracer->number[0][j], tracer->number[1][j], tracer->number[2][j]), &local,
                       &weight, &pdf);
    rnd_put(&to->direction, j, rnd_v3_to_world(&frame, local));
    rnd_put(&to->weight, j, weight);
    to->pdf[j] = pdf > 0.0f ? pdf : -1.0f;
}

/* Light that arrives, and where paths go on, in one loop: both need the same terms, which take most of the
 * work. */
static void metal_rough(struct rnd_tracer *tracer, uint32_t begin, uint32_t end)
{
    const struct rnd_surfaces *s = &tracer->surfaces;
    struct rnd_scatters *to = &tracer->scatters;
    uint32_t *folds = tracer->scratch.scatter.folds, any = 0;
#pragma GCC ivdep
    for (size_t j = begin; j < end; j++) {
        const struct rnd_v3_frame frame = rnd_v3_frame(rnd_get(&s->normal, j));
        const struct rnd_v3 geometric = rnd_get(&s->geometric, j),
                            light = rnd_get(&tracer->lights.direction, j);
        const struct rnd_v3 wo =
            rnd_v3_scale(rnd_v3_to_local(&frame, rnd_get(&tracer->paths[1].direction, j)), -1.0f);
        const struct rnd_mr m = metal_rough_at(s, j);
        struct rnd_v3 f, local, weight;
        float light_pdf, pdf;
        const struct rnd_v3 local_light = rnd_v3_to_local(&frame, light);
        rnd_mr_eval(&m, wo, local_light, &f, &light_pdf);
        rnd_mr_draw(&m, wo, rnd_v3(tracer->number[0][j], tracer->number[1][j], tracer->number[2][j]), &local,
                    &weight, &pdf);
        const struct rnd_v3 wi = rnd_v3_to_world(&frame, local);
        const float height = rnd_v3_dot(light, geometric), lit = height > 0.0f ? 1.0f : 0.0f,
                    above = rnd_v3_dot(wi, geometric), twice = 2.0f * rnd_v3_dot(frame.z, geometric);
        /* folding adds to this direction if its mirror image is above the shading normal's plane */
        folds[j] = ((height > 0.0f) & (local_light.z > twice * height)) |
                   ((pdf > 0.0f) & ((above <= 0.0f) | (local.z > twice * above)));
        any |= folds[j];
        rnd_put(&to->contribution, j, contribution(tracer, j, rnd_v3_scale(f, lit), light_pdf));
        rnd_put(&to->direction, j, wi);
        rnd_put(&to->weight, j, weight);
        to->pdf[j] = (above > 0.0f) & (pdf > 0.0f) ? pdf : -1.0f;
    }
    for (uint32_t j = begin; any && j < end; j++)
        if (folds[j]) folded(tracer, j);
}

/* --- clear glass ---
 *
 * Where glass is clear, a surface draws lights through glass. A path that leaves the surface and then only
 * passes glass could find the same light by chance. That light is left out, because it has been counted.
 * Reflections on glass are not drawn that way, so paths go on finding them by chance. Glass itself draws no
 * light through other glass. */

/* A density so small that MIS gives no weight to a light that could have been drawn. A light that could not
 * have been drawn keeps its full weight. */
#define LEFT_OUT 1e-37f

/* Has the surface that the path came from already drawn the light of point j through this glass? */
static bool is_drawn_before(const struct rnd_tracer *tracer, uint32_t j)
{
    return tracer->scene->clear_tree && tracer->paths[1].stood_for[j] &&
           rnd_is_clear(tracer->scene, tracer->surfaces.mesh[j]) &&
           rnd_v3_dot(rnd_get(&tracer->lights.direction, j), rnd_get(&tracer->surfaces.geometric, j)) < 0.0f;
}

/* Note for points begin to end whether light that their paths find next has been drawn already. */
static void stand_for(struct rnd_tracer *tracer, uint32_t begin, uint32_t end)
{
    struct rnd_scatters *way = &tracer->scatters;
    uint32_t *stood_for = tracer->paths[1].stood_for;
    for (uint32_t j = begin; j < end; j++) {
        if (!rnd_is_clear(tracer->scene, tracer->surfaces.mesh[j])) {
            stood_for[j] = way->pdf[j] > 0.0f;
            continue;
        }
        const bool passes =
            rnd_v3_dot(rnd_get(&way->direction, j), rnd_get(&tracer->surfaces.geometric, j)) < 0.0f;
        stood_for[j] &= passes;
        if (stood_for[j] && way->pdf[j] >= 0.0f) way->pdf[j] = LEFT_OUT;
    }
}

/* --- rich materials: one at a time --- */

static void rich(struct rnd_tracer *tracer, uint32_t begin, uint32_t end)
{
    const struct rnd_light_choices *lights = &tracer->lights;
    struct rnd_scatters *to = &tracer->scatters;
    for (uint32_t j = begin; j < end; j++) {
        const struct rnd_surface *surface = &tracer->rich[j - begin];
        const vec3s wo = glms_vec3_negate(rnd_from_v3(rnd_get(&tracer->paths[1].direction, j)));
        struct rnd_closure closure;
        struct rnd_scattered sample;
        struct rnd_v3 light = {0, 0, 0};
        rnd_closure_at(surface, wo, &closure);
        if (lights->pdf[j] > 0.0f && !is_drawn_before(tracer, j)) {
            float pdf;
            const vec3s f = rnd_closure_evaluate(&closure, rnd_from_v3(rnd_get(&lights->direction, j)), &pdf);
            if (glms_vec3_max(f) > 0.0f) light = contribution(tracer, j, rnd_to_v3(f), pdf);
        }
        rnd_put(&to->contribution, j, light);
        const float u[3] = {tracer->number[0][j], tracer->number[1][j], tracer->number[2][j]};
        to->pdf[j] = -1.0f;
        if (!rnd_closure_sample(&closure, u, &sample)) continue;
        rnd_put(&to->direction, j, rnd_to_v3(sample.wi));
        rnd_put(&to->weight, j, rnd_to_v3(sample.weight));
        to->pdf[j] = sample.delta ? 0.0f : sample.pdf;
    }
}

/* --- stages --- */

/* The media that a ray from point j in that direction begins in. */
static rnd_media media_towards(const struct rnd_tracer *tracer, uint32_t j,
                               const struct rnd_vectors *direction)
{
    const struct rnd_surfaces *s = &tracer->surfaces;
    const bool above = rnd_v3_dot(rnd_get(direction, j), rnd_get(&s->geometric, j)) >= 0.0f;
    return above ? tracer->paths[1].media[j] : s->behind[j];
}

/* Weigh the chosen lights by the media on their way. Where glass is clear, pass_glass() does so after the
 * shadow ray. */
static void weigh_by_media(struct rnd_tracer *tracer, uint32_t count)
{
    struct rnd_vectors *light = &tracer->scatters.contribution;
    for (uint32_t j = 0; j < count; j++) {
        const rnd_media media = media_towards(tracer, j, &tracer->lights.direction);
        if (media)
            rnd_put(light, j,
                    rnd_v3_mul(rnd_get(light, j),
                               rnd_media_transmittance(tracer->scene, media, tracer->lights.distance[j])));
    }
}

/* The shadow rays of lights that bring something. */
static void cast_shadows(struct rnd_tracer *tracer, uint32_t count)
{
    const struct rnd_paths *paths = &tracer->paths[1];
    const struct rnd_surfaces *s = &tracer->surfaces;
    const struct rnd_light_choices *lights = &tracer->lights;
    struct rnd_shadows *to = &tracer->shadows;
    /* where glass is clear, light is clamped once the glass has weighed it */
    const float limit = tracer->scene->clear_tree ? INFINITY : rnd_firefly_limit(tracer, tracer->depth);
    uint32_t *order = tracer->scratch.scatter.lit, n = 0;
    for (uint32_t j = 0; j < count; j++) {
        order[n] = j;
        n += rnd_v3_luminance(rnd_get(&tracer->scatters.contribution, j)) > 0.0f;
    }
    to->count = n;
#pragma GCC ivdep
    for (size_t i = 0; i < n; i++) {
        const uint32_t j = order[i];
        const struct rnd_v3 p = rnd_get(&paths->origin, j), wi = rnd_get(&lights->direction, j);
        /* To the very place on the light: as long as from the surface itself, a ray that begins nearer to the
         * light would end behind it. */
        const struct rnd_v3 step = rnd_step_off(p, s->distance[j], rnd_get(&s->geometric, j), wi);
        const float far = lights->distance[j];
        const int ends = far < INFINITY;
        const struct rnd_v3 way = rnd_v3_sub(rnd_v3_scale(wi, ends ? far : 1.0f), step),
                            towards = rnd_v3_select(ends, way, wi);
        const float length = rnd_larger(sqrtf(rnd_v3_dot(towards, towards)), 1e-30f);
        rnd_put(&to->origin, i, rnd_v3_add(p, step));
        rnd_put(&to->direction, i, rnd_v3_scale(towards, 1.0f / length));
        to->distance[i] = (ends ? length : far) * (1.0f - 1e-4f);
        to->id[i] = paths->id[j];
        rnd_put(&to->radiance, i, rnd_clamp_firefly(rnd_get(&tracer->scatters.contribution, j), limit));
    }
    for (uint32_t i = 0; tracer->scene->clear_tree && i < n; i++)
        to->through[i] =
            rnd_is_clear(tracer->scene, s->mesh[order[i]]) ? 0.0f : 1.0f / tracer->scatters.share[order[i]];
    for (uint32_t i = 0; tracer->scene->clear_tree && rnd_has_media(tracer) && i < n; i++)
        to->media[i] = media_towards(tracer, order[i], &lights->direction);
}

/* Throughput after the surface, and Russian roulette: a density below zero ends the path. */
static void weigh(struct rnd_tracer *tracer, uint32_t count)
{
    struct rnd_paths *paths = &tracer->paths[1];
    struct rnd_scatters *to = &tracer->scatters;
    const float least = tracer->depth < SURE_BOUNCES ? 1.0f : 0.0f; /* all numbers are below 1 */
    const bool at_first = tracer->depth == 0;
#pragma GCC ivdep
    for (size_t j = 0; j < count; j++) {
        const struct rnd_v3 t = rnd_v3_mul(rnd_get(&paths->throughput, j), rnd_get(&to->weight, j));
        const float largest = rnd_v3_max(t), first = at_first ? largest : paths->first[j];
        const float left = sqrtf(largest / rnd_larger(first, 1e-37f)),
                    go_on = rnd_larger(rnd_smaller(left, 0.95f), least);
        paths->first[j] = first;
        const int on = (to->pdf[j] >= 0.0f) & (tracer->number[3][j] < go_on) & (largest > 0.0f);
        rnd_put(&paths->throughput, j, rnd_v3_scale(t, 1.0f / rnd_larger(go_on, 1e-37f)));
        to->pdf[j] = on ? to->pdf[j] : -1.0f;
    }
}

/* Move those that go on from paths 1 to paths 0. */
static uint32_t go_on(struct rnd_tracer *tracer, uint32_t count)
{
    const struct rnd_paths *from = &tracer->paths[1];
    const struct rnd_surfaces *s = &tracer->surfaces;
    const struct rnd_scatters *way = &tracer->scatters;
    struct rnd_paths *to = &tracer->paths[0];
    uint32_t *order = tracer->scratch.scatter.alive, alive = 0;
    for (uint32_t j = 0; j < count; j++) {
        order[alive] = j;
        alive += way->pdf[j] >= 0.0f;
    }
#pragma GCC ivdep
    for (size_t i = 0; i < alive; i++) {
        const uint32_t j = order[i];
        const struct rnd_v3 p = rnd_get(&from->origin, j), wi = rnd_get(&way->direction, j),
                            step = rnd_step_off(p, s->distance[j], rnd_get(&s->geometric, j), wi);
        rnd_put(&to->origin, i, rnd_v3_add(p, step));
        rnd_put(&to->direction, i, wi);
        to->pdf[i] = way->pdf[j];
        to->width[i] = from->width[j];
    }
#pragma GCC ivdep
    for (size_t i = 0; i < alive; i++) {
        const uint32_t j = order[i];
        to->throughput.x[i] = from->throughput.x[j];
        to->throughput.y[i] = from->throughput.y[j];
        to->throughput.z[i] = from->throughput.z[j];
        to->first[i] = from->first[j];
        to->seed[i] = from->seed[j];
        to->index[i] = from->index[j];
        to->id[i] = from->id[j];
    }
    for (uint32_t i = 0; tracer->scene->clear_tree && i < alive; i++)
        to->stood_for[i] = from->stood_for[order[i]];
    for (uint32_t i = 0; rnd_has_media(tracer) && i < alive; i++)
        to->media[i] = media_towards(tracer, order[i], &way->direction);
    return alive;
}

uint32_t ISA(rnd_scatter)(struct rnd_tracer *tracer, uint32_t count)
{
    const uint32_t *end = tracer->surfaces.end;
    /* on diffuse surfaces only roulette asks for the second pair */
    const uint32_t lobes = tracer->depth >= SURE_BOUNCES ? 0 : end[RND_DIFFUSE];
    rnd_draw_numbers(tracer, RND_DIM_DIRECTION, 0, count, tracer->number[0], tracer->number[1]);
    rnd_draw_numbers(tracer, RND_DIM_LOBE, lobes, count, tracer->number[2], tracer->number[3]);
    light_diffuse(tracer, 0, end[RND_DIFFUSE]);
    draw_diffuse(tracer, 0, end[RND_DIFFUSE]);
    metal_rough(tracer, end[RND_DIFFUSE], end[RND_METAL_ROUGH]);
    rich(tracer, end[RND_METAL_ROUGH], end[RND_RICH]);
    if (tracer->scene->clear_tree) stand_for(tracer, 0, count);
    if (rnd_has_media(tracer) && !tracer->scene->clear_tree) weigh_by_media(tracer, count);
    cast_shadows(tracer, count);
    weigh(tracer, count);
    return go_on(tracer, count);
}
