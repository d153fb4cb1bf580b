/* Rays and Embree: the only place where it traces. Whole waves go as streams over the arrays that they are
 * in: of packets, single rays and streams this is the fastest or as fast, and nothing is copied.
 *
 * What is one-sided is not there for an eye that looks at its back: glTF's back-face culling (glTF 2.0,
 * section 3.9.6), which speaks of what is seen. For light every surface has two sides, or walls that are
 * culled for a view into a room would let the sky in. */
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

/* --- backs --- */

struct eye_context {
    struct RTCIntersectContext embree;
    const struct rnd_scene *scene;
};

static const struct rnd_material *material_of(const struct rnd_scene *scene, uint32_t geometry,
                                              uint32_t instance)
{
    uint32_t mesh;
    rnd_resolve_hit(scene, geometry, instance, &mesh);
    return &scene->material[scene->mesh[mesh].material];
}

/* A single ray passes the backs of what is one-sided. It and the normal are both in the mesh's coordinates.
 */
static void pass_backs(const struct RTCFilterFunctionNArguments *args)
{
    const struct eye_context *context = (const struct eye_context *)args->context;
    const struct RTCRay *ray = (const struct RTCRay *)args->ray;
    const struct RTCHit *hit = (const struct RTCHit *)args->hit;
    const float along = ray->dir_x * hit->Ng_x + ray->dir_y * hit->Ng_y + ray->dir_z * hit->Ng_z;
    if (along > 0.0f && material_of(context->scene, hit->geomID, hit->instID[0])->one_sided)
        args->valid[0] = 0;
}

static bool is_back(const struct rnd_tracer *tracer, const struct rnd_paths *paths, uint32_t i)
{
    const struct rnd_scene *scene = tracer->scene;
    const struct rnd_hits *hits = &tracer->hits;
    struct rnd_v3 normal = rnd_get(&hits->normal, i);
    if (hits->geometry[i] == RTC_INVALID_GEOMETRY_ID) return false;
    if (hits->instance[i] != RTC_INVALID_GEOMETRY_ID)
        normal = rnd_normal_to_world(&scene->instance[hits->instance[i] - scene->mesh_count], normal);
    return rnd_v3_dot(normal, rnd_get(&paths->direction, i)) > 0.0f &&
           material_of(scene, hits->geometry[i], hits->instance[i])->one_sided;
}

void rnd_pass_backs(struct rnd_tracer *tracer, const struct rnd_paths *paths, uint32_t count)
{
    struct rnd_hits *hits = &tracer->hits;
    for (uint32_t i = 0; i < count; i++) {
        if (!is_back(tracer, paths, i)) continue;
        struct eye_context context = {.scene = tracer->scene};
        const struct rnd_v3 o = rnd_get(&paths->origin, i), d = rnd_get(&paths->direction, i);
        struct RTCRayHit again = {
            .ray = {.org_x = o.x,
                    .org_y = o.y,
                    .org_z = o.z,
                    .dir_x = d.x,
                    .dir_y = d.y,
                    .dir_z = d.z,
                    .tfar = INFINITY,
                    .mask = UINT32_MAX},
            .hit = {.geomID = RTC_INVALID_GEOMETRY_ID, .instID = {RTC_INVALID_GEOMETRY_ID}}};
        rtcInitIntersectContext(&context.embree);
        context.embree.filter = pass_backs;
        tracer->rays++;
        rtcIntersect1(tracer->scene->tree, &context.embree, &again);
        hits->distance[i] = again.ray.tfar;
        hits->u[i] = again.hit.u;
        hits->v[i] = again.hit.v;
        rnd_put(&hits->normal, i, rnd_v3(again.hit.Ng_x, again.hit.Ng_y, again.hit.Ng_z));
        hits->geometry[i] = again.hit.geomID;
        hits->primitive[i] = again.hit.primID;
        hits->instance[i] = again.hit.instID[0];
    }
}

/* --- shadows --- */

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
