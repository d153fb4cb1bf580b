/* Coverage: whether a ray meets a masked or blended material, or a pane of glass, or passes through it. */
#ifndef FOVEAD_RENDERER_COVERAGE_H
#define FOVEAD_RENDERER_COVERAGE_H

#include "scene/scene.h"

/* One entry for each mesh: where a mesh that masks or blends is hit, and for those with holes the filter that
 * Embree calls. False when memory is short. */
bool rnd_alpha_build(struct rnd_scene *scene);
void rnd_alpha_attach(const struct rnd_scene *scene, uint32_t mesh, RTCGeometry geometry);
/* Does a mesh have holes? Panes are not counted: they are there. */
bool rnd_has_coverage(const struct rnd_scene *scene, uint32_t mesh);
/* The chance that a ray which meets such a mesh at barycentric (u, v) hits it: the coverage there, or 0 or 1
 * where a mask decides. */
float rnd_coverage(const struct rnd_scene *scene, uint32_t mesh, uint32_t triangle, float u, float v);
/* The texture that a mesh's coverage comes from, how it is looked up, and whether its alpha counts or else
 * its red. NULL if coverage comes from the factor and the vertices alone. */
const struct rnd_texture *rnd_coverage_texture(const struct rnd_scene *scene, uint32_t mesh,
                                               const struct rnd_map **out_map, bool *out_by_alpha);

#endif
