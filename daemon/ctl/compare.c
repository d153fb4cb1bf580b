/* foveactl compare: how different two pictures are to an eye, and by the plain figures of older results. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include <jansson.h>

#include "ctl.h"
#include "image.h"

struct comparison {
    const struct ctl *ctl;
    float *reference, *test, *errors;
    int width, height;
    bool display; /* one of them at least is encoded for a display */
    bool hdr;
    struct rnd_flip flip;
    double relative_mse, relative_rmse, psnr_db; /* NAN: not asked of such pictures */
};

static bool read_both(struct comparison *c)
{
    char *const *path = c->ctl->operand, error[RND_ERROR_SIZE];
    bool display[2];
    int width, height;

    c->reference = rnd_image_read(path[0], &c->width, &c->height, &display[0], error);
    if (!c->reference) return ctl_fail("%s", error);
    c->test = rnd_image_read(path[1], &width, &height, &display[1], error);
    if (!c->test) return ctl_fail("%s", error);
    if (width != c->width || height != c->height)
        return ctl_fail("%s is %dx%d, but %s is %dx%d", path[0], c->width, c->height, path[1], width, height);
    c->display = display[0] || display[1];
    c->hdr = !c->display && !c->ctl->ldr;
    return true;
}

static bool measure(struct comparison *c)
{
    static const float AHEAD[3] = {0, 0, -1};
    size_t pixels = (size_t)c->width * (size_t)c->height;
    char error[RND_ERROR_SIZE];

    c->errors = malloc(pixels * sizeof(*c->errors));
    if (!c->errors) return ctl_fail("out of memory");
    if (!rnd_flip(c->reference, c->test, c->width, c->height, (float)c->ctl->ppd, c->hdr, c->errors, &c->flip,
                  error))
        return ctl_fail("%s against %s: %s", c->ctl->operand[1], c->ctl->operand[0], error);
    c->relative_mse = rnd_relative_mse(c->test, c->reference, 3 * pixels);
    c->relative_rmse = c->width == 2 * c->height ? rnd_relative_rmse(c->test, c->reference, c->width,
                                                                     c->height, AHEAD, 2 * (float)M_PI)
                                                 : NAN;
    c->psnr_db = c->hdr ? NAN : rnd_psnr(c->test, c->reference, 3 * pixels);
    return true;
}

static bool write_map(const struct comparison *c)
{
    size_t pixels = (size_t)c->width * (size_t)c->height;
    float *rgb = malloc(pixels * 3 * sizeof(*rgb));
    char error[RND_ERROR_SIZE];
    bool good;

    if (!rgb) return ctl_fail("out of memory");
    for (size_t i = 0; i < pixels; i++) ctl_colour(CTL_MAGMA, c->errors[i], &rgb[3 * i]);
    good =
        dmn_image_write(c->ctl->map, 0666, c->width, c->height, rgb, false, error) || ctl_fail("%s", error);
    free(rgb);
    return good;
}

static void print_table(const struct comparison *c)
{
    const struct rnd_flip *flip = &c->flip;

    dmn_print(stdout, "%s against %s: %dx%d, %s\n", c->ctl->operand[1], c->ctl->operand[0], c->width, c->height,
           c->hdr       ? "both hold light"
           : c->display ? "values for a display"
                        : "light from 0 to 1, as a display shows it");
    printf("%s-FLIP   %.6f  mean, at %.4g pixels a degree; 0 is no difference, 1 the largest\n",
           c->hdr ? "HDR" : "LDR", flip->mean, c->ctl->ppd);
    if (c->hdr)
        printf("           the worst of %d exposures from %+.2f to %+.2f stops\n", flip->exposures,
               flip->start, flip->stop);
    printf("quartiles  %.6f  %.6f  %.6f, each pixel counting by its error, from bins of 0.01\n",
           flip->quartile[0], flip->quartile[1], flip->quartile[2]);
    printf("largest    %.6f\n", flip->largest);
    printf("rel. MSE   %.6g  mean of (test - reference)^2 / (reference^2 + %g), linear\n", c->relative_mse,
           RND_RELATIVE_MSE_EPSILON);
    if (!isnan(c->relative_rmse))
        printf("rel. RMSE  %.6g  of luminance, to the reference's mean, over the sphere (2:1: a panorama)\n",
               c->relative_rmse);
    if (!isnan(c->psnr_db)) printf("PSNR       %.4f dB  of sRGB values\n", c->psnr_db);
    if (c->ctl->map) dmn_print(stdout, "map        %s\n", c->ctl->map);
}

/* JSON has no infinity. */
static json_t *number(double value)
{
    return isfinite(value) ? json_real(value) : json_null();
}

static void print_json(const struct comparison *c)
{
    const struct rnd_flip *flip = &c->flip;
    json_t *object = json_pack(
        "{s:[i,i], s:s, s:f, s:f, s:f, s:f, s:f, s:f, s:f, s:f, s:o, s:o}", "size", c->width, c->height,
        "metric", c->hdr ? "HDR-FLIP" : "LDR-FLIP", "pixels_per_degree", c->ctl->ppd, "mean", flip->mean,
        "median", flip->quartile[1], "first_quartile", flip->quartile[0], "third_quartile", flip->quartile[2],
        "largest", flip->largest, "relative_mse", c->relative_mse, "relative_mse_epsilon",
        RND_RELATIVE_MSE_EPSILON, "relative_rmse", number(c->relative_rmse), "psnr_db", number(c->psnr_db));

    if (c->hdr)
        json_object_set_new(object, "exposures",
                            json_pack("{s:i, s:f, s:f}", "count", flip->exposures, "first_stops", flip->start,
                                      "last_stops", flip->stop));
    if (object) json_dumpf(object, stdout, JSON_INDENT(2) | JSON_REAL_PRECISION(9));
    if (object) putchar('\n');
    json_decref(object);
}

int ctl_compare(const struct ctl *ctl)
{
    struct comparison comparison = {.ctl = ctl};
    bool good = read_both(&comparison) && measure(&comparison) && (!ctl->map || write_map(&comparison));

    if (good) (ctl->json ? print_json : print_table)(&comparison);
    free(comparison.reference);
    free(comparison.test);
    free(comparison.errors);
    return good ? 0 : 1;
}
