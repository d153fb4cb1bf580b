/* RND_RICH: all that glTF's extensions lay over and put in place of metallic-roughness. */
#ifndef FOVEAD_RENDERER_LAYERED_H
#define FOVEAD_RENDERER_LAYERED_H

#include "material/ggx.h"
#include "material/glass.h"
#include "material/surface.h"

/* rnd_bsdf() and rnd_bsdf_draw() for RND_RICH. */
vec3s rnd_rich_bsdf(const struct rnd_surface *surface, vec3s wo, vec3s wi, float *out_pdf);
bool rnd_rich_draw(const struct rnd_surface *surface, vec3s wo, const float u[3],
                   struct rnd_bsdf_sample *out);

/* What goes straight through a surface that transmits, seen from without, as if it were smooth and its two
 * sides parallel. */
vec3s rnd_rich_through(const struct rnd_surface *surface, vec3s wo);

#endif
