/* Statistics for tests: uniform random numbers that are not the renderer's, and the chi-square test. */
#ifndef FOVEAD_TESTS_STATISTICS_H
#define FOVEAD_TESTS_STATISTICS_H

#include <math.h>
#include <stddef.h>
#include <stdint.h>

/* The i-th number of a stream, in [0, 1), with 24 bits so that it is exact as a float (SplitMix64, Steele
 * 2014). */
static inline float stat_uniform(uint32_t stream, uint32_t i)
{
    uint64_t z = ((uint64_t)stream << 32 | i) * 0x9e3779b97f4a7c15u + 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return (float)((z ^ z >> 31) >> 40) * 0x1p-24f;
}

/* Regularised upper incomplete gamma function Q(a, x): series below a + 1, continued fraction (Lentz) above
 * (Press et al. 2007, Numerical Recipes, section 6.2). */
static inline double stat_gamma_q(double a, double x)
{
    if (x <= 0.0) return 1.0;
    const double scale = exp(-x + a * log(x) - lgamma(a));
    if (x < a + 1.0) {
        double term = 1.0 / a, sum = term;
        for (double n = a + 1.0; fabs(term) > 1e-15 * fabs(sum); n += 1.0) sum += term *= x / n;
        return 1.0 - sum * scale;
    }
    double b = x + 1.0 - a, c = 1e300, d = 1.0 / b, h = d, step = 0.0;
    for (int i = 1; i < 100000 && fabs(step - 1.0) > 1e-14; i++) {
        const double an = -i * (i - a);
        b += 2.0;
        d = 1.0 / (an * d + b);
        c = b + an / c;
        step = d * c;
        h *= step;
    }
    return scale * h;
}

/* The probability that chance gives a chi-square at least this large. */
static inline double stat_chi_square_tail(double chi_square, double degrees_of_freedom)
{
    return stat_gamma_q(0.5 * degrees_of_freedom, 0.5 * chi_square);
}

/* p-value of the hypothesis that counts[n] were drawn with expected[n] (same sum). Cells that expect fewer
 * than ten are merged; if the merged cell still expects fewer, it is left out. */
static inline double stat_chi_square_p(const double *counts, const double *expected, size_t n)
{
    double chi = 0.0, rest_count = 0.0, rest_expected = 0.0;
    int cells = 0;
    for (size_t i = 0; i < n; i++) {
        if (expected[i] < 10.0) {
            rest_count += counts[i];
            rest_expected += expected[i];
            continue;
        }
        chi += (counts[i] - expected[i]) * (counts[i] - expected[i]) / expected[i];
        cells++;
    }
    if (rest_expected >= 10.0) {
        chi += (rest_count - rest_expected) * (rest_count - rest_expected) / rest_expected;
        cells++;
    }
    return stat_chi_square_tail(chi, cells - 1);
}

#endif
