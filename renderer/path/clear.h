/* Clear glass.
 *
 * Glass that refracts or is rough hides what is behind it from shadow rays. Where the scene is loaded with
 * clear glass, Embree's filters let shadow rays pass, and they are weighted by what the glass lets through.
 */
#ifndef FOVEAD_RENDERER_CLEAR_H
#define FOVEAD_RENDERER_CLEAR_H

#include "path/media.h"

/* Of a scene with clear glass: the factor of light that comes straight along a ray of that length, which
 * begins in those media; and whether there is any clear glass on the way. */
struct rnd_v3 rnd_clear_transmittance(const struct rnd_scene *scene, rnd_media media, struct rnd_v3 origin,
                                      struct rnd_v3 direction, float distance, bool *out_any);
/* Is there no clear glass along the ray? */
bool rnd_clear_is_free(const struct rnd_scene *scene, struct rnd_v3 origin, struct rnd_v3 direction,
                       float distance);

#endif
