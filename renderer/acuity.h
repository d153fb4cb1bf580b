/* What the distributions need of the acuity model beyond renderer.h. */
#ifndef FOVEAD_RENDERER_ACUITY_H
#define FOVEAD_RENDERER_ACUITY_H

#include "renderer.h"

#define RND_OUTER_DEG 80.0f /* the model ends here (Koskela 2018) */

/* Integral of g(e) = 2 pi e m(e) from 0 to e, both in degrees (Koskela 2018 eq. 5). */
double rnd_acuity_integral(double eccentricity_deg);

#endif
