/* Relative MSE: squares of the error, of which those in dark places count as much as those in bright ones. */
#include "metric/metric.h"

static const double EPSILON = 0.01; /* keeps what is nearly black from deciding alone */

static bool compute(const struct rnd_pair *pair, float *out_map, struct rnd_measure *out_measure,
                    char out_error[RND_ERROR_SIZE])
{
    (void)out_map;
    (void)out_error;
    double sum = 0.0, weights = 0.0;
    for (size_t i = 0; i < (size_t)pair->width * (size_t)pair->height; i++) {
        const double weight = rnd_pair_weight(pair, i);
        for (size_t c = 3 * i; c < 3 * i + 3; c++) {
            const double r = pair->reference[c], difference = pair->test[c] - r;
            sum += weight * difference * difference / (r * r + EPSILON);
        }
        weights += 3.0 * weight;
    }
    out_measure->value = sum / weights;
    rnd_measure_add(out_measure, "relative_mse_epsilon", EPSILON, false);
    return true;
}

const struct rnd_metric rnd_metric_relative_mse = {
    .name = "relative_mse",
    .label = "rel. MSE",
    .unit = "",
    .summary = "mean of (test - reference)^2 / (reference^2 + 0.01), linear",
    .source = "Rousselle et al. 2011",
    .compute = compute,
};
