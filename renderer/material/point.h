/* The surface at a single hit. */
#ifndef FOVEAD_RENDERER_POINT_H
#define FOVEAD_RENDERER_POINT_H

#include "material/surface.h"

/* The surface at a hit of a ray with that direction. */
void rnd_surface_at(const struct rnd_scene *scene, const struct rnd_hit *hit, vec3s direction,
                    struct rnd_surface *out);

/* The position moved off the surface towards the side that direction points to, so that a ray from it does
 * not hit the triangle that it left (Waechter and Binder 2019, Ray Tracing Gems ch. 6). */
vec3s rnd_leave(const struct rnd_surface *surface, vec3s direction);

#endif
