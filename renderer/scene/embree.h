/* Embree 3.13 and Embree 4 under one set of names: no other file knows which of them it is.
 *
 * Both trace single rays and packets of 8, which every processor with AVX2 traces as packets. Embree 4 has no
 * streams of rays. CMake sets RND_EMBREE, the version's first number.
 */
#ifndef FOVEAD_RENDERER_EMBREE_H
#define FOVEAD_RENDERER_EMBREE_H

#if RND_EMBREE == 4
#include <embree4/rtcore.h>
#elif RND_EMBREE == 3
#include <embree3/rtcore.h>
#else
#error "RND_EMBREE must be 3 or 4"
#endif
#include <stdbool.h>

/* What a filter finds as args->context; whoever asks may put it first in a structure of its own. */
struct rnd_query {
#if RND_EMBREE == 4
    struct RTCRayQueryContext embree;
#else
    struct RTCIntersectContext embree;
#endif
};

/* The flag of a scene whose rays may bring a filter with them. */
#if RND_EMBREE == 4
#define RND_SCENE_QUERY_FILTER RTC_SCENE_FLAG_FILTER_FUNCTION_IN_ARGUMENTS
#else
#define RND_SCENE_QUERY_FILTER RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION
#endif

/* What a ray hits first of what the filter leaves, which sees query as args->context. The scene has the flag
 * RND_SCENE_QUERY_FILTER. */
static inline void rnd_embree_intersect1_filtered(RTCScene scene, struct rnd_query *query,
                                                  RTCFilterFunctionN filter, struct RTCRayHit *ray)
{
#if RND_EMBREE == 4
    struct RTCIntersectArguments arguments;
    rtcInitRayQueryContext(&query->embree);
    rtcInitIntersectArguments(&arguments);
    arguments.context = &query->embree;
    arguments.filter = filter;
    arguments.flags |= RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER;
    rtcIntersect1(scene, ray, &arguments);
#else
    rtcInitIntersectContext(&query->embree);
    query->embree.filter = filter;
    rtcIntersect1(scene, &query->embree, ray);
#endif
}

static inline void rnd_embree_intersect1(RTCScene scene, struct RTCRayHit *ray)
{
#if RND_EMBREE == 4
    rtcIntersect1(scene, ray, NULL);
#else
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(scene, &context, ray);
#endif
}

/* Is anything in a ray's way? */
static inline bool rnd_embree_occluded1(RTCScene scene, struct RTCRay *ray)
{
#if RND_EMBREE == 4
    rtcOccluded1(scene, ray, NULL);
#else
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcOccluded1(scene, &context, ray);
#endif
    return ray->tfar < 0.0f;
}

/* Packets of 8, of which those rays count whose valid is -1 (else 0); both are aligned to 32 bytes. Coherent:
 * they begin in one place and keep together. */
static inline void rnd_embree_intersect8(RTCScene scene, bool coherent, const int valid[8],
                                         struct RTCRayHit8 *rays)
{
#if RND_EMBREE == 4
    struct RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    arguments.flags = coherent ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT;
    rtcIntersect8(valid, scene, rays, &arguments);
#else
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    rtcIntersect8(valid, scene, &context, rays);
#endif
}

/* Afterwards tfar is -INFINITY of the rays that have something in their way. Never coherent: Embree 3.13.5
 * may then go on for ever behind instances. */
static inline void rnd_embree_occluded8(RTCScene scene, const int valid[8], struct RTCRay8 *rays)
{
#if RND_EMBREE == 4
    rtcOccluded8(valid, scene, rays, NULL);
#else
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcOccluded8(valid, scene, &context, rays);
#endif
}

#endif
