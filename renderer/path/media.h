/* Media: what light goes through between surfaces.
 *
 * A closed surface with a volume (KHR_materials_volume, MTL's illum 5 to 7) is the border of a medium, which
 * has an index of refraction and absorbs. A path knows the media that it is in, one inside another, so that
 * each border is met with the indices of its two sides: water in a glass, ice in the water, a bubble in the
 * ice (after Schmidt and Budge 2002, "Simple nested dielectrics in ray traced images"). Scene files give
 * media no priority: where media overlap, the one that a path entered last is the one that is there, and a
 * border behind which it stays so is not seen. Borders that lie in each other, as where water touches glass,
 * are passed together.
 *
 * Radiance over the square of the index is what refraction keeps (Veach 1997, section 5.2). The throughput of
 * a path in a medium has the factor 1 / index^2, by the media that the path knows, so that no order of
 * surfaces makes light out of nothing: what leaves the scene is in air, and so is light from the sky. */
#ifndef FOVEAD_RENDERER_MEDIA_H
#define FOVEAD_RENDERER_MEDIA_H

#include "material/surface.h"
#include "math/v3.h"

/* The media that a point is in: ids of 16 bits, the innermost lowest; 0 is air. Of more than four the
 * outermost are forgotten. */
typedef uint64_t rnd_media;

static inline uint32_t rnd_media_innermost(rnd_media media)
{
    return (uint32_t)(media & 0xffffu);
}

static inline rnd_media rnd_media_enter(rnd_media media, uint32_t medium)
{
    return media << 16 | medium;
}

/* Leave a medium, or the innermost one if the point was not known to be in it. */
static inline rnd_media rnd_media_leave(rnd_media media, uint32_t medium)
{
    for (int shift = 0; shift < 64; shift += 16)
        if ((media >> shift & 0xffffu) == medium)
            return (media >> shift >> 16) << shift | (media & (((rnd_media)1 << shift) - 1));
    return media >> 16;
}

/* Factor of light that goes that length, m, through the innermost of the media, which absorbs (Beer and
 * Lambert). Light from infinity comes from air into the medium, where radiance is larger by the square of the
 * index. */
struct rnd_v3 rnd_media_transmittance(const struct rnd_scene *scene, rnd_media media, float distance);

/* A point that a ray hit, and the media that the ray was known to be in. */
struct rnd_border {
    struct rnd_v3 at, normal;               /* world; unit, facing where the ray came from */
    float off;                              /* how far behind the point paths that pass it go on, m */
    uint32_t geometry, primitive, instance; /* Embree's */
};

/* The media behind such a point on a surface with a volume. Also stores in the surface which media the border
 * is between. */
rnd_media rnd_media_pass(const struct rnd_scene *scene, rnd_media media, const struct rnd_border *border,
                         struct rnd_surface *surface);

/* The media that a camera at that position is in. One-sided borders whose back faces the camera do not count.
 */
rnd_media rnd_media_at(const struct rnd_scene *scene, const float position[3]);

#endif
