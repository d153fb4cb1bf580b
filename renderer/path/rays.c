/* The rays of a wave go to Embree together, in the arrays that hold them.
 *
 * A camera that sees the back of a one-sided surface sees through it: this is glTF's back-face culling
 * (glTF 2.0, section 3.9.6), which concerns what is seen. Light meets both sides of every surface.
 * Otherwise a wall that is culled so that a room can be looked into would let the sky in.
 */
#include "path/rays.h"
#include "path/clear.h"
#include "path/ray.h"
#include "path/tape.h"

_Static_assert((int)RND_WAVE <= (int)RND_EMBREE_RAYS, "a wave goes to Embree in one call");

static struct rnd_embree_rays rays_of(struct rnd_vectors *origin, struct rnd_vectors *direction,
                                      float *distance)
{
    return (struct rnd_embree_rays){
        {origin->x, origin->y, origin->z}, {direction->x, direction->y, direction->z}, distance};
}

void rnd_intersect(struct rnd_tracer *tracer, struct rnd_paths *paths, uint32_t count, bool coherent)
{
    struct rnd_hits *to = &tracer->hits;
    const struct rnd_embree_rays rays = rays_of(&paths->origin, &paths->direction, to->distance);
    const struct rnd_embree_hits hits = {
        {to->normal.x, to->normal.y, to->normal.z}, to->u, to->v, to->geometry, to->primitive, to->instance};
    tracer->rays += count;
    if (tracer->tape) rnd_tape_intersect(tracer->tape, coherent, &rays, count);
    rnd_embree_intersect(tracer->scene->tree, coherent, &rays, &hits, count);
}

/* --- backs --- */

struct camera_context {
    struct rnd_query query; /* first member: Embree passes a pointer to it */
    const struct rnd_scene *scene;
};

static const struct rnd_material *material_of(const struct rnd_scene *scene, uint32_t geometry,
                                              uint32_t instance)
{
    uint32_t mesh;
    rnd_resolve_hit(scene, geometry, instance, &mesh);
    return &scene->material[scene->mesh[mesh].material];
}

/* Let a single ray pass the backs of one-sided surfaces. The ray and the normal are both in the mesh's
 * coordinates. */
static void pass_backs(const struct RTCFilterFunctionNArguments *args)
{
    const struct camera_context *context = (const struct camera_context *)args->context;
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
        struct camera_context context = {.scene = tracer->scene};
        struct RTCRayHit again =
            rnd_ray(rnd_get(&paths->origin, i), rnd_get(&paths->direction, i), 0.0f, INFINITY);
        tracer->rays++;
        rnd_embree_intersect1_filtered(tracer->scene->tree, &context.query, pass_backs, &again);
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

/* Weigh a shadow ray that found nothing but clear glass in its way. */
static void pass_glass(struct rnd_tracer *tracer, uint32_t i)
{
    struct rnd_shadows *s = &tracer->shadows;
    const struct rnd_v3 from = rnd_get(&s->origin, i), to = rnd_get(&s->direction, i);
    const rnd_media media = rnd_has_media(tracer) ? s->media[i] : 0;
    struct rnd_v3 left = {0, 0, 0};
    bool any;
    if (s->through[i] > 0.0f) {
        left = rnd_clear_transmittance(tracer->scene, media, from, to, s->distance[i], &any);
        if (any) left = rnd_v3_scale(left, s->through[i]);
    } else if (rnd_clear_is_free(tracer->scene, from, to, s->distance[i])) {
        left = rnd_media_transmittance(tracer->scene, media, s->distance[i]);
    }
    rnd_put(&s->radiance, i,
            rnd_clamp_firefly(rnd_v3_mul(rnd_get(&s->radiance, i), left),
                              rnd_firefly_limit(tracer, tracer->depth)));
}

void rnd_occlude(struct rnd_tracer *tracer)
{
    struct rnd_shadows *s = &tracer->shadows;
    struct rnd_wave_io *io = tracer->io;
    const struct rnd_embree_rays rays = rays_of(&s->origin, &s->direction, s->distance);
    if (s->count == 0) return;
    tracer->rays += s->count;
    if (tracer->tape) rnd_tape_occlude(tracer->tape, &rays, s->count);
    rnd_embree_occluded(tracer->scene->tree, &rays, s->count);
    for (uint32_t i = 0; i < s->count; i++) {
        if (s->distance[i] < 0.0f) continue;
        if (tracer->scene->clear_tree) pass_glass(tracer, i);
        io->radiance[0][s->id[i]] += s->radiance.x[i];
        io->radiance[1][s->id[i]] += s->radiance.y[i];
        io->radiance[2][s->id[i]] += s->radiance.z[i];
    }
}
