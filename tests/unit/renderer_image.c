/* Pictures: written, read, and seen through a rectilinear view. */
#include "renderer_files.h"

static const double deg = M_PI / 180.0;

/* --- files --- */

/* A file that was written reads back: linear formats to their precision, others as 8-bit sRGB. */
static void round_trip(void **state)
{
    (void)state;
    enum { W = 17, H = 5, COUNT = W * H * 3 };
    static const struct {
        const char *name;
        double relative, absolute, largest;
    } kinds[] = {{"a.exr", 0, 0, 1e9}, /* stored as floats: one value is too large for a half */
                 {"A.EXR", 0, 0, 1e9},
                 {"a.hdr", 0.01, 1e-3, 1e9},
                 {"a.png", 0.02, 0.002, 1},
                 {"a.tif", 0.02, 0.002, 1}};
    for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++) {
        float rgb[COUNT];
        char error[RND_ERROR_SIZE] = "";
        int width = 0, height = 0;
        for (int i = 0; i < COUNT; i++) {
            /* the channels of a pixel are equal, because RGBE shares an exponent; one pixel is brighter than
             * any half */
            const double v = i / 3 == 7 ? 1e6 : pow(1.2, i / 3 % 40 - 25);
            rgb[i] = (float)fmin(v, kinds[k].largest == 1 ? 1 : v);
        }
        if (!files_image(files_path(kinds[k].name), W, H, rgb, true, error)) fail_msg("%s", error);
        float *back = rnd_image_read(files_path(kinds[k].name), &width, &height, NULL, error);
        if (!back) fail_msg("%s", error);
        assert_int_equal(width, W);
        assert_int_equal(height, H);
        for (int i = 0; i < COUNT; i++) {
            const double v = fmin(rgb[i], kinds[k].largest);
            assert_float_equal(back[i], v, kinds[k].relative * v + kinds[k].absolute);
        }
        free(back);
    }
}

static long size_of(const char *path)
{
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    assert_int_equal(fseek(file, 0, SEEK_END), 0);
    const long size = ftell(file);
    fclose(file);
    return size;
}

/* An EXR holds half floats unless they would lose something: the radiance of the sun, or a picture so dark
 * that its values lie between two halves. */
static void half_or_float(void **state)
{
    (void)state;
    enum { W = 64, H = 32, COUNT = W * H * 3 };
    static const struct {
        double scale, brightest, tolerance;
    } files[] = {{1, 0, 5e-4}, {1, 65000, 5e-4}, {1, 1.2e5, 0}, {1e-5, 0, 0}, {1e-12, 0, 0}};
    long size[5];
    for (int k = 0; k < 5; k++) {
        static float rgb[COUNT];
        char error[RND_ERROR_SIZE] = "";
        int width, height;
        for (int i = 0; i < COUNT; i++)
            rgb[i] = (float)(files[k].scale * (0.1 + 0.4 * (i * 7919 % COUNT) / COUNT));
        if (files[k].brightest > 0) rgb[300] = (float)files[k].brightest;
        if (!files_image(files_path("range.exr"), W, H, rgb, true, error)) fail_msg("%s", error);
        float *back = rnd_image_read(files_path("range.exr"), &width, &height, NULL, error);
        if (!back) fail_msg("%s", error);
        for (int i = 0; i < COUNT; i++)
            assert_true(fabs((double)back[i] - rgb[i]) <= files[k].tolerance * (double)rgb[i]);
        free(back);
        size[k] = size_of(files_path("range.exr"));
    }
    assert_true(size[0] < size[2] && size[1] < size[2]);
}

/* A grey of 128 out of 255 is sRGB, whatever the number of bits, unless the file says otherwise. */
static void colour_spaces(void **state)
{
    (void)state;
    static const struct {
        int bits;
        uint32_t gamma;
        double expected;
    } files[] = {{8, 0, 0.2158605},      {16, 0, 0.2158605},     {8, 45455, 0.2158605},
                 {16, 45455, 0.2158605}, {8, 100000, 0.5019608}, {16, 100000, 0.5019608},
                 {8, 55556, 0.289205},   {16, 55556, 0.289205}};
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        const int bits = files[i].bits;
        char error[RND_ERROR_SIZE];
        int width, height;
        bool display = false;
        float *rgb = rnd_image_read(files_png("grey.png", bits, bits == 8 ? 128 : 128 * 257, files[i].gamma),
                                    &width, &height, &display, error);
        if (!rgb) fail_msg("%s", error);
        for (int k = 0; k < 6; k++) assert_float_equal(rgb[k], files[i].expected, 1e-5);
        assert_int_equal(display, files[i].gamma != 100000);
        free(rgb);
    }
}

static void refused(void **state)
{
    (void)state;
    static const char *const unwritable[] = {"noending", "none.", "odd.xyz", "icon.ico"};
    const float rgb[3] = {0, 1, 2};
    char error[RND_ERROR_SIZE];
    int width, height;
    for (size_t i = 0; i < sizeof unwritable / sizeof *unwritable; i++) {
        error[0] = 0;
        assert_false(files_image(files_path(unwritable[i]), 1, 1, rgb, false, error));
        assert_non_null(strstr(error, unwritable[i]));
        assert_null(strchr(error, '\n'));
    }
    static const float line[65501 * 3];
    assert_false(files_image(files_path("long.jpg"), 65501, 1, line, false, error));
    assert_non_null(strstr(error, "long.jpg"));
    assert_non_null(strstr(error, "65500"));
    assert_true(files_image(files_path("long.jpg"), 1, 65500, line, false, error));
    assert_null(rnd_image_read(files_path("gone.png"), &width, &height, NULL, error));
    assert_non_null(strstr(error, "gone.png"));
    assert_null(rnd_image_read(files_text("words.exr", "not a picture"), &width, &height, NULL, error));
    assert_non_null(strstr(error, "words.exr"));
    assert_null(strchr(error, '\n'));
    files_text("empty.png", "");
    assert_null(rnd_image_read(files_path("empty.png"), &width, &height, NULL, error));
}

/* --- views --- */

/* A panorama whose pixels are their own directions, as colours. */
static float *compass(int width)
{
    const int height = width / 2;
    float *rgb = malloc((size_t)width * height * 3 * sizeof *rgb);
    assert_non_null(rgb);
    for (int i = 0; i < width * height; i++) {
        const double azimuth = ((i % width + 0.5) / width - 0.5) * 2.0 * M_PI,
                     elevation = (0.5 - (i / width + 0.5) / height) * M_PI;
        rgb[3 * i] = (float)(cos(elevation) * sin(azimuth));
        rgb[3 * i + 1] = (float)sin(elevation);
        rgb[3 * i + 2] = (float)(-cos(elevation) * cos(azimuth));
    }
    return rgb;
}

/* Rotation about an axis, as a quaternion. */
static void turn(const double axis[3], double angle_deg, float out[4])
{
    for (int c = 0; c < 3; c++) out[c] = (float)(axis[c] * sin(0.5 * angle_deg * deg));
    out[3] = (float)cos(0.5 * angle_deg * deg);
}

static void directions(void **state)
{
    (void)state;
    enum { W = 65, H = 49 };
    const double fov = 80 * deg, edge = tan(0.5 * fov) * (W - 1.0) / W, rise = edge * (H - 1.0) / (W - 1.0);
    static const struct {
        double axis[3], angle;
        double ahead[3], right[3]; /* colour in the middle of the view and to the right of it */
    } cases[] = {
        {{0, 1, 0}, 0, {0, 0, -1}, {1, 0, 0}},  {{0, 1, 0}, 90, {-1, 0, 0}, {0, 0, -1}},
        {{0, 1, 0}, -90, {1, 0, 0}, {0, 0, 1}}, {{0, 1, 0}, 180, {0, 0, 1}, {-1, 0, 0}},
        {{1, 0, 0}, 90, {0, 1, 0}, {1, 0, 0}},  {{1, 0, 0}, -90, {0, -1, 0}, {1, 0, 0}},
        {{0, 0, 1}, 90, {0, 0, -1}, {0, 1, 0}}, {{1, 0, 0}, 30, {0, 0.5, -0.8660254}, {1, 0, 0}},
    };
    float *panorama = compass(1024);
    static float view[W * H * 3];
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        const double *a = cases[k].ahead, *r = cases[k].right;
        const double up[3] = {r[1] * a[2] - r[2] * a[1], r[2] * a[0] - r[0] * a[2],
                              r[0] * a[1] - r[1] * a[0]};
        struct rnd_view sight = {.fov_x = (float)fov, .width = W, .height = H};
        turn(cases[k].axis, cases[k].angle, sight.orientation);
        assert_true(rnd_image_view(panorama, 1024, 512, &sight, view));
        for (int i = 0; i < 9; i++) {
            const int x = i % 3 - 1, y = 1 - i / 3;
            const double px = x * edge, py = y * rise, l = sqrt(1 + px * px + py * py);
            const float *seen = view + 3 * ((1 - y) * (H / 2) * W + (x + 1) * (W / 2));
            for (int c = 0; c < 3; c++)
                assert_float_equal(seen[c], (a[c] + px * r[c] + py * up[c]) / l, 0.012);
        }
    }
    free(panorama);
}

/* Stripes along the meridians are visible at the horizon and continue across the seam. At the poles, where
 * they crowd, they become grey. */
static void calm_poles(void **state)
{
    (void)state;
    enum { WIDTH = 2048, HEIGHT = 1024, SIDE = 128 };
    float *stripes = malloc(sizeof *stripes * WIDTH * HEIGHT * 3);
    static float view[SIDE * SIDE * 3];
    assert_non_null(stripes);
    for (int i = 0; i < WIDTH * HEIGHT * 3; i++) stripes[i] = i / 3 % WIDTH / 2 % 2 ? 1.0f : 0.0f;
    static const struct {
        double axis[3], angle, fov, least, most; /* least, most: standard deviation in the view */
    } cases[] = {{{0, 1, 0}, 180, 10, 0.3, 0.5}, {{1, 0, 0}, 90, 8, 0, 0.1}, {{1, 0, 0}, -90, 8, 0, 0.1}};
    for (int k = 0; k < 3; k++) {
        struct rnd_view sight = {.fov_x = (float)(cases[k].fov * deg), .width = SIDE, .height = SIDE};
        turn(cases[k].axis, cases[k].angle, sight.orientation);
        assert_true(rnd_image_view(stripes, WIDTH, HEIGHT, &sight, view));
        double sum = 0.0, square = 0.0;
        for (int i = 0; i < SIDE * SIDE; i++) {
            sum += view[3 * i];
            square += (double)view[3 * i] * view[3 * i];
        }
        const double mean = sum / (SIDE * SIDE), spread = sqrt(square / (SIDE * SIDE) - mean * mean);
        print_message("stripes seen at %g degrees: mean %.3f, spread %.3f\n", cases[k].angle, mean, spread);
        assert_float_equal(mean, 0.5, 0.03);
        assert_true(spread >= cases[k].least && spread <= cases[k].most);
    }
    free(stripes);
}

/* A bright spot looks the same everywhere, at the zenith too. */
static void spot_at_the_pole(void **state)
{
    (void)state;
    enum { W = 1024, H = 512, SIDE = 128, SPOTS = 4 };
    static const double elevation[SPOTS] = {0, 60, 90, -90}, radius = 4, peak = 100;
    float *panorama = malloc(sizeof *panorama * W * H * 3);
    static float view[SIDE * SIDE * 3];
    assert_non_null(panorama);
    for (int k = 0; k < SPOTS; k++) {
        for (int i = 0; i < W * H; i++) {
            const double a = ((i % W + 0.5) / W - 0.5) * 2 * M_PI, e = (0.5 - (i / W + 0.5) / H) * M_PI,
                         s = elevation[k] * deg, cosine = sin(e) * sin(s) + cos(e) * cos(s) * cos(a),
                         r = acos(fmin(1, cosine)) / (radius * deg);
            for (int c = 0; c < 3; c++) panorama[3 * i + c] = (float)(peak * exp(-r * r));
        }
        struct rnd_view sight = {.fov_x = (float)(60 * deg), .width = SIDE, .height = SIDE};
        turn((double[]){1, 0, 0}, elevation[k], sight.orientation);
        assert_true(rnd_image_view(panorama, W, H, &sight, view));
        double worst = 0;
        for (int i = 0; i < SIDE * SIDE; i++) {
            const double x = (2 * (i % SIDE + 0.5) / SIDE - 1) * tan(30 * deg),
                         y = (2 * (i / SIDE + 0.5) / SIDE - 1) * tan(30 * deg),
                         r = atan(sqrt(x * x + y * y)) / (radius * deg);
            worst = fmax(worst, fabs(view[3 * i] - peak * exp(-r * r)));
        }
        print_message("spot at %g degrees: %.1f in its middle, off by %.2f at most\n", elevation[k],
                      (double)view[3 * (SIDE / 2 * SIDE + SIDE / 2)], worst);
        assert_true(worst < 0.05 * peak);
    }
    free(panorama);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(round_trip),    cmocka_unit_test(colour_spaces), cmocka_unit_test(refused),
        cmocka_unit_test(directions),    cmocka_unit_test(calm_poles),    cmocka_unit_test(spot_at_the_pole),
        cmocka_unit_test(half_or_float),
    };
    return cmocka_run_group_tests_name("renderer_image", tests, files_setup, files_teardown);
}
