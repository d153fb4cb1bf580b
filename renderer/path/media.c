/* Which media paths are in. */
#include "path/media.h"
#include "path/ray.h"

#include <math.h>

struct rnd_v3 rnd_media_transmittance(const struct rnd_scene *scene, rnd_media media, float distance)
{
    const struct rnd_medium *medium = &scene->medium[rnd_media_innermost(media)];
    const vec3s s = medium->absorption;
    const float index = medium->ior;
    if (!(distance < INFINITY)) return rnd_v3(index * index, index * index, index * index);
    return rnd_v3(expf(-s.x * distance), expf(-s.y * distance), expf(-s.z * distance));
}

static bool has(rnd_media media, uint32_t medium)
{
    for (; media; media >>= 16)
        if (rnd_media_innermost(media) == medium) return true;
    return false;
}

/* --- borders along a ray --- */

enum { MOST_CROSSINGS = 64 };

struct crossing {
    float distance;
    uint32_t medium;
    bool enters;
    uint32_t geometry, primitive, instance;
};

/* The MOST_CROSSINGS nearest borders on a ray, by distance. Embree does not find them in order. */
struct crossings {
    struct rnd_query query; /* first member: Embree passes a pointer to it */
    const struct rnd_scene *scene;
    bool of_camera; /* borders that are one-sided are skipped where their back is met */
    uint32_t count;
    struct crossing crossing[MOST_CROSSINGS];
};

/* Note a hit of a single ray and let the ray go on. The ray and the normal are both in the mesh's
 * coordinates. */
static void note(const struct RTCFilterFunctionNArguments *args)
{
    struct crossings *to = (struct crossings *)args->context;
    const struct RTCRay *ray = (const struct RTCRay *)args->ray;
    const struct RTCHit *hit = (const struct RTCHit *)args->hit;
    uint32_t mesh;
    rnd_resolve_hit(to->scene, hit->geomID, hit->instID[0], &mesh);
    const struct rnd_material *material = &to->scene->material[to->scene->mesh[mesh].material];
    const bool enters = ray->dir_x * hit->Ng_x + ray->dir_y * hit->Ng_y + ray->dir_z * hit->Ng_z < 0.0f;
    args->valid[0] = 0;
    if (to->count == MOST_CROSSINGS) return;
    if (to->of_camera && material->one_sided && !enters) return;
    uint32_t i = 0; /* Embree may tell of a triangle twice */
    for (; i < to->count; i++) {
        const struct crossing *c = &to->crossing[i];
        if (c->geometry == hit->geomID && c->primitive == hit->primID && c->instance == hit->instID[0])
            return;
    }
    for (; i > 0 && to->crossing[i - 1].distance > ray->tfar; i--) to->crossing[i] = to->crossing[i - 1];
    to->crossing[i] =
        (struct crossing){ray->tfar, material->medium, enters, hit->geomID, hit->primID, hit->instID[0]};
    to->count++;
}

/* Sort by distance. The array is not cleared, because this is called for every hit of a border. */
static void find(const struct rnd_scene *scene, bool of_camera, struct rnd_v3 origin, struct rnd_v3 direction,
                 float distance, struct crossings *to)
{
    to->scene = scene;
    to->of_camera = of_camera;
    to->count = 0;
    struct RTCRayHit ray = rnd_ray(origin, direction, 0.0f, distance);
    rnd_embree_intersect1_filtered(scene->border_tree, &to->query, note, &ray);
}

/* --- borders --- */

/* The border between two media, for a ray that comes from those before. A ray that meets the back of a
 * surface comes out of its medium, even if its path is not known to be in it: the surface is believed. */
static struct rnd_interface between(const struct rnd_scene *scene, rnd_media before, rnd_media behind,
                                    const struct rnd_surface *surface)
{
    const struct rnd_medium *medium = scene->medium;
    const uint32_t own = surface->material->medium, from = rnd_media_innermost(before),
                   to = rnd_media_innermost(behind);
    const uint32_t front = surface->front || has(before, own) ? from : own, other = front == own ? to : front;
    const float squeeze = medium[from].ior / medium[to].ior;
    return (struct rnd_interface){
        .eta = medium[to].ior / medium[front].ior,
        .squeeze = squeeze * squeeze,
        .inside = front == own,
        .glass = (front == own || to == own) && medium[other].index < RND_GLASS_INDICES
                     ? surface->material->glass[medium[other].index]
                     : NULL,
        .hidden = front == to,
    };
}

rnd_media rnd_media_pass(const struct rnd_scene *scene, rnd_media media, const struct rnd_border *border,
                         struct rnd_surface *surface)
{
    const uint32_t own = surface->material->medium;
    /* Search from just before the point to where the path goes on: rounding may have moved borders that
     * coincide with the point to either side of it. */
    const float before = border->off / 16.0f;
    struct crossings found;
    find(scene, false, rnd_v3_muladd(border->normal, before, border->at), rnd_v3_scale(border->normal, -1.0f),
         before + border->off, &found);
    /* Leave media before entering any. In the order of the ray, another medium could be the innermost in
     * between. */
    rnd_media behind = surface->front ? media : rnd_media_leave(media, own);
    for (int enters = 0; enters < 2; enters++) {
        if (enters && surface->front) behind = rnd_media_enter(behind, own);
        for (uint32_t i = 0; i < found.count; i++) {
            const struct crossing *c = &found.crossing[i];
            const bool same = c->geometry == border->geometry && c->primitive == border->primitive &&
                              c->instance == border->instance;
            if (same || c->enters != enters) continue;
            behind = enters ? rnd_media_enter(behind, c->medium) : rnd_media_leave(behind, c->medium);
        }
    }
    surface->between = between(scene, media, behind, surface);
    return behind;
}

rnd_media rnd_media_at(const struct rnd_scene *scene, const float position[3])
{
    rnd_media entered = 0, media = 0;
    int count = 0;
    struct crossings found;
    if (!scene->border_tree) return 0;
    find(scene, true, rnd_v3(position[0], position[1], position[2]),
         rnd_v3_normalize(rnd_v3(0.1f, 1.0f, 0.17f)), INFINITY, &found);
    /* A ray that leaves a medium which it did not enter has been in it from the beginning. */
    for (uint32_t i = 0; i < found.count; i++) {
        const struct crossing *c = &found.crossing[i];
        if (c->enters)
            entered = rnd_media_enter(entered, c->medium);
        else if (has(entered, c->medium))
            entered = rnd_media_leave(entered, c->medium);
        else if (count < 4)
            media |= (rnd_media)c->medium << 16 * count++;
    }
    return media;
}
