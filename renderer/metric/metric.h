/* One file a metric; the table of them is in metric.c. */
#ifndef FOVEAD_RENDERER_METRIC_H
#define FOVEAD_RENDERER_METRIC_H

#include "renderer.h"

extern const struct rnd_metric rnd_metric_hdr_flip;
extern const struct rnd_metric rnd_metric_ldr_flip;
extern const struct rnd_metric rnd_metric_psnr;
extern const struct rnd_metric rnd_metric_relative_mse;
extern const struct rnd_metric rnd_metric_relative_rmse;

/* How much pixel i of a pair counts. */
static inline double rnd_pair_weight(const struct rnd_pair *pair, size_t i)
{
    return pair->weight ? pair->weight[i] : 1.0;
}

/* Mean over a pair's channels, by the weights of their pixels, of what each comes to. */
double rnd_pair_mean(const struct rnd_pair *pair, double (*of)(float reference, float test));

/* Add a figure to a measure, which has room for it. */
void rnd_measure_add(struct rnd_measure *measure, const char *key, double value, bool whole);

#endif
