/* A single ray, as Embree wants it. */
#ifndef FOVEAD_RENDERER_RAY_H
#define FOVEAD_RENDERER_RAY_H

#include "material/point.h"
#include "math/v3.h"
#include "scene/embree.h"

/* A ray that has hit nothing yet; near and far are in lengths of the direction. */
static inline struct RTCRayHit rnd_ray(struct rnd_v3 origin, struct rnd_v3 direction, float near, float far)
{
    return (struct RTCRayHit){
        .ray = {.org_x = origin.x,
                .org_y = origin.y,
                .org_z = origin.z,
                .dir_x = direction.x,
                .dir_y = direction.y,
                .dir_z = direction.z,
                .tnear = near,
                .tfar = far,
                .mask = UINT32_MAX},
        .hit = {.geomID = RTC_INVALID_GEOMETRY_ID, .instID = {RTC_INVALID_GEOMETRY_ID}}};
}

/* The point that a ray hit, and its normals. */
static inline struct rnd_point rnd_point_of(const struct rnd_scene *scene, const struct RTCRayHit *hit,
                                            struct rnd_facing *out_facing)
{
    const struct rnd_v3 origin = {hit->ray.org_x, hit->ray.org_y, hit->ray.org_z},
                        direction = {hit->ray.dir_x, hit->ray.dir_y, hit->ray.dir_z};
    struct rnd_point point = {.triangle = hit->hit.primID,
                              .u = hit->hit.u,
                              .v = hit->hit.v,
                              .position = rnd_v3_muladd(direction, hit->ray.tfar, origin)};
    point.instance = rnd_resolve_hit(scene, hit->hit.geomID, hit->hit.instID[0], &point.mesh);
    *out_facing =
        rnd_facing_at(scene, &point, rnd_v3(hit->hit.Ng_x, hit->hit.Ng_y, hit->hit.Ng_z), direction);
    return point;
}

#endif
