/* The metrics by name, and the checks before one is computed. */
#include "metric/metric.h"
#include "math/sphere.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

#define ROW(name) &rnd_metric_##name,
static const struct rnd_metric *const table[] = {RND_METRICS(ROW)};

const struct rnd_metric *rnd_metric_at(size_t index)
{
    return index < sizeof table / sizeof *table ? table[index] : NULL;
}

const struct rnd_metric *rnd_metric_find(const char *name)
{
    for (size_t i = 0; i < sizeof table / sizeof *table; i++)
        if (strcmp(table[i]->name, name) == 0) return table[i];
    return NULL;
}

/* What the metric needs and the pair lacks, as text; NULL: nothing. */
static const char *missing(const struct rnd_metric *metric, const struct rnd_pair *pair)
{
    if (metric->sequence && !pair->next) return "sequences of frames";
    if (!metric->sequence && pair->next) return "single pictures";
    if (metric->sphere && !pair->panorama) return "panoramas";
    if (metric->values == RND_RADIANCE && pair->display) return "radiance";
    if (metric->values == RND_DISPLAY_VALUES && !pair->display) return "values for a display";
    if (metric->needs_density && pair->pixels_per_degree == 0.0f) return "pixels per degree";
    if (metric->needs_gaze && !pair->gaze) return "a gaze";
    return NULL;
}

bool rnd_metric_fits(const struct rnd_metric *metric, const struct rnd_pair *pair)
{
    return !missing(metric, pair);
}

static bool is_finite(const float *rgb, int width, int height, const char *name,
                      char out_error[RND_ERROR_SIZE])
{
    const size_t count = 3 * (size_t)width * (size_t)height;
    for (size_t i = 0; i < count; i++)
        if (!isfinite(rgb[i])) {
            snprintf(out_error, RND_ERROR_SIZE, "a pixel of the %s is not finite, at %zu,%zu", name,
                     i / 3 % (size_t)width, i / 3 / (size_t)width);
            return false;
        }
    return true;
}

static bool weighs(const struct rnd_pair *pair, char out_error[RND_ERROR_SIZE])
{
    double sum = 0.0;
    for (size_t i = 0; i < (size_t)pair->width * (size_t)pair->height; i++) {
        const double weight = rnd_pair_weight(pair, i);
        if (!(weight >= 0.0 && isfinite(weight))) {
            snprintf(out_error, RND_ERROR_SIZE, "the weight %g, at %zu,%zu, is not a number from 0 on",
                     weight, i % (size_t)pair->width, i / (size_t)pair->width);
            return false;
        }
        sum += weight;
    }
    if (sum > 0.0) return true;
    snprintf(out_error, RND_ERROR_SIZE, "no pixel has any weight");
    return false;
}

bool rnd_measure(const struct rnd_metric *metric, const struct rnd_pair *pair, float *out_map,
                 struct rnd_measure *out_measure, char out_error[RND_ERROR_SIZE])
{
    const char *need = missing(metric, pair);
    if (need) {
        snprintf(out_error, RND_ERROR_SIZE, "%s needs %s", metric->label, need);
        return false;
    }
    if (pair->width < 1 || pair->height < 1 || pair->width > RND_METRIC_MAX_SIDE ||
        pair->height > RND_METRIC_MAX_SIDE) {
        snprintf(out_error, RND_ERROR_SIZE, "a picture of %dx%d is not compared: sides go from 1 to %d",
                 pair->width, pair->height, RND_METRIC_MAX_SIDE);
        return false;
    }
    if (!is_finite(pair->reference, pair->width, pair->height, "reference", out_error) ||
        !is_finite(pair->test, pair->width, pair->height, "test", out_error) || !weighs(pair, out_error))
        return false;
    *out_measure = (struct rnd_measure){0};
    return metric->compute(pair, out_map, out_measure, out_error);
}

double rnd_pair_mean(const struct rnd_pair *pair, double (*of)(float reference, float test))
{
    double sum = 0.0, weights = 0.0;
    for (size_t i = 0; i < (size_t)pair->width * (size_t)pair->height; i++) {
        const double weight = rnd_pair_weight(pair, i);
        for (size_t c = 3 * i; c < 3 * i + 3; c++) sum += weight * of(pair->reference[c], pair->test[c]);
        weights += 3.0 * weight;
    }
    return sum / weights;
}

void rnd_measure_add(struct rnd_measure *measure, const char *key, double value, bool whole)
{
    const int i = measure->figures++;
    assert(i < RND_METRIC_FIGURES);
    measure->figure[i].key = key;
    measure->figure[i].value = value;
    measure->figure[i].whole = whole;
}

void rnd_weigh_ring(int width, int height, const float gaze[3], float inner, float outer, float *out_weight)
{
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            const vec3s d = rnd_from_uv(((float)x + 0.5f) / (float)width, ((float)y + 0.5f) / (float)height);
            const float angle = rnd_angle(d, rnd_vec(gaze));
            *out_weight++ = angle >= inner && angle <= outer ? 1.0f : 0.0f;
        }
}
