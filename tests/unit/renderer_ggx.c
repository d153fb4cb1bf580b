/* The arithmetic of the hot loops: polynomials for sines, fitted albedos of GGX against quadratures, and the
 * white furnace of metallic-roughness at every roughness and angle. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "material/ggx.h"

static const double deg = M_PI / 180.0;

static void turns(void **state)
{
    (void)state;
    double worst = 0.0;
    for (int i = 0; i <= 1000000; i++) {
        const float turn = (float)i / 1000000;
        float s, c;
        rnd_turn(turn, &s, &c);
        worst = fmax(worst, fmax(fabs(s - sin(2 * M_PI * turn)), fabs(c - cos(2 * M_PI * turn))));
    }
    print_message("sine and cosine of a turn: off by at most %.2g\n", worst);
    assert_true(worst < 3e-7);
}

/* The albedo, and the part of it that Schlick's term weighs, in doubles: midpoint rule over visible normals
 * (Heitz 2014). */
static void quadrature(double cosine, double alpha, double *out_all, double *out_edge)
{
    enum { UP = 200, AROUND = 160 };
    const double sine = sqrt(1 - cosine * cosine), stretch = hypot(alpha * sine, cosine);
    const double vx = alpha * sine / stretch, vz = cosine / stretch;
    const double lo = sqrt(1 + alpha * alpha * (1 / (cosine * cosine) - 1));
    *out_all = *out_edge = 0.0;
    for (int k = 0; k < UP * AROUND; k++) {
        const double down = (k / AROUND + 0.5) / UP * (1 + vz), azimuth = (k % AROUND + 0.5) / AROUND * M_PI;
        const double radius = sqrt(down * (2 - down));
        double hx = alpha * (radius * cos(azimuth) + vx), hy = alpha * radius * sin(azimuth),
               hz = 1 - down + vz;
        const double length = sqrt(hx * hx + hy * hy + hz * hz);
        hx /= length, hz /= length;
        const double c = sine * hx + cosine * hz, wi = 2 * c * hz - cosine;
        if (wi <= 0) continue;
        const double li = sqrt(1 + alpha * alpha * (1 / (wi * wi) - 1));
        const double g = (1 + lo) / (lo + li) / (UP * AROUND);
        *out_all += g;
        *out_edge += g * pow(1 - fmin(c, 1), 5);
    }
}

static void albedos(void **state)
{
    (void)state;
    double worst_all = 0, worst_edge = 0, worst_mean = 0;
    for (int r = 0; r <= 20; r++) {
        const float alpha = rnd_alpha(r / 20.0f);
        double mean_all = 0, mean_edge = 0;
        for (int k = 0; k < 24; k++) {
            const double cosine = (k + 0.5) / 24;
            double all, edge;
            quadrature(cosine, alpha, &all, &edge);
            mean_all += 2 * cosine * all / 24, mean_edge += 2 * cosine * edge / 24;
            if (cosine < 0.08) continue;
            const struct rnd_albedo a = rnd_ggx_albedo((float)cosine, alpha);
            worst_all = fmax(worst_all, fabs((1 - a.lost) / all - 1));
            worst_edge = fmax(worst_edge, fabs(a.edge - edge));
        }
        const struct rnd_albedo mean = rnd_ggx_mean_albedo(alpha);
        worst_mean = fmax(worst_mean, fmax(fabs(1 - mean.lost - mean_all), fabs(mean.edge - mean_edge)));
    }
    print_message("albedo of GGX: off by %.2f %%, its edge by %.4f, their means by %.4f\n", 100 * worst_all,
                  worst_edge, worst_mean);
    assert_true(worst_all < 0.0035);
    assert_true(worst_edge < 0.0025);
    assert_true(worst_mean < 0.003);
}

/* The mean weight of evenly spaced draws on a white surface. */
static double furnace(float metallic, float roughness, double angle)
{
    enum { SIDE = 128 };
    const struct rnd_mr m =
        rnd_mr(rnd_v3(1, 1, 1), metallic, rnd_alpha(roughness), rnd_v3(0.04f, 0.04f, 0.04f), 1);
    const struct rnd_v3 wo = {(float)sin(angle), 0, (float)cos(angle)};
    double sum = 0.0;
    for (uint32_t k = 0; k < SIDE * SIDE; k++) {
        struct rnd_v3 wi, weight, f;
        float pdf, again;
        rnd_mr_draw(&m, wo,
                    rnd_v3((k / SIDE + 0.5f) / SIDE, (k % SIDE + 0.5f) / SIDE,
                           (float)(k * 0x9e3779b1u >> 8) * 0x1p-24f),
                    &wi, &weight, &pdf);
        rnd_mr_eval(&m, wo, wi, &f, &again);
        assert_true(pdf == again && weight.x >= 0);
        sum += weight.x;
    }
    return sum / (SIDE * SIDE);
}

static void white_furnace(void **state)
{
    (void)state;
    for (int metallic = 0; metallic <= 2; metallic++) {
        double least = 9, most = 0;
        for (int r = 0; r <= 20; r++)
            for (int angle = 0; angle <= 85; angle += 5) {
                const double out = furnace(0.5f * metallic, r / 20.0f, angle * deg);
                least = fmin(least, out), most = fmax(most, out);
            }
        print_message("white furnace, metallic %.1f, roughness 0 to 1, 0 to 85 degrees: %.4f to %.4f\n",
                      0.5 * metallic, least, most);
        assert_true(least > 0.99 && most < 1.005);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(turns),
        cmocka_unit_test(albedos),
        cmocka_unit_test(white_furnace),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
