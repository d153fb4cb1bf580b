/* Embree: one tree over all triangles of the world, where geometry ids are mesh indices; meshes that are seen
 * many times have a tree of their own, and an instance of it, numbered after the meshes, for each time.
 */
#include "import/tree.h"
#include "material/coverage.h"
#include "material/glass.h"

#include <stdio.h>
#include <stdlib.h>

/* In trees of up to so many triangles, long triangles are split: rays are faster, but building takes longer,
 * which would delay the first picture of larger scenes. */
enum { SPLIT_TRIANGLES = 1 << 20 };

static void attach_mesh(const struct rnd_scene *scene, uint32_t i, RTCScene tree, uint32_t id)
{
    const struct rnd_mesh *mesh = &scene->mesh[i];
    RTCGeometry geometry = rtcNewGeometry(scene->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, mesh->position, 0,
                               3 * sizeof(float), mesh->vertices);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh->index, 0,
                               sizeof *mesh->index, mesh->triangles);
    rnd_alpha_attach(scene, i, geometry);
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(tree, geometry, id);
    rtcReleaseGeometry(geometry);
}

static void attach_instance(const struct rnd_scene *scene, uint32_t i, RTCScene part, RTCScene tree)
{
    RTCGeometry geometry = rtcNewGeometry(scene->device, RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(geometry, part);
    rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, scene->instance[i].to_world);
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(tree, geometry, scene->mesh_count + i);
    rtcReleaseGeometry(geometry);
}

static bool is_wanted(const struct rnd_scene *scene)
{
    return !scene->cancel || !atomic_load(scene->cancel);
}

/* Embree calls this while it builds a tree, to ask whether to go on. */
static bool goes_on(void *argument, double share)
{
    (void)share;
    return is_wanted(argument);
}

/* Embree calls this from any of its threads before it takes memory, and after it has freed some. A file can
 * use the same triangles so often that their trees are larger than all that was read. */
static bool may_take(void *argument, ssize_t bytes, bool taken)
{
    struct rnd_scene *scene = argument;
    const int64_t all = atomic_fetch_add(&scene->tree_bytes, bytes) + bytes;
    (void)taken;
    if (bytes <= 0 || all <= (int64_t)scene->reader_mib << 20) return true;
    atomic_store(&scene->trees_too_large, true);
    return false;
}

static RTCScene new_tree(const struct rnd_scene *scene, enum RTCSceneFlags flags)
{
    RTCScene tree = rtcNewScene(scene->device);
    rtcSetSceneProgressMonitorFunction(tree, goes_on, (void *)(uintptr_t)scene);
    rtcSetSceneFlags(tree, flags);
    return tree;
}

/* Make a tree of some of the meshes, with the ids of the whole tree. NULL if there are none. */
static RTCScene part_of(const struct rnd_scene *scene, RTCScene *part, enum RTCSceneFlags flags,
                        bool (*has)(const struct rnd_scene *, uint32_t))
{
    bool any = false;
    for (uint32_t i = 0; i < scene->mesh_count; i++) any |= has(scene, i);
    if (!any) return NULL;
    RTCScene tree = new_tree(scene, flags);
    for (uint32_t i = 0; i < scene->mesh_count; i++)
        if (has(scene, i) && !scene->mesh[i].instanced) attach_mesh(scene, i, tree, i);
    for (uint32_t i = 0; i < scene->instance_count; i++)
        if (has(scene, scene->instance[i].mesh))
            attach_instance(scene, i, part[scene->instance[i].mesh], tree);
    rtcCommitScene(tree);
    return tree;
}

static bool has_medium(const struct rnd_scene *scene, uint32_t mesh)
{
    return scene->material[scene->mesh[mesh].material].medium != 0;
}

bool rnd_accel_build(struct rnd_scene *scene, char out_error[RND_ERROR_SIZE])
{
    scene->device = rtcNewDevice(NULL);
    if (!scene->device) {
        snprintf(out_error, RND_ERROR_SIZE, "Embree cannot start on this machine (error %d)",
                 (int)rtcGetDeviceError(NULL));
        return false;
    }
    rtcSetDeviceMemoryMonitorFunction(scene->device, may_take, scene);
    RTCScene *part = calloc(scene->mesh_count + 1, sizeof *part); /* trees of the instanced meshes */
    if (!part || !rnd_alpha_build(scene)) {
        snprintf(out_error, RND_ERROR_SIZE, "not enough memory");
        free(part);
        return false;
    }
    for (uint32_t i = 0; i < scene->material_count; i++) scene->one_sided |= scene->material[i].one_sided;
    const enum RTCSceneFlags flags = scene->one_sided ? RND_SCENE_QUERY_FILTER : RTC_SCENE_FLAG_NONE;
    scene->tree = new_tree(scene, flags);
    if (scene->info.triangles <= SPLIT_TRIANGLES)
        rtcSetSceneBuildQuality(scene->tree, RTC_BUILD_QUALITY_HIGH);
    for (uint32_t i = 0; i < scene->mesh_count && is_wanted(scene); i++) {
        if (!scene->mesh[i].instanced) {
            attach_mesh(scene, i, scene->tree, i);
            continue;
        }
        part[i] = new_tree(scene, has_medium(scene, i) ? RND_SCENE_QUERY_FILTER : flags);
        attach_mesh(scene, i, part[i], 0);
        rtcCommitScene(part[i]);
    }
    if (is_wanted(scene)) { /* else some of the trees are missing or not whole */
        for (uint32_t i = 0; i < scene->instance_count; i++)
            attach_instance(scene, i, part[scene->instance[i].mesh], scene->tree);
        scene->clear_tree = part_of(scene, part, RTC_SCENE_FLAG_NONE, rnd_is_clear);
        scene->border_tree = part_of(scene, part, RND_SCENE_QUERY_FILTER, has_medium);
        rtcCommitScene(scene->tree);
    }
    for (uint32_t i = 0; i < scene->mesh_count; i++)
        if (part[i]) rtcReleaseScene(part[i]); /* the instances hold references */
    free(part);
    const enum RTCError code = rtcGetDeviceError(scene->device);
    if (code == RTC_ERROR_NONE && is_wanted(scene)) return true;
    if (atomic_load(&scene->trees_too_large))
        snprintf(out_error, RND_ERROR_SIZE, "its triangles need more than %u MiB in Embree's trees",
                 (unsigned)scene->reader_mib);
    else
        snprintf(out_error, RND_ERROR_SIZE, "Embree could not build its tree (error %d)", (int)code);
    return false;
}
