/* Embree 3.13 and Embree 4 under one set of names. The names below and embree.c alone know how the two
 * differ; CMake sets RND_EMBREE to the first number of the version. */
#ifndef FOVEAD_RENDERER_EMBREE_H
#define FOVEAD_RENDERER_EMBREE_H

#if RND_EMBREE == 4
#include <embree4/rtcore.h>
#define rnd_query_context      RTCRayQueryContext
#define RND_SCENE_QUERY_FILTER RTC_SCENE_FLAG_FILTER_FUNCTION_IN_ARGUMENTS
#elif RND_EMBREE == 3
#include <embree3/rtcore.h>
#define rnd_query_context      RTCIntersectContext
#define RND_SCENE_QUERY_FILTER RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION
#else
#error "RND_EMBREE must be 3 or 4"
#endif
#include <stdbool.h>
#include <stdint.h>

/* What a filter finds as args->context. A caller may put it first in a structure of its own. */
struct rnd_query {
    struct rnd_query_context embree;
};

/* The first hit of one ray, which hits whatever its mask allows. */
void rnd_embree_intersect1(RTCScene scene, struct RTCRayHit *ray);
/* The first hit that the filter accepts. The scene has the flag RND_SCENE_QUERY_FILTER. */
void rnd_embree_intersect1_filtered(RTCScene scene, struct rnd_query *query, RTCFilterFunctionN filter,
                                    struct RTCRayHit *ray);
/* Is anything in the ray's way? */
bool rnd_embree_occluded1(RTCScene scene, struct RTCRay *ray);

/* Rays in arrays of one value per ray, which belong to the caller; each begins at a line of the cache. */
struct rnd_embree_rays {
    float *origin[3], *direction[3];
    float *distance; /* to which a ray is followed */
};

struct rnd_embree_hits {
    float *normal[3], *u, *v;
    unsigned *geometry, *primitive, *instance;
};

enum { RND_EMBREE_RAYS = 512 }; /* most rays of a call */

/* The first hit of each of count rays: its distance is written to rays, all else to hits, whose geometry is
 * RTC_INVALID_GEOMETRY_ID where a ray hits nothing. Coherent: the rays begin in one place, and neighbours in
 * the arrays are neighbours in direction. */
void rnd_embree_intersect(RTCScene scene, bool coherent, const struct rnd_embree_rays *rays,
                          const struct rnd_embree_hits *hits, uint32_t count);
/* Writes -INFINITY as the distance of each ray that has something in its way. */
void rnd_embree_occluded(RTCScene scene, const struct rnd_embree_rays *rays, uint32_t count);

#endif
