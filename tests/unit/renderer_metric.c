/* FLIP and the plain metrics: pictures made of formulas, whose values come from the authors' program
 * (FLIP 1.6), and real pairs of the shared data where that is present.
 */
#include "renderer_files.h"

enum { WIDTH = 96, HEIGHT = 64, COUNT = WIDTH * HEIGHT * 3 };

static float noise(uint32_t i)
{
    i = (i ^ i >> 16) * 0x7feb352dU;
    i = (i ^ i >> 15) * 0x846ca68bU;
    return (float)((i ^ i >> 16) >> 8) * 0x1p-24f;
}

/* A checkerboard on a ramp; hdr: its right half sixteen times as bright. */
static void make_reference(bool hdr, float out[COUNT])
{
    for (int i = 0; i < COUNT; i++) {
        const int x = i / 3 % WIDTH, y = i / 3 / WIDTH;
        const float r = ((float)x + 0.5f) / WIDTH, g = ((float)y + 0.5f) / HEIGHT;
        const float ramp = i % 3 == 0 ? r : i % 3 == 1 ? g : 1 - r;
        const float v = 0.5f * (((x >> 3) + (y >> 3)) & 1 ? 0.75f : 0.25f) + 0.5f * ramp;
        out[i] = hdr ? v * v * (x < WIDTH / 2 ? 1.0f : 16.0f) : v;
    }
}

/* What is wrong with it: nothing, brightness, noise, a shift by a pixel. */
static void make_test(bool hdr, int wrong, const float reference[COUNT], float out[COUNT])
{
    for (int i = 0; i < COUNT; i++) {
        const float v = reference[i];
        const float q = wrong == 0      ? v
                        : wrong == 1    ? 1.1f * v
                        : wrong == 2    ? v * (0.5f + noise((uint32_t)i))
                        : i / 3 % WIDTH ? reference[i - 3]
                                        : v;
        out[i] = hdr ? q : fminf(q, 1);
    }
}

/* LDR, then HDR; each way of being wrong; at 67, 20 and 12 pixels a degree: mean, three quartiles, least,
 * largest, and the errors at 10,10, at 48,32 and at 95,63. */
static const double EXPECTED[24][9] = {
    {0, .0025, .005, .0075, 0, 0, 0, 0, 0},
    {0, .0025, .005, .0075, 0, 0, 0, 0, 0},
    {0, .0025, .005, .0075, 0, 0, 0, 0, 0},
    {.187167, .176179, .187707, .199759, .135799, .243866, .185445, .135799, .216539},
    {.180156, .167774, .181586, .196655, .128102, .247462, .160968, .146944, .215218},
    {.176618, .161705, .178032, .196691, .125563, .247761, .16083, .157204, .215108},
    {.19927, .167226, .217341, .278942, .014958, .547986, .182737, .208951, .401054},
    {.483417, .424392, .524476, .626276, .083415, .934181, .346446, .485546, .702244},
    {.550168, .487561, .591529, .692229, .072908, .962114, .344975, .571521, .708416},
    {.122868, .104421, .199108, .242753, .015458, .320267, .133624, .171208, .06918},
    {.107252, .071347, .142328, .443088, .008711, .54302, .061926, .437577, .050945},
    {.102356, .062198, .169645, .445468, .0048, .547007, .032993, .439417, .051177},
    {0, .0025, .005, .0075, 0, 0, 0, 0, 0},
    {0, .0025, .005, .0075, 0, 0, 0, 0, 0},
    {0, .0025, .005, .0075, 0, 0, 0, 0, 0},
    {.131904, .119756, .143427, .155013, .076366, .182042, .14855, .117696, .125077},
    {.134979, .125361, .143795, .156258, .073739, .18537, .13504, .138445, .125434},
    {.134213, .123411, .141658, .155491, .071588, .188797, .134917, .136025, .125311},
    {.16119, .136159, .171741, .21726, .024652, .464363, .144353, .157158, .240644},
    {.376466, .325589, .4163, .504066, .060007, .765766, .256545, .490931, .465944},
    {.4296, .376923, .468156, .559248, .040651, .816281, .271765, .495557, .474868},
    {.183745, .160195, .281843, .383716, .013096, .719538, .241124, .463196, .132866},
    {.174545, .152128, .398763, .673389, .005969, .971542, .053495, .866162, .113602},
    {.162189, .17112, .558481, .746897, .003247, .974965, .02772, .884083, .11406},
};

static void made_pictures(void **state)
{
    (void)state;
    static const size_t places[3] = {10 * WIDTH + 10, 32 * WIDTH + 48, 63 * WIDTH + 95};
    static const float densities[3] = {RND_FLIP_PPD, 20, 12};
    static float reference[COUNT], test[COUNT], errors[WIDTH * HEIGHT];
    double furthest = 0;
    for (int k = 0; k < 24; k++) {
        const bool hdr = k / 12;
        const double *expected = EXPECTED[k];
        struct rnd_flip flip, again;
        char error[RND_ERROR_SIZE];
        make_reference(hdr, reference);
        make_test(hdr, k / 3 % 4, reference, test);
        if (!rnd_flip(reference, test, WIDTH, HEIGHT, densities[k % 3], hdr, errors, &flip, error))
            fail_msg("%s", error);
        double least = 1;
        for (int i = 0; i < WIDTH * HEIGHT; i++) least = fmin(least, errors[i]);
        furthest = fmax(furthest, fabs(flip.mean - expected[0]));
        assert_float_equal(flip.mean, expected[0], 5e-5);
        /* An error beside the edge of a bin may fall into another one. */
        for (int i = 0; i < 3; i++) assert_float_equal(flip.quartile[i], expected[1 + i], 2e-4);
        assert_float_equal(least, expected[4], 5e-5);
        assert_float_equal(flip.largest, expected[5], 5e-5);
        for (int i = 0; i < 3; i++) assert_float_equal(errors[places[i]], expected[6 + i], 5e-5);
        if (k / 3 % 4 == 0) assert_true(flip.mean == 0 && flip.largest == 0);
        assert_int_equal(flip.exposures, hdr ? 4 : 0);
        assert_float_equal(flip.start, hdr ? -2.406464 : 0, 2e-6);
        assert_float_equal(flip.stop, hdr ? 1.342813 : 0, 2e-6);

        assert_true(rnd_flip(reference, test, WIDTH, HEIGHT, densities[k % 3], hdr, NULL, &again, error));
        assert_memory_equal(&again, &flip, sizeof flip);
    }
    print_message("24 cases, means within %.1e\n", furthest);
}

static void plain_metrics(void **state)
{
    (void)state;
    static const double psnr[] = {INFINITY, 25.4294, 16.6244, 21.4391};
    static const double relative[2][4] = {{0, .009337, .075290, .045220}, {0, .008661, .072882, .269473}};
    static float reference[COUNT], test[COUNT];
    for (int i = 0; i < 8; i++) {
        make_reference(i / 4, reference);
        make_test(i / 4, i % 4, reference, test);
        assert_float_equal(rnd_relative_mse(test, reference, COUNT), relative[i / 4][i % 4], 2e-6);
        if (i >= 4) continue;
        /* The expected values are of these numbers as they are, so they are what sRGB shows. */
        for (int j = 0; j < 2 * COUNT; j++) {
            float *v = j < COUNT ? &reference[j] : &test[j - COUNT];
            *v = *v <= 0.04045f ? *v / 12.92f : powf((*v + 0.055f) / 1.055f, 2.4f);
        }
        if (i == 0)
            assert_true(isinf(rnd_psnr(test, reference, COUNT)));
        else
            assert_float_equal(rnd_psnr(test, reference, COUNT), psnr[i], 2e-4);
    }
}

/* Pictures that are mostly or all black set no endless range of exposures; what is wrong in them is seen. */
static void dark_pictures(void **state)
{
    (void)state;
    static float reference[COUNT], test[COUNT];
    struct rnd_flip flip;
    char error[RND_ERROR_SIZE];
    for (int i = 0; i < 300; i++) reference[i] = 5000;
    memcpy(test, reference, sizeof test);
    for (int i = 6000; i < 9000; i++) test[i] = 1;
    assert_true(rnd_flip(reference, test, WIDTH, HEIGHT, 20, true, NULL, &flip, error));
    assert_int_equal(flip.exposures, 24);
    assert_float_equal(flip.stop - flip.start, 24, 1e-9);
    assert_true(flip.mean > 0.1 && flip.largest <= 1);

    memset(reference, 0, sizeof reference);
    assert_true(rnd_flip(reference, test, WIDTH, HEIGHT, 20, true, NULL, &flip, error));
    assert_int_equal(flip.exposures, 2);
    assert_true(flip.mean > 0.1 && flip.largest <= 1);
    assert_true(rnd_flip(reference, reference, WIDTH, HEIGHT, 20, true, NULL, &flip, error));
    assert_true(flip.mean == 0);

    /* as bright as floats go, and below nothing */
    for (int i = 0; i < COUNT; i++) reference[i] = i % 2 ? 3.4e38f : -3.4e38f, test[i] = -reference[i];
    assert_true(rnd_flip(reference, test, WIDTH, HEIGHT, 20, true, NULL, &flip, error));
    assert_true(flip.mean > 0.1 && flip.largest <= 1);
    assert_true(rnd_flip(reference, test, WIDTH, HEIGHT, 20, false, NULL, &flip, error));
    assert_true(flip.mean > 0.1 && flip.largest <= 1);
}

/* Smaller than any filter, and at the ends of the range of densities. */
static void odd_sizes(void **state)
{
    (void)state;
    static const int sizes[][2] = {{1, 1}, {1, 64}, {64, 1}, {2, 3}, {85, 7}};
    static const float densities[] = {1, 1.42f, 7.4f, 300};
    static float black[COUNT], white[COUNT], errors[WIDTH * HEIGHT];
    struct rnd_flip flip;
    char error[RND_ERROR_SIZE];
    for (int i = 0; i < COUNT; i++) white[i] = 1;
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++)
        for (size_t d = 0; d < sizeof densities / sizeof *densities; d++) {
            assert_true(
                rnd_flip(black, white, sizes[s][0], sizes[s][1], densities[d], false, errors, &flip, error));
            /* HyAB of black and white is 100, of green and blue 202.6: without edges it is the same
             * everywhere */
            const double expected = 0.95 + (pow(100, 0.7) / 41.276096 - 0.4) / 0.6 * 0.05;
            assert_float_equal(flip.mean, expected, 2e-5);
            assert_float_equal(flip.largest, expected, 2e-5);
        }
}

static void refused(void **state)
{
    (void)state;
    static float reference[COUNT], test[COUNT];
    static const struct {
        int width, height;
        float ppd;
        const char *word;
    } bad[] = {{0, 64, 67, "0x64"},   {96, -1, 67, "96x-1"}, {65537, 1, 67, "65537x1"},
               {96, 64, 0.9f, "0.9"}, {96, 64, 301, "301"},  {96, 64, NAN, "nan"}};
    struct rnd_flip flip;
    char error[RND_ERROR_SIZE];
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++) {
        assert_false(
            rnd_flip(reference, test, bad[k].width, bad[k].height, bad[k].ppd, true, NULL, &flip, error));
        assert_non_null(strstr(error, bad[k].word));
        assert_null(strchr(error, '\n'));
    }
    test[3 * (5 * WIDTH + 7) + 2] = NAN;
    assert_false(rnd_flip(reference, test, WIDTH, HEIGHT, 67, false, NULL, &flip, error));
    assert_string_equal(error, "a pixel of the test is not finite, at 7,5");
    reference[COUNT - 1] = INFINITY;
    assert_false(rnd_flip(reference, test, WIDTH, HEIGHT, 67, true, NULL, &flip, error));
    assert_string_equal(error, "a pixel of the reference is not finite, at 95,63");
}

/* --- real pictures --- */

static float *read_shared(const char *name, int *out_width, int *out_height, bool *out_display)
{
    char path[512], error[RND_ERROR_SIZE];
    snprintf(path, sizeof path, SHARED_DATA "/metrics/flip/%s", name);
    float *rgb = rnd_image_read(path, out_width, out_height, out_display, error);
    if (!rgb) fail_msg("%s", error);
    return rgb;
}

static void real_pictures(void **state)
{
    (void)state;
    static const struct {
        const char *reference, *test;
        float ppd;
        double mean, quartile[3], largest; /* 0: not known */
        double near; /* of quartiles: those of the last two are from sorted errors, not from bins */
    } pairs[] = {
        {"tree-ref.png",
         "tree-test.png",
         RND_FLIP_PPD,
         0.133276,
         {0.184586, 0.333096, 0.503230},
         0.983034,
         1e-4},
        {"tree-ref.png", "tree-test.png", 40, 0.146625, {0}, 0, 0},
        {"tree-ref.png", "tree-test.png", 20, 0.160173, {0}, 0, 0},
        {"hdr-reference.exr", "hdr-test-noise.exr", RND_FLIP_PPD, 0.282030, {0, 0.312844, 0}, 0, 4e-4},
        {"hdr-reference.exr", "hdr-test-blur.exr", RND_FLIP_PPD, 0.065328, {0, 0.175147, 0}, 0, 4e-4},
    };
    if (access(SHARED_DATA "/metrics/flip/tree-ref.png", R_OK) != 0) {
        print_message("no shared data: real pictures are left out\n");
        skip();
    }
    for (size_t k = 0; k < sizeof pairs / sizeof *pairs; k++) {
        struct rnd_flip flip;
        char error[RND_ERROR_SIZE];
        int width, height;
        bool display, same;
        float *reference = read_shared(pairs[k].reference, &width, &height, &display),
              *test = read_shared(pairs[k].test, &width, &height, &same);
        assert_int_equal(display, k < 3);
        assert_int_equal(same, display);
        if (!rnd_flip(reference, test, width, height, pairs[k].ppd, !display, NULL, &flip, error))
            fail_msg("%s", error);
        print_message("%s at %.2f: mean %.6f, quartiles %.6f %.6f %.6f, largest %.6f, %d exposures\n",
                      pairs[k].test, pairs[k].ppd, flip.mean, flip.quartile[0], flip.quartile[1],
                      flip.quartile[2], flip.largest, flip.exposures);
        assert_float_equal(flip.mean, pairs[k].mean, 5e-5);
        for (int i = 0; i < 3; i++)
            if (pairs[k].quartile[i] > 0)
                assert_float_equal(flip.quartile[i], pairs[k].quartile[i], pairs[k].near);
        if (pairs[k].largest > 0) assert_float_equal(flip.largest, pairs[k].largest, 5e-5);
        assert_int_equal(flip.exposures, display ? 0 : 11);
        assert_float_equal(flip.start, display ? 0 : -8.4544, 1e-4);
        assert_float_equal(flip.stop, display ? 0 : 2.1208, 1e-4);
        free(reference);
        free(test);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(made_pictures), cmocka_unit_test(plain_metrics), cmocka_unit_test(dark_pictures),
        cmocka_unit_test(odd_sizes),     cmocka_unit_test(refused),       cmocka_unit_test(real_pictures),
    };
    return cmocka_run_group_tests_name("renderer_metric", tests, NULL, NULL);
}
