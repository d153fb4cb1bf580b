/* The metrics, one per file. */
#ifndef FOVEAD_RENDERER_METRIC_H
#define FOVEAD_RENDERER_METRIC_H

#include "renderer.h"

/* The table of metrics, in the order in which they are shown. A new one is a file, and a row here. */
#define RND_METRICS(row) row(hdr_flip) row(ldr_flip) row(relative_mse) row(relative_rmse) row(psnr)

#define RND_METRIC_DECLARE(name) extern const struct rnd_metric rnd_metric_##name;
RND_METRICS(RND_METRIC_DECLARE)

/* How much pixel i of a pair counts. */
static inline double rnd_pair_weight(const struct rnd_pair *pair, size_t i)
{
    return pair->weight ? pair->weight[i] : 1.0;
}

/* Weighted mean of of(reference, test) over all channels of all pixels of a pair. */
double rnd_pair_mean(const struct rnd_pair *pair, double (*of)(float reference, float test));

/* Add a figure to a measure, which has room for it. */
void rnd_measure_add(struct rnd_measure *measure, const char *key, double value, bool whole);

#endif
