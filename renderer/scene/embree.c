/* Where Embree 3.13 and Embree 4 differ. Embree 3 traces arrays as streams, which copies nothing. Embree 4
 * has no streams: rays go in packets of 8, which every processor with AVX2 traces as such. */
#include "scene/embree.h"

#include <math.h>
#include <stddef.h>

static void prepare(const struct rnd_embree_rays *rays, const struct rnd_embree_hits *hits, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        rays->distance[i] = INFINITY;
        hits->geometry[i] = hits->instance[i] = RTC_INVALID_GEOMETRY_ID;
    }
}

#if RND_EMBREE == 3

void rnd_embree_intersect1(RTCScene scene, struct RTCRayHit *ray)
{
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(scene, &context, ray);
}

void rnd_embree_intersect1_filtered(RTCScene scene, struct rnd_query *query, RTCFilterFunctionN filter,
                                    struct RTCRayHit *ray)
{
    rtcInitIntersectContext(&query->embree);
    query->embree.filter = filter;
    rtcIntersect1(scene, &query->embree, ray);
}

bool rnd_embree_occluded1(RTCScene scene, struct RTCRay *ray)
{
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcOccluded1(scene, &context, ray);
    return ray->tfar < 0.0f;
}

/* Fields that Embree wants for each ray and that are 0 for all. Nobody writes there, not even Embree. */
static float zero[RND_EMBREE_RAYS] __attribute__((aligned(64)));
static unsigned nothing[RND_EMBREE_RAYS] __attribute__((aligned(64)));
static unsigned all[RND_EMBREE_RAYS]
    __attribute__((aligned(64))) = {[0 ... RND_EMBREE_RAYS - 1] = UINT32_MAX};

static struct RTCRayNp stream_of(const struct rnd_embree_rays *rays)
{
    return (struct RTCRayNp){.org_x = rays->origin[0],
                             .org_y = rays->origin[1],
                             .org_z = rays->origin[2],
                             .tnear = zero,
                             .dir_x = rays->direction[0],
                             .dir_y = rays->direction[1],
                             .dir_z = rays->direction[2],
                             .time = zero,
                             .tfar = rays->distance,
                             .mask = all,
                             .id = nothing,
                             .flags = nothing};
}

void rnd_embree_intersect(RTCScene scene, bool coherent, const struct rnd_embree_rays *rays,
                          const struct rnd_embree_hits *hits, uint32_t count)
{
    struct RTCIntersectContext context;
    struct RTCRayHitNp stream = {.ray = stream_of(rays),
                                 .hit = {.Ng_x = hits->normal[0],
                                         .Ng_y = hits->normal[1],
                                         .Ng_z = hits->normal[2],
                                         .u = hits->u,
                                         .v = hits->v,
                                         .primID = hits->primitive,
                                         .geomID = hits->geometry,
                                         .instID = {hits->instance}}};
    prepare(rays, hits, count);
    rtcInitIntersectContext(&context);
    context.flags = coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    rtcIntersectNp(scene, &context, &stream, count);
}

/* Without the coherent flag: with it Embree 3.13.5 may loop for ever where there are instances. */
void rnd_embree_occluded(RTCScene scene, const struct rnd_embree_rays *rays, uint32_t count)
{
    struct RTCIntersectContext context;
    const struct RTCRayNp stream = stream_of(rays);
    rtcInitIntersectContext(&context);
    rtcOccludedNp(scene, &context, &stream, count);
}

#else

void rnd_embree_intersect1(RTCScene scene, struct RTCRayHit *ray)
{
    rtcIntersect1(scene, ray, NULL);
}

void rnd_embree_intersect1_filtered(RTCScene scene, struct rnd_query *query, RTCFilterFunctionN filter,
                                    struct RTCRayHit *ray)
{
    struct RTCIntersectArguments arguments;
    rtcInitRayQueryContext(&query->embree);
    rtcInitIntersectArguments(&arguments);
    arguments.context = &query->embree;
    arguments.filter = filter;
    arguments.flags |= RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER;
    rtcIntersect1(scene, ray, &arguments);
}

bool rnd_embree_occluded1(RTCScene scene, struct RTCRay *ray)
{
    rtcOccluded1(scene, ray, NULL);
    return ray->tfar < 0.0f;
}

enum { PACKET = 8, OCTANTS = 8 };

/* A packet, and which of its rays are valid: -1, else 0. */
struct packet {
    struct RTCRayHit8 rays;
    int valid[PACKET];
} __attribute__((aligned(64)));

static void init(struct packet *packet)
{
    *packet = (struct packet){0};
    for (int k = 0; k < PACKET; k++) packet->rays.ray.mask[k] = UINT32_MAX;
}

/* Sort rays by the octant that they point into, so that the rays of a packet take similar ways through the
 * tree. */
static void sort(const struct rnd_embree_rays *rays, uint32_t count, uint32_t *restrict out_order)
{
    uint32_t end[OCTANTS + 1] = {0};
    uint8_t octant[RND_EMBREE_RAYS];
    for (uint32_t i = 0; i < count; i++) {
        octant[i] = (uint8_t)((rays->direction[0][i] < 0.0f) | (rays->direction[1][i] < 0.0f) << 1 |
                              (rays->direction[2][i] < 0.0f) << 2);
        end[octant[i] + 1]++;
    }
    for (int o = 0; o < OCTANTS; o++) end[o + 1] += end[o];
    for (uint32_t i = 0; i < count; i++) out_order[end[octant[i]]++] = i;
}

/* Make a packet of the next rays in order: the smaller of count and PACKET. Returns how many. */
static uint32_t pack(const struct rnd_embree_rays *rays, const uint32_t *order, uint32_t count,
                     struct packet *to)
{
    struct RTCRay8 *ray = &to->rays.ray;
    for (uint32_t k = 0; k < PACKET; k++) {
        const uint32_t i = order[k < count ? k : 0];
        to->valid[k] = k < count ? -1 : 0;
        ray->org_x[k] = rays->origin[0][i];
        ray->org_y[k] = rays->origin[1][i];
        ray->org_z[k] = rays->origin[2][i];
        ray->dir_x[k] = rays->direction[0][i];
        ray->dir_y[k] = rays->direction[1][i];
        ray->dir_z[k] = rays->direction[2][i];
        ray->tfar[k] = rays->distance[i];
    }
    return count < PACKET ? count : PACKET;
}

void rnd_embree_intersect(RTCScene scene, bool coherent, const struct rnd_embree_rays *rays,
                          const struct rnd_embree_hits *hits, uint32_t count)
{
    uint32_t order[RND_EMBREE_RAYS];
    struct packet packet;
    struct RTCHit8 *hit = &packet.rays.hit;
    struct RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    arguments.flags = coherent ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT;
    init(&packet);
    prepare(rays, hits, count);
    if (coherent)
        for (uint32_t i = 0; i < count; i++) order[i] = i;
    else
        sort(rays, count, order);
    for (uint32_t first = 0, n; first < count; first += n) {
        n = pack(rays, order + first, count - first, &packet);
        for (int k = 0; k < PACKET; k++) hit->geomID[k] = hit->instID[0][k] = RTC_INVALID_GEOMETRY_ID;
        rtcIntersect8(packet.valid, scene, &packet.rays, &arguments);
        for (uint32_t k = 0; k < n; k++) {
            const uint32_t i = order[first + k];
            rays->distance[i] = packet.rays.ray.tfar[k];
            hits->normal[0][i] = hit->Ng_x[k];
            hits->normal[1][i] = hit->Ng_y[k];
            hits->normal[2][i] = hit->Ng_z[k];
            hits->u[i] = hit->u[k];
            hits->v[i] = hit->v[k];
            hits->geometry[i] = hit->geomID[k];
            hits->primitive[i] = hit->primID[k];
            hits->instance[i] = hit->instID[0][k];
        }
    }
}

void rnd_embree_occluded(RTCScene scene, const struct rnd_embree_rays *rays, uint32_t count)
{
    uint32_t order[RND_EMBREE_RAYS];
    struct packet packet;
    init(&packet);
    sort(rays, count, order);
    for (uint32_t first = 0, n; first < count; first += n) {
        n = pack(rays, order + first, count - first, &packet);
        rtcOccluded8(packet.valid, scene, &packet.rays.ray, NULL);
        for (uint32_t k = 0; k < n; k++) rays->distance[order[first + k]] = packet.rays.ray.tfar[k];
    }
}

#endif
