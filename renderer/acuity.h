/* What the distributions need of the acuity model beyond renderer.h. */
#ifndef FOVEAD_RENDERER_ACUITY_H
#define FOVEAD_RENDERER_ACUITY_H

#include "renderer.h"

#define RND_OUTER_DEG 80.0f /* the model ends here (Koskela 2018) */

/* Integral of g(e) = 2 pi e m(e) from 0 to e, both in degrees (Koskela 2018 eq. 5). */
double rnd_acuity_integral(double eccentricity_deg);

/* The u of which rnd_eccentricity_polynomial() is e, 0 to 80 degrees, and the slope du/de there. Between its
 * branches, which do not meet, and beyond u = 1 lies nothing: the slope is 0, and u that of the nearer end.
 */
float rnd_polynomial_inverse(float eccentricity_deg, float *out_slope);

#endif
