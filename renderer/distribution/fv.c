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

static void place(const struct rnd_aim *aim, size_t count, const float *u, float *out,
                  float (*eccentricity)(float))
{
    const vec3s gaze = rnd_vec(aim->gaze);
    vec3s x, y;
    rnd_frame(gaze, &x, &y);
    for (size_t i = 0; i < count; i++) {
        const float e = eccentricity(u[2 * i]) * deg, phi = u[2 * i + 1] * 2.0f * (float)M_PI;
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

static void exact_sample(const struct rnd_aim *aim, size_t count, const float *u, float *out)
{
    place(aim, count, u, out, rnd_eccentricity_exact);
}

static float exact_density(const struct rnd_aim *aim, const float direction[3])
{
    const float e = eccentricity_of(aim, direction);
    if (e > RND_OUTER_DEG) return 0.0f;
    const float total = (float)rnd_acuity_integral(RND_OUTER_DEG);
    return per_steradian(e, 2.0f * (float)M_PI * e * rnd_acuity(e) / total);
}

static void polynomial_sample(const struct rnd_aim *aim, size_t count, const float *u, float *out)
{
    place(aim, count, u, out, rnd_eccentricity_polynomial);
}

/* The density that the published fit implies: du/de, by Newton on e(u) from the exact integral. The two
 * branches do not meet: nothing falls in the thousandths of a degree between them, nor beyond e(1) = 79.97.
 */
static float polynomial_density(const struct rnd_aim *aim, const float direction[3])
{
    const float e = eccentricity_of(aim, direction);
    const float join = 0.0965f;
    if (e <= rnd_eccentricity_polynomial(join)) return per_steradian(e, 2.0f * e / (18.64f * 18.64f));
    if (e < rnd_eccentricity_polynomial(nextafterf(join, 1.0f)) || e > rnd_eccentricity_polynomial(1.0f))
        return 0.0f;

    float u = (float)(rnd_acuity_integral(e) / rnd_acuity_integral(RND_OUTER_DEG)), slope = 1.0f;
    for (int i = 0; i < 4; i++) {
        slope = ((4.0f * 25.09f * u + 3.0f * 0.1680f) * u + 2.0f * 27.61f) * u + 23.87f;
        u -= ((((25.09f * u + 0.1680f) * u + 27.61f) * u + 23.87f) * u + 3.232f - e) / slope;
    }
    return per_steradian(e, 1.0f / slope);
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
