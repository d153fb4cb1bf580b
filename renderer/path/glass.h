/* Rough glass: how much light one bounce off or through one of its facets brings out, so that the rest can be
 * given back (Turquin 2019, "Practical multiple scattering compensation for microfacet models"). */
#ifndef FOVEAD_RENDERER_GLASS_H
#define FOVEAD_RENDERER_GLASS_H

#include <stdbool.h>

struct rnd_glass;

/* Of glass of that index, seen from both sides, with any roughness between these two: tables, by quadrature.
 * NULL if memory is short. The caller frees. */
struct rnd_glass *rnd_glass_create(float ior, float least_roughness, float most_roughness);
/* Share of light that it returns and lets through, if white, in one bounce; by the cosine of the direction
 * that it is seen from, from inside or from without. */
float rnd_glass_albedo(const struct rnd_glass *glass, float cosine, float alpha, bool inside);

#endif
