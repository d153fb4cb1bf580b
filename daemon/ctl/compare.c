/* foveactl compare: how different two pictures look, and the plain figures of older results. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <jansson.h>

#include "ctl.h"
#include "image.h"

struct comparison {
    const struct ctl *ctl;
    float *reference, *test, *errors;
    bool encoded; /* at least one of the files is encoded for a display */
    struct rnd_pair pair;
    const struct rnd_metric *mapped; /* the first metric that fits and has a map; errors is its map */
    struct rnd_measure *measure;     /* of each metric, if it fits */
};

static bool read_both(struct comparison *c)
{
    char *const *path = c->ctl->operand, error[RND_ERROR_SIZE];
    struct rnd_pair *pair = &c->pair;
    bool display[2];
    int width, height;

    c->reference = rnd_image_read(path[0], &pair->width, &pair->height, &display[0], error);
    if (!c->reference) return ctl_fail("%s", error);
    c->test = rnd_image_read(path[1], &width, &height, &display[1], error);
    if (!c->test) return ctl_fail("%s", error);
    if (width != pair->width || height != pair->height)
        return ctl_fail("%s is %dx%d, but %s is %dx%d", path[0], pair->width, pair->height, path[1], width,
                        height);
    c->encoded = display[0] || display[1];
    pair->reference = c->reference;
    pair->test = c->test;
    pair->panorama = width == 2 * height;
    pair->display = c->encoded || c->ctl->ldr;
    pair->pixels_per_degree = (float)c->ctl->ppd;
    return true;
}

static bool measure(struct comparison *c)
{
    const struct rnd_metric *metric;
    size_t count = 0;
    char error[RND_ERROR_SIZE];

    while (rnd_metric_at(count)) count++;
    c->measure = calloc(count, sizeof(*c->measure));
    c->errors = malloc((size_t)c->pair.width * (size_t)c->pair.height * sizeof(*c->errors));
    if (!c->measure || !c->errors) return ctl_fail("out of memory");
    for (size_t i = 0; (metric = rnd_metric_at(i)); i++) {
        if (!rnd_metric_fits(metric, &c->pair)) continue;
        bool first_map = metric->map && !c->mapped;
        if (first_map) c->mapped = metric;
        if (!rnd_measure(metric, &c->pair, first_map ? c->errors : NULL, &c->measure[i], error))
            return ctl_fail("%s against %s: %s", c->ctl->operand[1], c->ctl->operand[0], error);
    }
    return true;
}

static bool write_map(const struct comparison *c)
{
    size_t pixels = (size_t)c->pair.width * (size_t)c->pair.height;
    float *rgb = malloc(pixels * 3 * sizeof(*rgb));
    char error[RND_ERROR_SIZE];
    bool good;

    if (!rgb) return ctl_fail("out of memory");
    for (size_t i = 0; i < pixels; i++) ctl_colour(CTL_MAGMA, c->errors[i], &rgb[3 * i]);
    good = dmn_image_write(c->ctl->map, 0666, c->pair.width, c->pair.height, rgb, false, error) ||
           ctl_fail("%s", error);
    free(rgb);
    return good;
}

static void print_table(const struct comparison *c)
{
    const struct rnd_metric *metric;

    dmn_print(stdout, "%s against %s: %dx%d, %s\n", c->ctl->operand[1], c->ctl->operand[0], c->pair.width,
              c->pair.height,
              !c->pair.display ? "both hold light"
              : c->encoded     ? "values for a display"
                               : "light from 0 to 1, as a display shows it");
    for (size_t i = 0; (metric = rnd_metric_at(i)); i++) {
        if (!rnd_metric_fits(metric, &c->pair)) continue;
        if (metric->decimals)
            printf("%-10s %.*f", metric->label, metric->decimals, c->measure[i].value);
        else
            printf("%-10s %.6g", metric->label, c->measure[i].value);
        printf("%s%s  %s", metric->unit[0] ? " " : "", metric->unit, metric->summary);
        if (metric->needs_density) printf(", at %.4g pixels per degree", c->ctl->ppd);
        if (metric->range) printf("; %s", metric->range);
        printf("\n%s", c->measure[i].note);
    }
    if (c->ctl->map) dmn_print(stdout, "map        %s\n", c->ctl->map);
}

/* JSON has no infinity. */
static json_t *number(double value)
{
    return isfinite(value) ? json_real(value) : json_null();
}

/* Put a value into an object; with a key "a.b", as b into the object's object a. */
static void put_figure(json_t *object, const char *key, json_t *value)
{
    const char *dot = strchr(key, '.');
    char name[64];

    if (!dot) {
        json_object_set_new(object, key, value);
        return;
    }
    snprintf(name, sizeof(name), "%.*s", (int)(dot - key), key);
    if (!json_object_get(object, name)) json_object_set_new(object, name, json_object());
    json_object_set_new(json_object_get(object, name), dot + 1, value);
}

static void print_json(const struct comparison *c)
{
    json_t *object = json_pack("{s:[i,i], s:s?, s:f}", "size", c->pair.width, c->pair.height, "metric",
                               c->mapped ? c->mapped->label : NULL, "pixels_per_degree", c->ctl->ppd);
    const struct rnd_metric *metric;

    for (size_t i = 0; (metric = rnd_metric_at(i)); i++) {
        const struct rnd_measure *measure = &c->measure[i];
        json_object_set_new(object, metric->name,
                            rnd_metric_fits(metric, &c->pair) ? number(measure->value) : json_null());
        for (int k = 0; k < measure->figures; k++)
            put_figure(object, measure->figure[k].key,
                       measure->figure[k].whole ? json_integer((json_int_t)measure->figure[k].value)
                                                : number(measure->figure[k].value));
    }
    if (object) json_dumpf(object, stdout, JSON_INDENT(2) | JSON_REAL_PRECISION(9));
    if (object) putchar('\n');
    json_decref(object);
}

static int run(const struct ctl *ctl)
{
    struct comparison comparison = {.ctl = ctl};
    bool good;

    if (ctl->map && !ctl_is_picture(ctl, ctl->map)) return 2;
    good = read_both(&comparison) && measure(&comparison) && (!ctl->map || write_map(&comparison));
    if (good) (ctl->json ? print_json : print_table)(&comparison);
    free(comparison.reference);
    free(comparison.test);
    free(comparison.errors);
    free(comparison.measure);
    return good ? 0 : 1;
}

const struct ctl_command ctl_compare = {
    .name = "compare",
    .operands = "REFERENCE TEST",
    .summary = "how different two pictures are to an eye: FLIP, relative errors, PSNR",
    .options = "json ppd ldr map",
    .run = CTL_NEEDS_IMAGES(run),
};
