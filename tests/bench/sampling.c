/* How much smaller the error is with the renderer's sample points than with independent random numbers. The
 * functions are over the unit square, with known means: one is as smooth as a soft shadow, one has an edge,
 * and one has finer detail than the points. */
#include "bench.h"
#include "math/sampler.h"

#include <jansson.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

/* A function to average: its value at x, y in [0,1), and its mean there, which does not depend on the offset
 * of the pattern. */
struct integrand {
    const char *name;
    double (*value)(double x, double y, const double offset[2]);
    double mean;
};

static double smooth(double x, double y, const double offset[2])
{
    (void)offset;
    return sin(M_PI * x) * sin(M_PI * y);
}

static double edge(double x, double y, const double offset[2])
{
    (void)offset;
    return 0.6 * x + 0.8 * y < 0.7;
}

/* The offset is needed: without it, 64 of the renderer's points would give the exact mean, one in each field.
 */
static double checker(double x, double y, const double offset[2])
{
    return ((int)(8 * x + 2 * offset[0]) + (int)(8 * y + 2 * offset[1])) & 1;
}

static const struct integrand integrand[] = {
    {"smooth", smooth, 4 / (M_PI * M_PI)},
    {"edge", edge, 0.5},
    {"checker, 8 x 8", checker, 0.5},
};
enum { INTEGRANDS = sizeof integrand / sizeof *integrand, SIZES = 3, STARTS = 2 };
static const int size[SIZES] = {16, 64, 256};
static const char *const start_name[STARTS] = {"0", "any"};

struct figures {
    double independent, sobol; /* root mean square error over all seeds */
};

static const char help[] = "usage: fovea-bench sampling [OPTION...]\n"
                           "Error of the mean of 16, 64 and 256 samples: with the renderer's points (Sobol, "
                           "Owen-scrambled, addressed by\n"
                           "seed and index) and with independent random numbers.\n"
                           "  --seeds N          root mean square over so many; default 128\n"
                           "  --json             one JSON object instead of the table\n";

/* SplitMix64 (Steele, Lea and Flood 2014), to [0,1). */
static double next(uint64_t *state)
{
    uint64_t z = *state += 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return (double)((z ^ z >> 31) >> 40) * 0x1p-24; /* the same resolution as the renderer's */
}

static struct figures measure(const struct integrand *of, int samples, bool any_start, int seeds)
{
    double independent = 0, sobol = 0;
    for (int s = 0; s < seeds; s++) {
        uint64_t state = rnd_hash((uint32_t)s);
        const double right = next(&state), down = next(&state), offset[2] = {right, down};
        const uint32_t start = any_start ? (uint32_t)(next(&state) * 65536) : 0;
        double sum[2] = {0};
        for (int i = 0; i < samples; i++) {
            const double x = next(&state), y = next(&state);
            float u[2];
            sum[0] += of->value(x, y, offset);
            rnd_pair(rnd_hash((uint32_t)s), 0, start + (uint32_t)i, u);
            sum[1] += of->value((double)u[0], (double)u[1], offset);
        }
        independent += pow(sum[0] / samples - of->mean, 2);
        sobol += pow(sum[1] / samples - of->mean, 2);
    }
    return (struct figures){sqrt(independent / seeds), sqrt(sobol / seeds)};
}

static void print_json(int seeds)
{
    json_t *rows = json_array();
    for (int k = 0; k < INTEGRANDS; k++)
        for (int a = 0; a < STARTS; a++)
            for (int n = 0; n < SIZES; n++) {
                const struct figures f = measure(&integrand[k], size[n], a, seeds);
                json_array_append_new(rows,
                                      json_pack("{s:s,s:s,s:i,s:f,s:f}", "integrand", integrand[k].name,
                                                "first_index", start_name[a], "samples", size[n],
                                                "rmse_independent", f.independent, "rmse_sobol", f.sobol));
            }
    json_t *root = json_pack("{s:i,s:o}", "seeds", seeds, "rows", rows);
    json_dumpf(root, stdout, JSON_INDENT(1) | JSON_REAL_PRECISION(6));
    putchar('\n');
    json_decref(root);
}

static void print_table(int seeds)
{
    printf(
        "root mean square error of a mean over %d seeds, and how many times less it is with Sobol points\n",
        seeds);
    printf("%-16s %-11s", "", "first index");
    for (int n = 0; n < SIZES; n++) printf("  %3d samples: random   Sobol  times", size[n]);
    putchar('\n');
    for (int k = 0; k < INTEGRANDS; k++)
        for (int a = 0; a < STARTS; a++) {
            printf("%-16s %-11s", integrand[k].name, start_name[a]);
            for (int n = 0; n < SIZES; n++) {
                const struct figures f = measure(&integrand[k], size[n], a, seeds);
                printf("  %19.5f %7.5f %6.1f", f.independent, f.sobol, f.independent / f.sobol);
            }
            putchar('\n');
        }
}

int bench_sampling(int count, char **arguments)
{
    int seeds = 128;
    bool json = false;
    const struct bench_option option[] = {{"seeds", BENCH_INT, &seeds, 1, 1, 1000000}, {0}};
    if (!bench_options(count, arguments, help, option, NULL, &json)) return 2;
    (json ? print_json : print_table)(seeds);
    return 0;
}
