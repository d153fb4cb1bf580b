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

/* Rays from where they begin to distance. */
static struct RTCRayNp stream_of(struct rnd_ray_rest *rest, struct rnd_vectors *origin,
                                 struct rnd_vectors *direction, float *distance)
{
    return (struct RTCRayNp){.org_x = origin->x,
                             .org_y = origin->y,
                             .org_z = origin->z,
                             .tnear = rest->zero,
                             .dir_x = direction->x,
                             .dir_y = direction->y,
                             .dir_z = direction->z,
                             .time = rest->zero,
                             .tfar = distance,
                             .mask = rest->all,
                             .id = rest->nothing,
                             .flags = rest->nothing};
}

void rnd_intersect(struct rnd_tracer *tracer, struct rnd_paths *paths, uint32_t count, bool coherent)
{
    struct rnd_hits *hits = &tracer->hits;
    struct rnd_ray_rest *rest = &tracer->ray_rest;
    struct RTCIntersectContext context;
    struct RTCRayHitNp stream = {
        .ray = stream_of(rest, &paths->origin, &paths->direction, hits->distance),
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
    struct rnd_shadows *s = &tracer->shadows;
    struct RTCIntersectContext context;
    if (s->count == 0) return;
    tracer->rays += s->count;
    const struct RTCRayNp stream = stream_of(&tracer->ray_rest, &s->origin, &s->direction, s->distance);
    rtcInitIntersectContext(&context);
    if (tracer->tape) rnd_tape_occlude(tracer->tape, context.flags, &stream, s->count);
    rtcOccludedNp(tracer->scene->tree, &context, &stream, s->count);
    for (uint32_t i = 0; i < s->count; i++) {
        if (s->distance[i] < 0.0f) continue;
        tracer->io->radiance[0][s->id[i]] += s->radiance.x[i];
        tracer->io->radiance[1][s->id[i]] += s->radiance.y[i];
        tracer->io->radiance[2][s->id[i]] += s->radiance.z[i];
    }
}
