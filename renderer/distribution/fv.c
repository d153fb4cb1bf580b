/* FV: as dense around the gaze as the acuity of the eye, by inversion of its integral (Koskela 2018).
 *
 * The azimuth around the gaze is uniform and the eccentricity e has the density g(e) = 2 pi e m(e) on 0..80
 * degrees, normalised. On the sphere that is g(e) / (2 pi sin e) per steradian: the papers' planar factor e,
 * where a sphere has sin e, makes the periphery a little denser than m (29 % at 80 degrees).
 */
#include "acuity.h"
#include "distribution/distribution.h"
#include "sphere.h"

static const float deg = (float)(M_PI / 180.0);

/* A fovea s times as wide has the density g(e / s) on 0..80 degrees: with t = e / s that is the usual one on
 * 0..80 / s, so the inversion serves it too, when its argument keeps to the share of u that lies there. */
static float spread_of(const struct rnd_aim *aim)
{
    return fmaxf(aim->spread, 1.0f);
}

static void place(const struct rnd_aim *aim, float share, size_t count, const float *u, float *out,
                  float (*eccentricity)(float))
{
    const vec3s gaze = rnd_vec(aim->gaze);
    const float scale = spread_of(aim) * deg;
    vec3s x, y;
    rnd_frame(gaze, &x, &y);
    for (size_t i = 0; i < count; i++) {
        const float e = eccentricity(share * u[2 * i]) * scale, phi = u[2 * i + 1] * 2.0f * (float)M_PI;
        const float s = sinf(e);
        vec3s d = glms_vec3_scale(gaze, cosf(e));
        d = glms_vec3_muladds(x, s * cosf(phi), d);
        d = glms_vec3_muladds(y, s * sinf(phi), d);
        glm_vec3_copy((float *)d.raw, out + 3 * i);
    }
}

/* Per steradian, from a density per degree of eccentricity; e / sin e is 180 / pi at the gaze itself. */
static float per_steradian(float e_deg, float per_degree)
{
    return per_degree / deg / (2.0f * (float)M_PI * sinf(e_deg * deg));
}

/* The gaze itself is no special case but a limit: a direction this near to it has the density there. */
static float eccentricity_of(const struct rnd_aim *aim, const float direction[3])
{
    return fmaxf(rnd_angle(rnd_vec(aim->gaze), rnd_vec(direction)) / deg, 1e-3f);
}

static float exact_share(float spread)
{
    return (float)(rnd_acuity_integral(RND_OUTER_DEG / spread) / rnd_acuity_integral(RND_OUTER_DEG));
}

static void exact_sample(const struct rnd_aim *aim, size_t count, const float *u, float *out)
{
    place(aim, exact_share(spread_of(aim)), count, u, out, rnd_eccentricity_exact);
}

static float exact_density(const struct rnd_aim *aim, const float direction[3])
{
    const float e = eccentricity_of(aim, direction), spread = spread_of(aim), t = e / spread;
    if (e > RND_OUTER_DEG) return 0.0f;
    const float total = spread * (float)rnd_acuity_integral(RND_OUTER_DEG / spread);
    return per_steradian(e, 2.0f * (float)M_PI * t * rnd_acuity(t) / total);
}

/* 1 without spread: the fit ends a little before 80 degrees. */
static float polynomial_share(float spread)
{
    float slope;
    return rnd_polynomial_inverse(RND_OUTER_DEG / spread, &slope);
}

static void polynomial_sample(const struct rnd_aim *aim, size_t count, const float *u, float *out)
{
    place(aim, polynomial_share(spread_of(aim)), count, u, out, rnd_eccentricity_polynomial);
}

/* The density that the published fit implies: du/de. The two branches do not meet: nothing falls in the
 * thousandths of a degree between them, nor beyond e(1) = 79.97. */
static float polynomial_density(const struct rnd_aim *aim, const float direction[3])
{
    const float e = eccentricity_of(aim, direction), spread = spread_of(aim);
    float slope;
    if (e > RND_OUTER_DEG) return 0.0f;
    rnd_polynomial_inverse(e / spread, &slope);
    return per_steradian(e, slope / (polynomial_share(spread) * spread));
}

const struct rnd_distribution rnd_distribution_fv = {
    .name = "fv",
    .summary = "by visual acuity around the gaze, published polynomial",
    .source = "Koskela 2018, eq. 7",
    .sample = polynomial_sample,
    .density = polynomial_density,
};

const struct rnd_distribution rnd_distribution_fv_exact = {
    .name = "fv-exact",
    .summary = "by visual acuity around the gaze, exact inverse",
    .source = "Koskela 2018, eq. 2 and 5",
    .sample = exact_sample,
    .density = exact_density,
};
