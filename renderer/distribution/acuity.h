/* The parts of the acuity model that only the distributions need; renderer.h has the rest. */
#ifndef FOVEAD_RENDERER_ACUITY_H
#define FOVEAD_RENDERER_ACUITY_H

#include "math/v3.h"
#include "renderer.h"

#define RND_FOVEA_DEG 5.79  /* up to here acuity is 1 (Reddy 2001) */
#define RND_OUTER_DEG 80.0f /* the model ends here (Koskela 2018) */

/* Integral of g(e) = 2 pi e m(e) from 0 to e, both in degrees (Koskela 2018 eq. 5). */
double rnd_acuity_integral(double eccentricity_deg);

#define RND_POLYNOMIAL_JOIN 0.0965f /* the u at which the published fit changes branches */

/* As rnd_eccentricity_polynomial(), for loops over many. */
RND_INLINE float rnd_polynomial(float u)
{
    const float inner = 18.64f * sqrtf(u),
                outer = (((25.09f * u + 0.1680f) * u + 27.61f) * u + 23.87f) * u + 3.232f;
    return u <= RND_POLYNOMIAL_JOIN ? inner : outer;
}

/* The u for which rnd_eccentricity_polynomial() gives this eccentricity, 0 to 80 degrees, and the slope du/de
 * there. The fit leaves a gap between its branches, and one beyond u = 1: there the slope is 0, and u is that
 * of the nearer end. */
float rnd_polynomial_inverse(float eccentricity_deg, float *out_slope);

#endif
