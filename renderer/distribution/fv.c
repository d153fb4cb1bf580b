/* FV: as dense around the gaze as the acuity of the eye, by inversion of its integral (Koskela 2018).
 *
 * The azimuth around the gaze is uniform and the eccentricity e has the density g(e) = 2 pi e m(e) on 0..80
 * degrees, normalised. On the sphere that is g(e) / (2 pi sin e) per steradian: the papers' planar factor e,
 * where a sphere has sin e, makes the periphery a little denser than m (29 % at 80 degrees).
 */
#include "distribution/acuity.h"
#include "distribution/distribution.h"
#include "math/v3.h"
#include "math/sphere.h"

static const float deg = (float)(M_PI / 180.0);

/* A fovea that is s times as wide has the density g(e / s) on 0..80 degrees. With t = e / s that is the usual
 * density on 0..80 / s, so the same inversion serves, with u limited to the share that lies there. */
static float spread_of(const struct rnd_aim *aim)
{
    return fmaxf(aim->spread, 1.0f);
}

/* Map the unit square to a uniform u and an azimuth, as a fraction of a turn, by way of the disc (Shirley and
 * Chiu 1997): neighbours in the square are neighbours around the gaze. */
RND_INLINE void disc(float a, float b, float *out_u, float *out_turn)
{
    const float x = 2.0f * a - 1.0f, y = 2.0f * b - 1.0f;
    const int wide = fabsf(x) > fabsf(y);
    const float r = wide ? x : y, other = wide ? y : x, safe = r == 0.0f ? 1.0f : r;
    const float eighth = 0.125f * other / safe;
    float turn = wide ? eighth : 0.25f - eighth;
    turn = r < 0.0f ? turn + 0.5f : turn;
    *out_turn = turn < 0.0f ? turn + 1.0f : turn;
    *out_u = rnd_smaller(r * r, 0x1.fffffep-1f);
}

enum { SOME = 64 }; /* positions at a time */

/* Directions from u and azimuths, SOME at most; eccentricity[i] in degrees. */
static void put(const struct rnd_aim *aim, size_t count, const float *eccentricity, const float *turn,
                float *out)
{
    const struct rnd_v3 gaze = {aim->gaze[0], aim->gaze[1], aim->gaze[2]};
    const struct rnd_v3_frame frame = rnd_v3_frame(gaze);
    const float scale = spread_of(aim) / 360.0f;
    float x[SOME], y[SOME], z[SOME]; /* loops over triples stay scalar */
    for (size_t i = 0; i < count; i++) {
        float se, ce, sa, ca;
        rnd_turn(eccentricity[i] * scale, &se, &ce);
        rnd_turn(turn[i], &sa, &ca);
        const struct rnd_v3 d = rnd_v3_to_world(&frame, rnd_v3(se * ca, se * sa, ce));
        x[i] = d.x;
        y[i] = d.y;
        z[i] = d.z;
    }
    for (size_t i = 0; i < count; i++) {
        out[3 * i] = x[i];
        out[3 * i + 1] = y[i];
        out[3 * i + 2] = z[i];
    }
}

/* Per steradian, from a density per degree of eccentricity; e / sin e is 180 / pi at the gaze itself. */
static float per_steradian(float e_deg, float per_degree)
{
    return per_degree / deg / (2.0f * (float)M_PI * sinf(e_deg * deg));
}

/* At the gaze itself the density is a limit: take it at a direction this near. */
static float eccentricity_of(const struct rnd_aim *aim, const float direction[3])
{
    return fmaxf(rnd_angle(rnd_vec(aim->gaze), rnd_vec(direction)) / deg, 1e-3f);
}

/* The density min(m, cap) and its integral; t is eccentricity over spread, degrees. */
struct capped {
    double cap, flat; /* density is at most cap, which it is up to flat, degrees */
    double inner;     /* integral up to flat */
    double end, total;
};

/* The eye resolves 60 cycles per degree at its best, and a display half a cycle per pixel (Koskela 2016,
 * section 3). */
static struct capped capped_of(const struct rnd_aim *aim)
{
    const double cap = aim->pixels_per_degree > 0.0f ? fmin(aim->pixels_per_degree / 120.0, 1.0) : 1.0;
    struct capped c = {.cap = cap, .flat = RND_FOVEA_DEG, .end = RND_OUTER_DEG / spread_of(aim)};
    if (cap < 1.0) c.flat = fmax((sqrt(7.49 / cap) - 1.0) / 0.3, RND_FOVEA_DEG);
    c.flat = fmin(c.flat, c.end);
    c.inner = cap * M_PI * c.flat * c.flat;
    c.total = c.inner + rnd_acuity_integral(c.end) - rnd_acuity_integral(c.flat);
    return c;
}

static void exact_sample(const struct rnd_aim *aim, size_t count, const float *u, float *out)
{
    const struct capped c = capped_of(aim);
    const double beyond = rnd_acuity_integral(c.flat) - c.inner, all = rnd_acuity_integral(RND_OUTER_DEG);
    float e[SOME], turn[SOME];
    for (size_t first = 0; first < count; first += SOME) {
        const size_t n = count - first < SOME ? count - first : SOME;
        for (size_t i = 0; i < n; i++) {
            disc(u[2 * (first + i)], u[2 * (first + i) + 1], &e[i], &turn[i]);
            const double h = e[i] * c.total;
            e[i] = h <= c.inner ? (float)sqrt(h / (c.cap * M_PI))
                                : rnd_eccentricity_exact((float)((h + beyond) / all));
        }
        put(aim, n, e, turn, out + 3 * first);
    }
}

static float exact_density(const struct rnd_aim *aim, const float direction[3])
{
    const float e = eccentricity_of(aim, direction), spread = spread_of(aim), t = e / spread;
    const struct capped c = capped_of(aim);
    if (e > RND_OUTER_DEG) return 0.0f;
    const float m = fminf(rnd_acuity(t), (float)c.cap);
    return per_steradian(e, 2.0f * (float)M_PI * t * m / (spread * (float)c.total));
}

/* The share of u within 80 degrees. 1 without spread: the fit ends a little before 80 degrees. */
static float polynomial_share(float spread)
{
    float slope;
    return rnd_polynomial_inverse(RND_OUTER_DEG / spread, &slope);
}

/* The fit is only for acuity without a cap. */
static bool is_capped(const struct rnd_aim *aim)
{
    return aim->pixels_per_degree > 0.0f && aim->pixels_per_degree < 120.0f;
}

static void polynomial_sample(const struct rnd_aim *aim, size_t count, const float *u, float *out)
{
    if (is_capped(aim)) {
        exact_sample(aim, count, u, out);
        return;
    }
    const float share = polynomial_share(spread_of(aim));
    float e[SOME], turn[SOME];
    for (size_t first = 0; first < count; first += SOME) {
        const size_t n = count - first < SOME ? count - first : SOME;
#pragma GCC ivdep
        for (size_t i = 0; i < n; i++) {
            float v;
            disc(u[2 * (first + i)], u[2 * (first + i) + 1], &v, &turn[i]);
            e[i] = rnd_polynomial(share * v);
        }
        put(aim, n, e, turn, out + 3 * first);
    }
}

/* The density that the published fit implies: du/de. No sample falls in the gap of thousandths of a degree
 * between its two branches, nor beyond e(1) = 79.97. */
static float polynomial_density(const struct rnd_aim *aim, const float direction[3])
{
    if (is_capped(aim)) return exact_density(aim, direction);
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
    .is_foveated = true,
    .sample = polynomial_sample,
    .density = polynomial_density,
};

const struct rnd_distribution rnd_distribution_fv_exact = {
    .name = "fv-exact",
    .summary = "by visual acuity around the gaze, exact inverse",
    .source = "Koskela 2018, eq. 2 and 5",
    .is_foveated = true,
    .sample = exact_sample,
    .density = exact_density,
};
