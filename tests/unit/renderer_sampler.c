/* The random numbers: known values, and the properties that make them better than random ones. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdio.h>
#include <string.h>

#include "math/sampler.h"
#include "statistics.h"

/* The first points of Sobol's sequence without scrambling, as published. */
static void unscrambled_points(void **state)
{
    (void)state;
    static const float expected[5][2] = {
        {0, 0}, {0.5f, 0.5f}, {0.25f, 0.75f}, {0.75f, 0.25f}, {0.125f, 0.625f}};
    for (uint32_t i = 0; i < 5; i++) {
        assert_float_equal(rnd_unit(rnd_reverse(i)), expected[i][0], 0);
        assert_float_equal(rnd_unit(rnd_reverse(rnd_pascal(i))), expected[i][1], 0);
    }
}

/* Owen-scrambled with seed 1 in the first dimension and 2 in the second; the index is not shuffled. */
static void scrambled_points(void **state)
{
    (void)state;
    static const double expected[2][2] = {{.834503069, .417251534}, {.175997687, .972870699}};
    for (uint32_t i = 0; i < 2; i++) {
        assert_true(fabs(rnd_reverse(rnd_permute(i, 1)) * 0x1p-32 - expected[i][0]) < 1e-9);
        assert_true(fabs(rnd_reverse(rnd_permute(rnd_pascal(i), 2)) * 0x1p-32 - expected[i][1]) < 1e-9);
    }
}

static void bits(void **state)
{
    (void)state;
    assert_int_equal(rnd_reverse(1), 0x80000000u);
    assert_int_equal(rnd_reverse(0x12345678u), 0x1e6a2c48u);
    assert_float_equal(rnd_unit(UINT32_MAX), 1.0 - 0x1p-24, 0);
    assert_float_equal(rnd_unit(0), 0.0, 0);
    for (uint32_t i = 0; i < 1000; i++) /* flipping a bit flips it in the result, and changes no lower bit */
        for (uint32_t seed = 0; seed < 20; seed++)
            for (int b = 0; b < 32; b += 5)
                assert_int_equal((rnd_permute(i, seed) ^ rnd_permute(i ^ 1u << b, seed)) & ((2u << b) - 1),
                                 1u << b);
}

/* Each aligned block of 2^k points has one point in every elementary interval of 2^-a x 2^-(k-a). */
static void assert_net(uint32_t seed, uint32_t dimension, uint32_t block, int k)
{
    enum { MOST = 1 << 10 };
    uint8_t seen[MOST];
    for (int a = 0; a <= k; a++) {
        memset(seen, 0, sizeof seen);
        for (uint32_t i = 0; i < 1u << k; i++) {
            float u[2];
            rnd_pair(seed, dimension, (block << k) + i, u);
            assert_true(u[0] >= 0.0f && u[0] < 1.0f && u[1] >= 0.0f && u[1] < 1.0f);
            const uint32_t x = (uint32_t)(u[0] * (float)(1 << a)),
                           y = (uint32_t)(u[1] * (float)(1 << (k - a)));
            assert_int_equal(seen[x << (k - a) | y]++, 0);
        }
    }
}

static void net(void **state)
{
    (void)state;
    for (uint32_t seed = 0; seed < 8; seed++)
        for (uint32_t dimension = 0; dimension < 8; dimension++)
            for (int k = 0; k <= 10; k++)
                for (uint32_t block = 0; block < 3; block++)
                    assert_net(rnd_hash(seed), dimension, block * 7919u & ((1u << 22) - 1), k);
}

/* A number depends only on its address: it is the same in any order and in any subset. */
static void addressed(void **state)
{
    (void)state;
    float first[64][2], again[2];
    for (uint32_t i = 0; i < 64; i++) rnd_pair(5, 3, i, first[i]);
    for (uint32_t i = 64; i-- > 0;) {
        rnd_pair(5, 3, i, again);
        assert_memory_equal(again, first[i], sizeof again);
    }
}

/* How two streams' coordinates correlate over 4096 points: the correlation coefficient times the square root
 * of the number of points, and chi-square of a 16 x 16 table of their pairs. */
static void compare(const uint32_t one[2], int a, const uint32_t other[2], int b, double *out_r,
                    double *out_chi)
{
    enum { GRID = 16, POINTS = 4096 };
    const double expected = (double)POINTS / (GRID * GRID);
    int count[GRID][GRID] = {0};
    double r = 0.0, chi = 0.0;
    for (uint32_t i = 0; i < POINTS; i++) {
        float u[2], v[2];
        rnd_pair(one[0], one[1], i, u);
        rnd_pair(other[0], other[1], i, v);
        r += (u[a] - 0.5) * (v[b] - 0.5);
        count[(int)(u[a] * GRID)][(int)(v[b] * GRID)]++;
    }
    for (int i = 0; i < GRID * GRID; i++) {
        const double d = count[i / GRID][i % GRID] - expected;
        chi += d * d / expected;
    }
    *out_r = 12.0 * r / sqrt(POINTS);
    *out_chi = chi;
}

/* Streams of different dimensions, seeds and neighbouring pixels. Each block of 16 points pairs the table's
 * 16 columns with its 16 rows by a permutation. If all permutations were equally likely, the mean of chi-
 * square would be 240, and r would have a standard deviation of one. Owen's permutations are fewer: with a
 * perfect hash for every node of the tree, the same pairs give 236 to 241 and 1.1 to 1.3, and the largest r
 * is 3.6. */
static void uncorrelated(void **state)
{
    (void)state;
    enum { KINDS = 3, PAIRS = 300 };
    static const char *const name[KINDS] = {"dimensions", "seeds", "pixels"};
    for (int kind = 0; kind < KINDS; kind++) {
        double most = 0.0, square = 0.0, mean = 0.0;
        for (uint32_t i = 0; i < PAIRS; i++) {
            const uint32_t near = kind == 2   ? rnd_hash2(77, i)
                                  : kind == 1 ? i
                                              : 1234,
                           far = kind == 2   ? rnd_hash2(77, i + 1)
                                 : kind == 1 ? i + 1
                                             : 1234;
            const uint32_t one[2] = {near, kind == 0 ? i : 2}, other[2] = {far, kind == 0 ? i + 1 : 2};
            double r, chi;
            compare(one, i & 1, other, i >> 1 & 1, &r, &chi);
            most = fmax(most, fabs(r));
            square += r * r / PAIRS;
            mean += chi / PAIRS;
        }
        print_message("neighbouring %s: r spread %.3f, most %.2f; chi-square %.1f\n", name[kind],
                      sqrt(square), most, mean);
        assert_true(most < 5.0 && sqrt(square) < 1.5);
        assert_true(mean > 225.0 && mean < 255.0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(unscrambled_points),
        cmocka_unit_test(scrambled_points),
        cmocka_unit_test(bits),
        cmocka_unit_test(net),
        cmocka_unit_test(addressed),
        cmocka_unit_test(uncorrelated),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
