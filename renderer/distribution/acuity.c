/* The acuity of the eye, and its inversion: where a sample should fall when density follows what the eye
 * resolves.
 *
 * Koskela, Immonen, Viitanen, Jaaskelainen, Multanen, Takala 2018, "Instantaneous foveated preview for
 * progressive Monte Carlo rendering". Eccentricities are in degrees here, as the constants of the papers are.
 */
#include "distribution/acuity.h"

#include <math.h>

#define OUTER_DEG ((double)RND_OUTER_DEG)
/* 2 pi 7.49 / 0.3^2: what eq. 5 rounds to 166.4 pi. */
#define SCALE (2.0 * M_PI * 7.49 / 0.09)

float rnd_acuity(float eccentricity_deg)
{
    const float y = 0.3f * eccentricity_deg + 1.0f;
    return eccentricity_deg <= (float)RND_FOVEA_DEG ? 1.0f : 7.49f / (y * y);
}

/* 1/y + ln y, y = 0.3 e + 1: the integral of e m(e) outside the fovea, up to a factor. */
static double outer_integral(double y)
{
    return 1.0 / y + log(y);
}

/* Integral of g(e) = 2 pi e m(e) from 0 to e (Koskela 2018 eq. 5, with its constant of integration exact). */
double rnd_acuity_integral(double eccentricity_deg)
{
    const double inner = M_PI * RND_FOVEA_DEG * RND_FOVEA_DEG;
    if (eccentricity_deg <= RND_FOVEA_DEG) return M_PI * eccentricity_deg * eccentricity_deg;
    return inner +
           SCALE * (outer_integral(0.3 * eccentricity_deg + 1.0) - outer_integral(0.3 * RND_FOVEA_DEG + 1.0));
}

float rnd_eccentricity_polynomial(float u)
{
    return rnd_polynomial(u);
}

float rnd_polynomial_inverse(float e, float *out_slope)
{
    const float join = RND_POLYNOMIAL_JOIN;
    *out_slope = 2.0f * e / (18.64f * 18.64f);
    if (e <= rnd_eccentricity_polynomial(join)) return e * e / (18.64f * 18.64f);
    *out_slope = 0.0f;
    if (e < rnd_eccentricity_polynomial(nextafterf(join, 1.0f))) return join;
    if (e > rnd_eccentricity_polynomial(1.0f)) return 1.0f;

    /* Newton from the exact integral */
    float u = (float)(rnd_acuity_integral(e) / rnd_acuity_integral(OUTER_DEG)), steepness = 1.0f;
    for (int i = 0; i < 4; i++) {
        steepness = ((4.0f * 25.09f * u + 3.0f * 0.1680f) * u + 2.0f * 27.61f) * u + 23.87f;
        u -= ((((25.09f * u + 0.1680f) * u + 27.61f) * u + 23.87f) * u + 3.232f - e) / steepness;
    }
    *out_slope = 1.0f / steepness;
    return u;
}

float rnd_eccentricity_exact(float u)
{
    static const double foveal_y = 0.3 * RND_FOVEA_DEG + 1.0;
    const double total = rnd_acuity_integral(OUTER_DEG), inner = M_PI * RND_FOVEA_DEG * RND_FOVEA_DEG;
    const double h = u * total;
    if (h <= inner) return (float)sqrt(h / M_PI);

    /* Newton on 1/y + ln y = c; the published fit is within 0.03 degrees, so two steps reach float precision.
     */
    const double c = (h - inner) / SCALE + outer_integral(foveal_y);
    double y = 0.3 * rnd_eccentricity_polynomial(u) + 1.0;
    for (int i = 0; i < 2; i++) y -= (outer_integral(y) - c) * y * y / (y - 1.0);
    return (float)((y - 1.0) / 0.3);
}
