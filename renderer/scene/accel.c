/* Embree: one tree over all triangles; geometry ids are mesh indices. */
#include "scene/scene.h"

#include <stdio.h>

bool rnd_accel_build(struct rnd_scene *scene, char out_error[RND_ERROR_SIZE])
{
    scene->device = rtcNewDevice(NULL);
    if (!scene->device) {
        snprintf(out_error, RND_ERROR_SIZE, "Embree cannot start on this machine (error %d)",
                 (int)rtcGetDeviceError(NULL));
        return false;
    }
    scene->tree = rtcNewScene(scene->device);
    for (uint32_t i = 0; i < scene->mesh_count; i++) {
        const struct rnd_mesh *mesh = &scene->mesh[i];
        RTCGeometry geometry = rtcNewGeometry(scene->device, RTC_GEOMETRY_TYPE_TRIANGLE);
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, mesh->position, 0,
                                   3 * sizeof(float), mesh->vertices);
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh->index, 0,
                                   sizeof *mesh->index, mesh->triangles);
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(scene->tree, geometry, i);
        rtcReleaseGeometry(geometry);
    }
    rtcCommitScene(scene->tree);
    const enum RTCError code = rtcGetDeviceError(scene->device);
    if (code == RTC_ERROR_NONE) return true;
    snprintf(out_error, RND_ERROR_SIZE, "Embree could not build its tree (error %d)", (int)code);
    return false;
}
