/* What light does at a surface, whatever its material: evaluated and drawn. */
#ifndef FOVEAD_RENDERER_BSDF_H
#define FOVEAD_RENDERER_BSDF_H

#include "material/surface.h"

/* BSDF times cosine for light from wi leaving along wo (unit, away from the surface, wo on the side of the
 * normals, wi anywhere), and the density with which rnd_bsdf_draw() draws wi, per steradian. What is smooth
 * and transmits has no such density and gives nothing. */
vec3s rnd_bsdf(const struct rnd_surface *surface, vec3s wo, vec3s wi, float *out_pdf);

/* Draw a direction, below the surface too if it transmits; u are three numbers in [0,1). False if the path
 * ends here. */
bool rnd_bsdf_draw(const struct rnd_surface *surface, vec3s wo, const float u[3],
                   struct rnd_bsdf_sample *out);

#endif
