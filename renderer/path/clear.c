/* Light straight through glass: an approximation, for shadow rays alone.
 *
 * Each surface lets through what it would let through of a ray that meets it from outside in the shadow ray's
 * direction, in air. In a window, whose two sides are parallel, that is the true angle at both of them. Media
 * absorb along the way between. */
#include "path/clear.h"
#include "path/ray.h"
#include "material/closure.h"
#include "math/sampler.h"

#include <string.h>

/* Surfaces that light gets through: what is behind more is dark. */
enum { MOST_SURFACES = 64 };

static bool next_surface(const struct rnd_scene *scene, struct rnd_v3 origin, struct rnd_v3 direction,
                         float near, float far, struct RTCRayHit *out)
{
    *out = rnd_ray(origin, direction, near, far);
    rnd_embree_intersect1(scene->clear_tree, out);
    return out->hit.geomID != RTC_INVALID_GEOMETRY_ID;
}

bool rnd_clear_is_free(const struct rnd_scene *scene, struct rnd_v3 origin, struct rnd_v3 direction,
                       float distance)
{
    struct RTCRayHit hit;
    return !next_surface(scene, origin, direction, 0.0f, distance, &hit);
}

/* The surface that a ray hit, at the finest level of its textures: a shadow ray has no cone. Its texels are
 * picked by a hash of the ray. */
static struct rnd_surface surface_at(const struct rnd_scene *scene, const struct RTCRayHit *hit)
{
    const float numbers[] = {hit->ray.org_x, hit->ray.org_y, hit->ray.org_z,
                             hit->ray.dir_x, hit->ray.dir_y, hit->ray.dir_z};
    struct rnd_filter filter = {.footprint = 0.0f};
    struct rnd_facing facing;
    struct rnd_surface surface;
    uint32_t hash = 0;
    for (size_t k = 0; k < sizeof numbers / sizeof *numbers; k++) {
        uint32_t bits;
        memcpy(&bits, &numbers[k], sizeof bits);
        hash = rnd_hash2(hash, bits);
    }
    rnd_dither(hash, hit->hit.primID, hit->hit.geomID, &filter.pick[0], &filter.pick[1]);
    const struct rnd_point point = rnd_point_of(scene, hit, &facing);
    rnd_surface_at(scene, &point, &facing, &filter, &surface);
    return surface;
}

struct rnd_v3 rnd_clear_transmittance(const struct rnd_scene *scene, rnd_media media, struct rnd_v3 origin,
                                      struct rnd_v3 direction, float distance, bool *out_any)
{
    const vec3s wo = glms_vec3_negate(rnd_from_v3(direction));
    struct rnd_v3 left = {1, 1, 1};
    struct RTCRayHit hit;
    struct rnd_closure closure;
    float last = 0.0f, near = 0.0f; /* where the ray met the last surface, and where it may meet the next */
    *out_any = false;
    for (int i = 0; next_surface(scene, origin, direction, near, distance, &hit); i++) {
        if (i == MOST_SURFACES || !(rnd_v3_max(left) > 0.0f)) return rnd_v3(0, 0, 0);
        struct rnd_surface surface = surface_at(scene, &hit);
        const uint32_t medium = surface.material->medium;
        left = rnd_v3_mul(left, rnd_media_transmittance(scene, media, hit.ray.tfar - last));
        if (medium) media = surface.front ? rnd_media_enter(media, medium) : rnd_media_leave(media, medium);
        *out_any = true;
        surface.front = true;
        surface.between = rnd_interface_in_air(surface.material, true);
        rnd_closure_at(&surface, wo, &closure);
        left = rnd_v3_mul(left, rnd_to_v3(rnd_closure_through(&closure)));
        last = hit.ray.tfar;
        near = last + 1e-6f + 1e-5f * last;
    }
    return rnd_v3_mul(left, rnd_media_transmittance(scene, media, distance - last));
}
