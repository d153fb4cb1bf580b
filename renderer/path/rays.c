/* Rays and Embree: the only place where it traces. Whole waves go as streams over the arrays that they are
 * in: of packets, single rays and streams this is the fastest or as fast, and nothing is copied. */
#include "path/tape.h"
#include "path/wave.h"

void rnd_rays_init(struct rnd_tracer *tracer)
{
    struct rnd_ray_rest *rest = &tracer->ray_rest;
    for (uint32_t i = 0; i < RND_WAVE; i++) {
        rest->zero[i] = 0.0f;
        rest->nothing[i] = 0;
        rest->all[i] = UINT32_MAX;
    }
}

void rnd_intersect(struct rnd_tracer *tracer, struct rnd_paths *paths, uint32_t count, bool coherent)
{
    struct rnd_hits *hits = &tracer->hits;
    struct rnd_ray_rest *rest = &tracer->ray_rest;
    struct RTCIntersectContext context;
    struct RTCRayHitNp stream = {
        .ray = {.org_x = paths->origin.x,
                .org_y = paths->origin.y,
                .org_z = paths->origin.z,
                .tnear = rest->zero,
                .dir_x = paths->direction.x,
                .dir_y = paths->direction.y,
                .dir_z = paths->direction.z,
                .time = rest->zero,
                .tfar = hits->distance,
                .mask = rest->all,
                .id = rest->nothing,
                .flags = rest->nothing},
        .hit = {.Ng_x = hits->normal.x,
                .Ng_y = hits->normal.y,
                .Ng_z = hits->normal.z,
                .u = hits->u,
                .v = hits->v,
                .primID = hits->primitive,
                .geomID = hits->geometry,
                .instID = {hits->instance}},
    };
    for (uint32_t i = 0; i < count; i++) {
        hits->distance[i] = INFINITY;
        hits->geometry[i] = hits->instance[i] = RTC_INVALID_GEOMETRY_ID;
    }
    rtcInitIntersectContext(&context);
    context.flags = coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    tracer->rays += count;
    if (tracer->tape) rnd_tape_intersect(tracer->tape, context.flags, &stream, count);
    rtcIntersectNp(tracer->scene->tree, &context, &stream, count);
}

void rnd_occlude(struct rnd_tracer *tracer)
{
    struct RTCIntersectContext context;
    if (tracer->shadows == 0) return;
    tracer->rays += tracer->shadows;
    rtcInitIntersectContext(&context);
    if (tracer->tape) rnd_tape_occlude(tracer->tape, tracer->shadow_ray, tracer->shadows);
    rtcOccluded1M(tracer->scene->tree, &context, tracer->shadow_ray, tracer->shadows,
                  sizeof *tracer->shadow_ray);
    for (uint32_t i = 0; i < tracer->shadows; i++) {
        if (tracer->shadow_ray[i].tfar < 0.0f) continue;
        const struct rnd_shadow *s = &tracer->shadow[i];
        tracer->io->radiance[0][s->id] += s->radiance.x;
        tracer->io->radiance[1][s->id] += s->radiance.y;
        tracer->io->radiance[2][s->id] += s->radiance.z;
    }
}
