/* FLIP: how different two pictures look to somebody who flips between them on one screen. LDR-FLIP by
 * Andersson et al. 2020, HDR-FLIP by Andersson et al. 2021, from the formulas; constants as of the authors'
 * program 1.6. It is a metric of flat pictures: of a panorama, compare views.
 *
 * A picture is read row by row. Every row becomes seven bands, filtered along it; a ring of such rows is then
 * filtered across, so that memory grows with the width alone. Both pictures go on together, and each finished
 * row is compared at once.
 */
#include "metric/flip.h"
#include "metric/metric.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    MAX_RADIUS = 41, /* of a kernel at RND_FLIP_MAX_PPD */
    BANDS = 7,
    RESULTS = 8,
    BINS = 100
};

/* What a row is made of: YCxCz, a linear form of CIELab. */
enum { ACHROMATIC, RED_GREEN, BLUE_YELLOW, SOURCES };

struct kernel {
    int radius;
    float tap[2 * MAX_RADIUS + 1];
};

/* Along a row, band i is a source filtered by kernel i: contrast sensitivity, the last channel's in two
 * parts; then a Gaussian and its first and second derivative. */
static const int SOURCE_OF[BANDS] = {ACHROMATIC, RED_GREEN,  BLUE_YELLOW, BLUE_YELLOW,
                                     ACHROMATIC, ACHROMATIC, ACHROMATIC};
enum { FIRST_PART = 2, SECOND_PART = 3, SMOOTH = 4, SLOPE = 5, BEND = 6 };

/* Across rows. */
static const struct {
    int band, kernel;
} ACROSS[RESULTS] = {
    {ACHROMATIC, ACHROMATIC}, {RED_GREEN, RED_GREEN}, {FIRST_PART, FIRST_PART}, {SECOND_PART, SECOND_PART},
    {SLOPE, SMOOTH},          {SMOOTH, SLOPE},        {BEND, SMOOTH},           {SMOOTH, BEND}};
enum { EDGE = 4, POINT = 6 };

struct picture {
    const float *rgb;
    float *ring;   /* 2 * radius + 1 rows of BANDS x width */
    float *result; /* RESULTS x width: the row in hand */
};

struct flip {
    int width, height, radius; /* the largest kernel's */
    struct kernel kernel[BANDS];
    struct picture picture[2]; /* reference, test */
    float *row;                /* SOURCES x (width + 2 * radius): a row with its ends repeated */
    float largest;             /* colour difference, to the power */
};

/* --- colours --- */

/* Linear Rec.709 to CIE XYZ relative to its white, and back. */
static void xyz_of(const float rgb[3], float out[3])
{
    static const float M[3][3] = {
        {10135552.0f / 24577794.0f, 8788810.0f / 24577794.0f, 4435075.0f / 24577794.0f},
        {2613072.0f / 12288897.0f, 8788810.0f / 12288897.0f, 887015.0f / 12288897.0f},
        {1425312.0f / 73733382.0f, 8788810.0f / 73733382.0f, 70074185.0f / 73733382.0f},
    };
    static const float white[3] = {0.950428545f, 1.0f, 1.088900371f};
    for (int i = 0; i < 3; i++)
        out[i] = (M[i][0] * rgb[0] + M[i][1] * rgb[1] + M[i][2] * rgb[2]) * (1.0f / white[i]);
}

static void rgb_of(const float xyz[3], float out[3])
{
    static const float M[3][3] = {
        {3.241003275f * 0.950428545f, -1.537398934f, -0.498615861f * 1.088900371f},
        {-0.969224334f * 0.950428545f, 1.875930071f, 0.041554224f * 1.088900371f},
        {0.055639423f * 0.950428545f, -0.204011202f, 1.057148933f * 1.088900371f},
    };
    for (int i = 0; i < 3; i++) {
        const float value = M[i][0] * xyz[0] + M[i][1] * xyz[1] + M[i][2] * xyz[2];
        out[i] = fminf(1.0f, fmaxf(0.0f, value));
    }
}

static float lightness(float x)
{
    const float delta = 6.0f / 29.0f;
    return x > delta * delta * delta ? cbrtf(x) : x / (3.0f * delta * delta) + 4.0f / 29.0f;
}

/* CIELab, whose colours fade with lightness (Hunt effect). */
static void lab_of(const float rgb[3], float out[3])
{
    float xyz[3];
    xyz_of(rgb, xyz);
    const float x = lightness(xyz[0]), y = lightness(xyz[1]), z = lightness(xyz[2]);
    out[0] = 116.0f * y - 16.0f;
    out[1] = 0.01f * out[0] * 500.0f * (x - y);
    out[2] = 0.01f * out[0] * 200.0f * (y - z);
}

/* HyAB distance (Abasi et al. 2020) to the power 0.7. */
static float difference_of(const float a[3], const float b[3])
{
    const float u = a[1] - b[1], v = a[2] - b[2];
    return powf(fabsf(a[0] - b[0]) + sqrtf(u * u + v * v), 0.7f);
}

/* --- filters --- */

static double fill_gaussian(struct kernel *kernel, int radius, double amplitude, double falloff)
{
    double sum = 0.0;
    kernel->radius = radius;
    for (int i = -radius; i <= radius; i++) {
        const double tap = amplitude * exp(-falloff * i * i);
        kernel->tap[i + radius] = (float)tap;
        sum += tap;
    }
    return sum;
}

static void divide(struct kernel *kernel, double by)
{
    for (int i = 0; i <= 2 * kernel->radius; i++) kernel->tap[i] = (float)(kernel->tap[i] / by);
}

/* Derivatives of the Gaussian of width sigma, whose taps above and below zero each sum up to 1. */
static void fill_derivative(struct kernel *kernel, int radius, double sigma, bool second)
{
    double tap[2 * MAX_RADIUS + 1], above = 0.0, below = 0.0;
    kernel->radius = radius;
    for (int i = -radius; i <= radius; i++) {
        const double t = i / sigma, value = (second ? t * t - 1.0 : -i) * exp(-0.5 * t * t);
        tap[i + radius] = value;
        *(value > 0.0 ? &above : &below) += fabs(value);
    }
    for (int i = 0; i <= 2 * radius; i++) kernel->tap[i] = (float)(tap[i] / (tap[i] > 0.0 ? above : below));
}

/* Contrast sensitivity of the three channels (2020, section 4.1) and detectors of edges and points (4.2). */
static void fill_kernels(struct flip *flip, double ppd)
{
    static const double B[4] = {0.0047, 0.0053, 0.04, 0.025}, A[4] = {1.0, 1.0, 34.1, 13.5};
    const int radius = (int)ceil(3.0 * sqrt(0.04 / (2.0 * M_PI * M_PI)) * ppd);
    const double sigma = 0.5 * 0.082 * ppd;
    const int wide = (int)ceil(3.0 * sigma);
    double sum[4];
    for (int i = 0; i < 4; i++) {
        const double amplitude = i < FIRST_PART ? 1.0 : sqrt(A[i] * sqrt(M_PI / B[i]));
        sum[i] = fill_gaussian(&flip->kernel[i], radius, amplitude, M_PI * M_PI / (B[i] * ppd * ppd));
    }
    for (int i = 0; i < 4; i++)
        divide(&flip->kernel[i], i < FIRST_PART ? sum[i] : hypot(sum[FIRST_PART], sum[SECOND_PART]));
    divide(&flip->kernel[SMOOTH], fill_gaussian(&flip->kernel[SMOOTH], wide, 1.0, 0.5 / (sigma * sigma)));
    fill_derivative(&flip->kernel[SLOPE], wide, sigma, false);
    fill_derivative(&flip->kernel[BEND], wide, sigma, true);
    flip->radius = radius > wide ? radius : wide;
}

static void add_scaled(float *to, const float *from, float by, int width)
{
    for (int x = 0; x < width; x++) to[x] += by * from[x];
}

/* Take row y of a picture, at a gain in stops or, if it is NAN, as it is, into the ring. */
static void take_row(struct flip *flip, struct picture *picture, int y, double stops)
{
    const int width = flip->width, radius = flip->radius, padded = width + 2 * radius;
    const float *rgb = picture->rgb + 3 * (size_t)y * (size_t)width;
    const double gain = exp2(stops);
    for (int x = 0; x < width; x++, rgb += 3) {
        float shown[3], xyz[3];
        for (int c = 0; c < 3; c++)
            shown[c] = isnan(stops) ? fminf(1.0f, fmaxf(0.0f, rgb[c])) : rnd_flip_tone(rgb[c] * gain);
        xyz_of(shown, xyz);
        float *at = flip->row + radius + x;
        at[ACHROMATIC * padded] = 116.0f * xyz[1] - 16.0f;
        at[RED_GREEN * padded] = 500.0f * (xyz[0] - xyz[1]);
        at[BLUE_YELLOW * padded] = 200.0f * (xyz[1] - xyz[2]);
    }
    for (int s = 0; s < SOURCES; s++) {
        float *row = flip->row + s * padded + radius;
        for (int i = 1; i <= radius; i++) row[-i] = row[0], row[width - 1 + i] = row[width - 1];
    }
    float *band = picture->ring + (size_t)(y % (2 * radius + 1)) * BANDS * (size_t)width;
    memset(band, 0, sizeof *band * BANDS * (size_t)width);
    for (int b = 0; b < BANDS; b++, band += width) {
        const struct kernel *kernel = &flip->kernel[b];
        const float *row = flip->row + SOURCE_OF[b] * padded + radius;
        for (int i = -kernel->radius; i <= kernel->radius; i++)
            add_scaled(band, row + i, kernel->tap[i + kernel->radius], width);
    }
}

static void filter_across(const struct flip *flip, const struct picture *picture, int y)
{
    const size_t width = (size_t)flip->width;
    float *result = picture->result;
    memset(result, 0, sizeof *result * RESULTS * width);
    for (int r = 0; r < RESULTS; r++, result += width) {
        const struct kernel *kernel = &flip->kernel[ACROSS[r].kernel];
        for (int i = -kernel->radius; i <= kernel->radius; i++) {
            const int at = y + i < 0 ? 0 : y + i >= flip->height ? flip->height - 1 : y + i;
            const size_t slot = (size_t)(at % (2 * flip->radius + 1));
            add_scaled(result, picture->ring + (slot * BANDS + (size_t)ACROSS[r].band) * width,
                       kernel->tap[i + kernel->radius], flip->width);
        }
    }
}

/* --- comparison --- */

static void filtered_lab(const float *result, size_t width, float out[3])
{
    const float cz = result[FIRST_PART * width] + result[SECOND_PART * width];
    const float y = (result[0] + 16.0f) / 116.0f;
    const float xyz[3] = {y + result[width] / 500.0f, y, y - cz / 200.0f};
    float rgb[3];
    rgb_of(xyz, rgb);
    lab_of(rgb, out);
}

/* How strong an edge or a point is there; the bands are in units of lightness, 116 of them. */
static float strength(const float *result, size_t width, int which)
{
    const float x = result[which * width], y = result[(which + 1) * width];
    return sqrtf(x * x + y * y) / 116.0f;
}

/* Raise the row of errors to those at this exposure, where these are larger. */
static void compare_row(const struct flip *flip, float *errors)
{
    static const float knee = 0.4f, kept = 0.95f; /* differences to 0.4 of the largest take 0 to 0.95 */
    const size_t width = (size_t)flip->width;
    for (size_t x = 0; x < width; x++) {
        const float *a = flip->picture[0].result + x, *b = flip->picture[1].result + x;
        float lab[2][3];
        filtered_lab(a, width, lab[0]);
        filtered_lab(b, width, lab[1]);
        const float d = difference_of(lab[0], lab[1]) / flip->largest;
        const float colour = d < knee ? d * kept / knee : kept + (d - knee) / (1.0f - knee) * (1.0f - kept);
        const float edge = fabsf(strength(a, width, EDGE) - strength(b, width, EDGE)),
                    point = fabsf(strength(a, width, POINT) - strength(b, width, POINT));
        const float feature = sqrtf(fmaxf(edge, point) * (float)M_SQRT1_2);
        errors[x] = fmaxf(errors[x], powf(colour, fmaxf(0.0f, 1.0f - feature)));
    }
}

static void compare_at(struct flip *flip, double stops, float *errors)
{
    for (int y = 0, taken = 0; y < flip->height; y++) {
        for (; taken <= y + flip->radius && taken < flip->height; taken++)
            for (int i = 0; i < 2; i++) take_row(flip, &flip->picture[i], taken, stops);
        for (int i = 0; i < 2; i++) filter_across(flip, &flip->picture[i], y);
        compare_row(flip, errors + (size_t)y * (size_t)flip->width);
    }
}

/* Percentiles where each pixel counts by its error, from bins (the authors' program). */
static double percentile(const double bin[BINS], double share)
{
    double total = 0.0, before = 0.0;
    for (int i = 0; i < BINS; i++) total += bin[i] * (i + 0.5);
    for (int i = 0; i < BINS; i++) {
        const double weight = bin[i] * (i + 0.5);
        if (before + weight > share * total) return (i + (share * total - before) / weight) / BINS;
        before += weight;
    }
    return 1.0;
}

/* Sum up the errors of all pixels; exposures are NULL for LDR-FLIP. */
static void sum_up(const struct rnd_pair *pair, const float *errors,
                   const struct rnd_flip_exposures *exposures, struct rnd_measure *out)
{
    double bin[BINS] = {0}, quartile[3], sum = 0.0, weights = 0.0, largest = 0.0;
    for (size_t i = 0; i < (size_t)pair->width * (size_t)pair->height; i++) {
        const int b = (int)(errors[i] * BINS);
        const double weight = rnd_pair_weight(pair, i);
        bin[b < BINS ? b : BINS - 1] += weight;
        sum += weight * errors[i];
        weights += weight;
        if (weight > 0.0) largest = fmax(largest, errors[i]);
    }
    out->value = sum / weights;
    for (int i = 0; i < 3; i++) quartile[i] = percentile(bin, 0.25 * (i + 1));
    rnd_measure_add(out, "mean", out->value, false);
    rnd_measure_add(out, "median", quartile[1], false);
    rnd_measure_add(out, "first_quartile", quartile[0], false);
    rnd_measure_add(out, "third_quartile", quartile[2], false);
    rnd_measure_add(out, "largest", largest, false);
    int length = 0;
    if (exposures) {
        rnd_measure_add(out, "exposures.count", exposures->count, true);
        rnd_measure_add(out, "exposures.first_stops", exposures->start, false);
        rnd_measure_add(out, "exposures.last_stops", exposures->stop, false);
        length = snprintf(out->note, sizeof out->note,
                          "           the worst of %d exposures from %+.2f to %+.2f stops\n",
                          exposures->count, exposures->start, exposures->stop);
    }
    snprintf(out->note + length, sizeof out->note - (size_t)length,
             "quartiles  %.6f  %.6f  %.6f, each pixel counting by its error, from bins of 0.01\n"
             "largest    %.6f\n",
             quartile[0], quartile[1], quartile[2], largest);
}

static bool init(struct flip *flip, float ppd, char out_error[RND_ERROR_SIZE])
{
    static const float green[3] = {0, 1, 0}, blue[3] = {0, 0, 1};
    float lab[2][3];
    lab_of(green, lab[0]);
    lab_of(blue, lab[1]);
    flip->largest = difference_of(lab[0], lab[1]);
    fill_kernels(flip, ppd);
    const size_t width = (size_t)flip->width, radius = (size_t)flip->radius;
    flip->row = malloc(sizeof(float) * SOURCES * (width + 2 * radius));
    bool good = flip->row;
    for (int i = 0; i < 2; i++) {
        flip->picture[i].ring = malloc(sizeof(float) * (2 * radius + 1) * BANDS * width);
        flip->picture[i].result = malloc(sizeof(float) * RESULTS * width);
        good = good && flip->picture[i].ring && flip->picture[i].result;
    }
    if (!good) snprintf(out_error, RND_ERROR_SIZE, "not enough memory");
    return good;
}

static bool compute(const struct rnd_pair *pair, const struct rnd_flip_exposures *exposures, float *out_map,
                    struct rnd_measure *out_measure, char out_error[RND_ERROR_SIZE])
{
    if (!(pair->pixels_per_degree >= 1.0f && pair->pixels_per_degree <= RND_FLIP_MAX_PPD)) {
        snprintf(out_error, RND_ERROR_SIZE, "%g pixels per degree are not between 1 and %d",
                 pair->pixels_per_degree, RND_FLIP_MAX_PPD);
        return false;
    }
    const size_t count = (size_t)pair->width * (size_t)pair->height;
    struct flip flip = {.width = pair->width,
                        .height = pair->height,
                        .picture = {{.rgb = pair->reference}, {.rgb = pair->test}}};
    float *errors = out_map ? out_map : malloc(sizeof *errors * count);
    bool good = init(&flip, pair->pixels_per_degree, out_error);
    if (good && !errors) {
        snprintf(out_error, RND_ERROR_SIZE, "not enough memory");
        good = false;
    }
    if (good) {
        memset(errors, 0, sizeof *errors * count);
        if (!exposures) compare_at(&flip, NAN, errors);
        for (int i = 0; exposures && i < exposures->count; i++) {
            const double step = (exposures->stop - exposures->start) / (exposures->count - 1);
            compare_at(&flip, exposures->start + i * step, errors);
        }
        sum_up(pair, errors, exposures, out_measure);
    }
    for (int i = 0; i < 2; i++) free(flip.picture[i].ring), free(flip.picture[i].result);
    free(flip.row);
    if (errors != out_map) free(errors);
    return good;
}

static bool compute_hdr(const struct rnd_pair *pair, float *out_map, struct rnd_measure *out_measure,
                        char out_error[RND_ERROR_SIZE])
{
    const struct rnd_flip_exposures exposures =
        rnd_flip_exposures(pair->reference, (size_t)pair->width * (size_t)pair->height);
    return compute(pair, &exposures, out_map, out_measure, out_error);
}

static bool compute_ldr(const struct rnd_pair *pair, float *out_map, struct rnd_measure *out_measure,
                        char out_error[RND_ERROR_SIZE])
{
    return compute(pair, NULL, out_map, out_measure, out_error);
}

/* The largest error over a range of exposures. The whole reference decides the range, whatever its pixels
 * weigh. */
const struct rnd_metric rnd_metric_hdr_flip = {
    .name = "hdr_flip",
    .label = "HDR-FLIP",
    .unit = "",
    .summary = "mean",
    .range = "0 is no difference, 1 the largest",
    .source = "Andersson et al. 2021",
    .decimals = 6,
    .values = RND_RADIANCE,
    .needs_density = true,
    .map = true,
    .compute = compute_hdr,
};

/* The error of what a display shows of values from 0 to 1. */
const struct rnd_metric rnd_metric_ldr_flip = {
    .name = "ldr_flip",
    .label = "LDR-FLIP",
    .unit = "",
    .summary = "mean",
    .range = "0 is no difference, 1 the largest",
    .source = "Andersson et al. 2020",
    .decimals = 6,
    .values = RND_DISPLAY_VALUES,
    .needs_density = true,
    .map = true,
    .compute = compute_ldr,
};
