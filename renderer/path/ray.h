/* A single ray, as Embree wants it. */
#ifndef FOVEAD_RENDERER_RAY_H
#define FOVEAD_RENDERER_RAY_H

#include "math/v3.h"
#include "scene/embree.h"

/* From near to far, in lengths of the direction; it has hit nothing yet. */
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

#endif
