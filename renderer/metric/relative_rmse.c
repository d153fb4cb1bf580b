/* Relative RMSE: the unbiased curve of convergence. The root mean square error of the luminance, relative to
 * the reference's mean luminance; pixels count by their solid angle. */
#include "metric/metric.h"
#include "math/sphere.h"

static bool compute(const struct rnd_pair *pair, float *out_map, struct rnd_measure *out_measure,
                    char out_error[RND_ERROR_SIZE])
{
    (void)out_map;
    (void)out_error;
    double square = 0.0, light = 0.0, weights = 0.0;
    for (int y = 0; y < pair->height; y++)
        for (int x = 0; x < pair->width; x++) {
            const size_t i = (size_t)y * (size_t)pair->width + (size_t)x;
            const float v = ((float)y + 0.5f) / (float)pair->height;
            const double weight = sin(M_PI * v) * rnd_pair_weight(pair, i);
            const double r = rnd_luminance(pair->reference + 3 * i);
            const double difference = rnd_luminance(pair->test + 3 * i) - r;
            square += weight * difference * difference;
            light += weight * r;
            weights += weight;
        }
    out_measure->value = light > 0.0 ? sqrt(square / weights) / (light / weights) : INFINITY;
    return true;
}

/* INFINITY if the reference is black. */
const struct rnd_metric rnd_metric_relative_rmse = {
    .name = "relative_rmse",
    .label = "rel. RMSE",
    .unit = "",
    .summary = "of luminance, to the reference's mean, over the sphere (2:1: a panorama)",
    .source = "Koskela et al. 2018",
    .sphere = true,
    .compute = compute,
};
