/* Coverage: whether a ray meets a masked or blended material, or a pane of glass, or passes through it. */
#ifndef FOVEAD_RENDERER_COVERAGE_H
#define FOVEAD_RENDERER_COVERAGE_H

#include "scene/scene.h"

/* What the meshes whose material masks or blends need to be hit only where they are: one entry a
 * mesh, with a function for those that have holes. False when memory is short. */
bool rnd_alpha_build(struct rnd_scene *scene);
void rnd_alpha_attach(const struct rnd_scene *scene, uint32_t mesh, RTCGeometry geometry);
/* Does a mesh have holes? Panes are not counted: they are there. */
bool rnd_has_coverage(const struct rnd_scene *scene, uint32_t mesh);
/* Of such a mesh, the chance of a ray to hit at barycentric (u, v): its coverage, and 0 or 1 where a mask
 * decides. */
float rnd_coverage(const struct rnd_scene *scene, uint32_t mesh, uint32_t triangle, float u, float v);
/* The texture that its coverage comes from, how that is looked up, and whether its alpha counts, else its
 * red. NULL if it comes from the factor and the vertices alone. */
const struct rnd_texture *rnd_coverage_texture(const struct rnd_scene *scene, uint32_t mesh,
                                               const struct rnd_map **out_map, bool *out_by_alpha);

#endif
