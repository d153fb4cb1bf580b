/* The metrics: FLIP of synthetic pictures against values of the authors' program (FLIP 1.6), and of real
 * pairs where the shared data is present; plain metrics; weights; and what is refused. */
#include "renderer_files.h"

enum { WIDTH = 96, HEIGHT = 64, COUNT = WIDTH * HEIGHT * 3 };

static const double deg = M_PI / 180;

static struct rnd_measure measure(const char *name, const struct rnd_pair *pair, float *out_map)
{
    struct rnd_measure out;
    char error[RND_ERROR_SIZE];
    if (!rnd_measure(rnd_metric_find(name), pair, out_map, &out, error)) fail_msg("%s: %s", name, error);
    return out;
}

static struct rnd_pair made_pair(const float *reference, const float *test, bool hdr, float ppd)
{
    return (struct rnd_pair){.reference = reference,
                             .test = test,
                             .width = WIDTH,
                             .height = HEIGHT,
                             .display = !hdr,
                             .pixels_per_degree = ppd};
}

static struct rnd_measure flip_of(const struct rnd_pair *pair, float *out_map)
{
    return measure(pair->display ? "ldr_flip" : "hdr_flip", pair, out_map);
}

/* Returns NAN if there is no figure with this key. */
static double figure(const struct rnd_measure *of, const char *key)
{
    for (int i = 0; i < of->figures; i++)
        if (strcmp(of->figure[i].key, key) == 0) return of->figure[i].value;
    return NAN;
}

static const char *const QUARTILES[] = {"first_quartile", "median", "third_quartile"};

static float noise(uint32_t i)
{
    i = (i ^ i >> 16) * 0x7feb352dU;
    i = (i ^ i >> 15) * 0x846ca68bU;
    return (float)((i ^ i >> 16) >> 8) * 0x1p-24f;
}

/* A checkerboard on a ramp. If `hdr`, its right half is sixteen times as bright. */
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

/* The reference with an error: 0 none, 1 brightness, 2 noise, 3 shifted by a pixel. */
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

/* Order of rows: LDR, then HDR; within that the four errors; within that 67, 20 and 12 pixels per degree.
 * Columns: mean, three quartiles, smallest, largest, and the errors at the pixels (10, 10), (48, 32) and (95,
 * 63). */
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
        const struct rnd_pair pair = made_pair(reference, test, hdr, densities[k % 3]);
        make_reference(hdr, reference);
        make_test(hdr, k / 3 % 4, reference, test);
        const struct rnd_measure flip = flip_of(&pair, errors), again = flip_of(&pair, NULL);
        double least = 1;
        for (int i = 0; i < WIDTH * HEIGHT; i++) least = fmin(least, errors[i]);
        furthest = fmax(furthest, fabs(flip.value - expected[0]));
        assert_float_equal(flip.value, expected[0], 5e-5);
        /* An error at the edge of a bin may fall into its neighbour. */
        for (int i = 0; i < 3; i++) assert_float_equal(figure(&flip, QUARTILES[i]), expected[1 + i], 2e-4);
        assert_float_equal(least, expected[4], 5e-5);
        assert_float_equal(figure(&flip, "largest"), expected[5], 5e-5);
        for (int i = 0; i < 3; i++) assert_float_equal(errors[places[i]], expected[6 + i], 5e-5);
        if (k / 3 % 4 == 0) assert_true(flip.value == 0 && figure(&flip, "largest") == 0);
        assert_true(figure(&flip, "mean") == flip.value);
        assert_int_equal(isnan(figure(&flip, "exposures.count")), !hdr);
        if (hdr) {
            assert_true(figure(&flip, "exposures.count") == 4);
            assert_float_equal(figure(&flip, "exposures.first_stops"), -2.406464, 2e-6);
            assert_float_equal(figure(&flip, "exposures.last_stops"), 1.342813, 2e-6);
        }
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
        const struct rnd_pair pair = made_pair(reference, test, i / 4, 0);
        make_reference(i / 4, reference);
        make_test(i / 4, i % 4, reference, test);
        assert_float_equal(measure("relative_mse", &pair, NULL).value, relative[i / 4][i % 4], 2e-6);
        if (i >= 4) continue;
        /* The expected PSNR is that of these numbers as sRGB, so make them linear. */
        for (int j = 0; j < 2 * COUNT; j++) {
            float *v = j < COUNT ? &reference[j] : &test[j - COUNT];
            *v = *v <= 0.04045f ? *v / 12.92f : powf((*v + 0.055f) / 1.055f, 2.4f);
        }
        if (i == 0)
            assert_true(isinf(measure("psnr_db", &pair, NULL).value));
        else
            assert_float_equal(measure("psnr_db", &pair, NULL).value, psnr[i], 2e-4);
    }
}

/* Pictures that are mostly or completely black do not give an endless range of exposures, and their errors
 * are found. */
static void dark_pictures(void **state)
{
    (void)state;
    static float reference[COUNT], test[COUNT];
    const struct rnd_pair pair = made_pair(reference, test, true, 20),
                          same = made_pair(reference, reference, true, 20),
                          shown = made_pair(reference, test, false, 20);
    for (int i = 0; i < 300; i++) reference[i] = 5000;
    memcpy(test, reference, sizeof test);
    for (int i = 6000; i < 9000; i++) test[i] = 1;
    struct rnd_measure flip = flip_of(&pair, NULL);
    assert_true(figure(&flip, "exposures.count") == 24);
    assert_float_equal(figure(&flip, "exposures.last_stops") - figure(&flip, "exposures.first_stops"), 24,
                       1e-9);
    assert_true(flip.value > 0.1 && figure(&flip, "largest") <= 1);

    memset(reference, 0, sizeof reference);
    flip = flip_of(&pair, NULL);
    assert_true(figure(&flip, "exposures.count") == 2);
    assert_true(flip.value > 0.1 && figure(&flip, "largest") <= 1);
    assert_true(flip_of(&same, NULL).value == 0);

    /* The largest and the lowest float. */
    for (int i = 0; i < COUNT; i++) reference[i] = i % 2 ? 3.4e38f : -3.4e38f, test[i] = -reference[i];
    flip = flip_of(&pair, NULL);
    assert_true(flip.value > 0.1 && figure(&flip, "largest") <= 1);
    flip = flip_of(&shown, NULL);
    assert_true(flip.value > 0.1 && figure(&flip, "largest") <= 1);
}

/* Pictures smaller than any filter, and the fewest and the most pixels per degree. */
static void odd_sizes(void **state)
{
    (void)state;
    static const int sizes[][2] = {{1, 1}, {1, 64}, {64, 1}, {2, 3}, {85, 7}};
    static const float densities[] = {1, 1.42f, 7.4f, 300};
    static float black[COUNT], white[COUNT], errors[WIDTH * HEIGHT];
    for (int i = 0; i < COUNT; i++) white[i] = 1;
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++)
        for (size_t d = 0; d < sizeof densities / sizeof *densities; d++) {
            struct rnd_pair pair = made_pair(black, white, false, densities[d]);
            pair.width = sizes[s][0];
            pair.height = sizes[s][1];
            const struct rnd_measure flip = flip_of(&pair, errors);
            /* HyAB of black and white is 100, that of green and blue 202.6. Without edges the error is the
             * same everywhere. */
            const double expected = 0.95 + (pow(100, 0.7) / 41.276096 - 0.4) / 0.6 * 0.05;
            assert_float_equal(flip.value, expected, 2e-5);
            assert_float_equal(figure(&flip, "largest"), expected, 2e-5);
        }
}

static void assert_refused(const char *name, const struct rnd_pair *pair, const char *expected)
{
    struct rnd_measure out;
    char error[RND_ERROR_SIZE];
    assert_false(rnd_measure(rnd_metric_find(name), pair, NULL, &out, error));
    if (!strstr(error, expected)) fail_msg("'%s' is not in: %s", expected, error);
    assert_null(strchr(error, '\n'));
}

static bool no_more(struct rnd_pair *pair)
{
    (void)pair;
    return false;
}

static void refused(void **state)
{
    (void)state;
    static float reference[COUNT], test[COUNT], weight[WIDTH * HEIGHT];
    static const struct {
        int width, height;
        float ppd;
        const char *word;
    } bad[] = {{0, 64, 67, "0x64"},   {96, -1, 67, "96x-1"}, {65537, 1, 67, "65537x1"},
               {96, 64, 0.9f, "0.9"}, {96, 64, 301, "301"},  {96, 64, NAN, "nan"}};
    struct rnd_pair pair;
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++) {
        pair = made_pair(reference, test, true, bad[k].ppd);
        pair.width = bad[k].width;
        pair.height = bad[k].height;
        assert_refused("hdr_flip", &pair, bad[k].word);
    }
    pair = made_pair(reference, test, true, 0);
    assert_refused("hdr_flip", &pair, "HDR-FLIP needs pixels per degree");
    assert_refused("psnr_db", &pair, "PSNR needs values for a display");
    assert_refused("relative_rmse", &pair, "rel. RMSE needs panoramas");
    pair.next = no_more;
    assert_refused("relative_mse", &pair, "rel. MSE needs single pictures");
    pair = made_pair(reference, test, false, 67);
    assert_refused("hdr_flip", &pair, "HDR-FLIP needs radiance");

    pair.weight = weight;
    assert_refused("psnr_db", &pair, "no pixel has any weight");
    weight[5 * WIDTH + 7] = -1;
    assert_refused("psnr_db", &pair, "the weight -1, at 7,5, is not");
    weight[5 * WIDTH + 7] = INFINITY;
    assert_refused("psnr_db", &pair, "the weight inf, at 7,5, is not");
    pair.weight = NULL;

    test[3 * (5 * WIDTH + 7) + 2] = NAN;
    assert_refused("ldr_flip", &pair, "a pixel of the test is not finite, at 7,5");
    reference[COUNT - 1] = INFINITY;
    pair.display = false;
    assert_refused("hdr_flip", &pair, "a pixel of the reference is not finite, at 95,63");
    assert_refused("relative_mse", &pair, "a pixel of the reference is not finite, at 95,63");
}

/* Every metric can be found by name, describes its value, refuses only pairs that do not suit it, and finds a
 * picture nearer to itself than to a noisy one. */
static void table(void **state)
{
    (void)state;
    static float reference[COUNT], test[COUNT];
    const struct rnd_metric *metric;
    size_t count = 0;
    make_reference(false, reference);
    make_test(false, 2, reference, test);
    for (; (metric = rnd_metric_at(count)); count++) {
        assert_ptr_equal(rnd_metric_find(metric->name), metric);
        assert_true(metric->label[0] && metric->summary[0] && metric->source[0] && metric->unit);
        for (int kind = 0; kind < 8; kind++) {
            struct rnd_pair pair = made_pair(reference, test, kind & 1, kind & 2 ? 20 : 0);
            struct rnd_measure noisy, none;
            char error[RND_ERROR_SIZE] = "";
            pair.panorama = kind & 4;
            assert_int_equal(rnd_measure(metric, &pair, NULL, &noisy, error), rnd_metric_fits(metric, &pair));
            assert_int_equal(error[0] == 0, rnd_metric_fits(metric, &pair));
            if (!rnd_metric_fits(metric, &pair)) continue;
            pair.test = reference;
            assert_true(rnd_measure(metric, &pair, NULL, &none, error));
            assert_true(metric->higher_is_better ? none.value > noisy.value : none.value < noisy.value);
        }
    }
    assert_null(rnd_metric_find("absent"));
    print_message("%zu metrics\n", count);
    assert_true(count >= 5);
}

/* Pixels of weight 0 do not count, equal weights change nothing, and doubling a weight is like doubling the
 * pixels. */
static void weights(void **state)
{
    (void)state;
    static float reference[COUNT], test[COUNT], weight[WIDTH * HEIGHT];
    const struct rnd_metric *metric;
    for (int hdr = 0; hdr < 2; hdr++)
        for (size_t k = 0; (metric = rnd_metric_at(k)); k++) {
            struct rnd_pair pair = made_pair(reference, test, hdr, 20);
            pair.panorama = true;
            if (!rnd_metric_fits(metric, &pair)) continue;
            make_reference(hdr, reference);
            make_test(hdr, 2, reference, test);
            const double plain = measure(metric->name, &pair, NULL).value;
            pair.weight = weight;
            for (int i = 0; i < WIDTH * HEIGHT; i++) weight[i] = 3;
            assert_float_equal(measure(metric->name, &pair, NULL).value, plain, 1e-12);

            /* The left half is correct, the right half is wrong. FLIP's filters reach a few pixels across the
             * border. */
            for (int i = 0; i < COUNT; i++)
                if (i / 3 % WIDTH < WIDTH / 2) test[i] = reference[i];
            double value[3];
            for (int c = 0; c < 3; c++) {
                for (int i = 0; i < WIDTH * HEIGHT; i++)
                    weight[i] = i % WIDTH < WIDTH / 2 - 16   ? (float)(2 - c)
                                : i % WIDTH < WIDTH / 2 + 16 ? 0
                                                             : (float)c;
                value[c] = measure(metric->name, &pair, NULL).value;
            }
            pair.test = reference;
            assert_true(value[0] == measure(metric->name, &pair, NULL).value);
            assert_true(value[1] != value[0] && value[2] != value[0] && value[2] != value[1]);
        }

    /* The metric is a mean: with equal weights, half of the error remains. */
    static float black[COUNT], grey[COUNT];
    struct rnd_pair pair = made_pair(black, grey, true, 0);
    for (int i = 0; i < COUNT; i++) grey[i] = i / 3 % WIDTH < WIDTH / 4 ? 0.1f : 0;
    assert_float_equal(measure("relative_mse", &pair, NULL).value, 0.25, 1e-6);
    for (int i = 0; i < WIDTH * HEIGHT; i++) weight[i] = i % WIDTH < WIDTH / 4 ? 3 : 1;
    pair.weight = weight;
    assert_float_equal(measure("relative_mse", &pair, NULL).value, 0.5, 1e-6);
}

/* --- relative RMSE --- */

enum { ROUND = 256, ROUND_COUNT = ROUND * ROUND / 2 };

static double rmse_in_disc(const float *test, const float *reference, const float gaze[3], double radius)
{
    static float weight[ROUND_COUNT];
    rnd_weigh_ring(ROUND, ROUND / 2, gaze, 0, (float)radius, weight);
    const struct rnd_pair pair = {.reference = reference,
                                  .test = test,
                                  .width = ROUND,
                                  .height = ROUND / 2,
                                  .panorama = true,
                                  .weight = weight};
    return measure("relative_rmse", &pair, NULL).value;
}

static void relative_rmse(void **state)
{
    (void)state;
    static float reference[3 * ROUND_COUNT], test[3 * ROUND_COUNT];
    const float ahead[3] = {0, 0, -1}, up[3] = {0, 1, 0}, seam[3] = {0, 0, 1};
    for (int i = 0; i < 3 * ROUND_COUNT; i++) reference[i] = 2.0f;
    memcpy(test, reference, sizeof test);
    assert_true(rmse_in_disc(test, reference, ahead, 4) == 0.0);
    for (int i = 0; i < 3 * ROUND_COUNT; i++) test[i] = 3.0f;
    assert_float_equal(rmse_in_disc(test, reference, ahead, 4), 0.5, 1e-6);
    assert_float_equal(rmse_in_disc(test, reference, up, 0.1), 0.5, 1e-6);

    /* All pixels within an angle of the pole are wrong by their own value: a share (1 - cos) / 2 of the
     * sphere. */
    memcpy(test, reference, sizeof test);
    for (int i = 0; i < 3 * ROUND_COUNT; i++)
        if (i / 3 / ROUND < 21) test[i] = 0.0f;
    const double cosine = cos(42.0 / ROUND * M_PI), share = (1 - cosine) / 2;
    assert_float_equal(rmse_in_disc(test, reference, ahead, 4), sqrt(share), 0.003);
    assert_float_equal(rmse_in_disc(test, reference, up, 25 * deg), 1, 1e-6);
    assert_true(rmse_in_disc(test, reference, ahead, 50 * deg) == 0.0);
    assert_float_equal(rmse_in_disc(test, reference, up, 60 * deg), sqrt((1 - cosine) / (1 - cos(60 * deg))),
                       0.01);

    /* Only luminance counts, and the seam is not an edge. */
    memcpy(test, reference, sizeof test);
    for (int i = 0; i < ROUND_COUNT; i++) test[3 * i + 1] += 0.2f;
    assert_float_equal(rmse_in_disc(test, reference, seam, 0.5), 0.7152 * 0.1, 1e-5);
    memset(reference, 0, sizeof reference);
    assert_true(isinf(rmse_in_disc(test, reference, ahead, 4)));
}

/* A ring of eccentricity has the right solid angle everywhere, up to half a row at its edges. */
static void rings(void **state)
{
    (void)state;
    static const float gaze[][3] = {{0, 0, -1}, {0, 1, 0}, {0, 0, 1}, {0.6f, -0.8f, 0}};
    static const double ends[][2] = {{0, 20}, {20, 50}, {50, 180}};
    static float weight[ROUND_COUNT];
    for (size_t g = 0; g < 4; g++)
        for (size_t r = 0; r < 3; r++) {
            double share = 0, whole = 0;
            rnd_weigh_ring(ROUND, ROUND / 2, gaze[g], (float)(ends[r][0] * deg), (float)(ends[r][1] * deg),
                           weight);
            for (int i = 0; i < ROUND_COUNT; i++) {
                const double area = sin(M_PI * (i / ROUND + 0.5) / (ROUND / 2.0));
                share += area * (double)weight[i];
                whole += area;
            }
            assert_float_equal(share / whole, (cos(ends[r][0] * deg) - cos(ends[r][1] * deg)) / 2, 0.007);
        }
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
        double near; /* of quartiles; the last two pairs have theirs from sorted errors, not from bins */
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
        int width, height;
        bool display, same;
        float *reference = read_shared(pairs[k].reference, &width, &height, &display),
              *test = read_shared(pairs[k].test, &width, &height, &same);
        assert_int_equal(display, k < 3);
        assert_int_equal(same, display);
        struct rnd_pair pair = made_pair(reference, test, !display, pairs[k].ppd);
        pair.width = width;
        pair.height = height;
        const struct rnd_measure flip = flip_of(&pair, NULL);
        print_message("%s at %.2f: mean %.6f\n%s", pairs[k].test, (double)pairs[k].ppd, flip.value,
                      flip.note);
        assert_float_equal(flip.value, pairs[k].mean, 5e-5);
        for (int i = 0; i < 3; i++)
            if (pairs[k].quartile[i] > 0)
                assert_float_equal(figure(&flip, QUARTILES[i]), pairs[k].quartile[i], pairs[k].near);
        if (pairs[k].largest > 0) assert_float_equal(figure(&flip, "largest"), pairs[k].largest, 5e-5);
        assert_int_equal(isnan(figure(&flip, "exposures.count")), display);
        if (!display) {
            assert_true(figure(&flip, "exposures.count") == 11);
            assert_float_equal(figure(&flip, "exposures.first_stops"), -8.4544, 1e-4);
            assert_float_equal(figure(&flip, "exposures.last_stops"), 2.1208, 1e-4);
        }
        free(reference);
        free(test);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(table),         cmocka_unit_test(weights),       cmocka_unit_test(made_pictures),
        cmocka_unit_test(plain_metrics), cmocka_unit_test(relative_rmse), cmocka_unit_test(rings),
        cmocka_unit_test(dark_pictures), cmocka_unit_test(odd_sizes),     cmocka_unit_test(refused),
        cmocka_unit_test(real_pictures),
    };
    return cmocka_run_group_tests_name("renderer_metric", tests, NULL, NULL);
}
