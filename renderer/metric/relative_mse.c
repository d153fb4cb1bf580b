/* Relative MSE: the squared error over the squared reference, so that dark places count as much as bright
 * ones. */
#include "metric/metric.h"

static const double EPSILON = 0.01; /* keeps nearly black pixels from deciding alone */

static double relative_square(float reference, float test)
{
    const double r = reference, difference = test - r;
    return difference * difference / (r * r + EPSILON);
}

static bool compute(const struct rnd_pair *pair, float *out_map, struct rnd_measure *out_measure,
                    char out_error[RND_ERROR_SIZE])
{
    (void)out_map;
    (void)out_error;
    out_measure->value = rnd_pair_mean(pair, relative_square);
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
