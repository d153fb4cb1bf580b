/* PSNR: kept because older results are given in it; it does not know what an eye sees. */
#include "metric/metric.h"
#include "math/srgb.h"

static bool compute(const struct rnd_pair *pair, float *out_map, struct rnd_measure *out_measure,
                    char out_error[RND_ERROR_SIZE])
{
    (void)out_map;
    (void)out_error;
    double sum = 0.0, weights = 0.0;
    for (size_t i = 0; i < (size_t)pair->width * (size_t)pair->height; i++) {
        const double weight = rnd_pair_weight(pair, i);
        for (size_t c = 3 * i; c < 3 * i + 3; c++) {
            const double difference = rnd_srgb_encode(pair->test[c]) - rnd_srgb_encode(pair->reference[c]);
            sum += weight * difference * difference;
        }
        weights += 3.0 * weight;
    }
    out_measure->value = -10.0 * log10(sum / weights);
    return true;
}

/* INFINITY if no value differs. */
const struct rnd_metric rnd_metric_psnr = {
    .name = "psnr_db",
    .label = "PSNR",
    .unit = "dB",
    .summary = "of sRGB values",
    .source = "peak signal-to-noise ratio, whose peak is 1",
    .decimals = 4,
    .higher_is_better = true,
    .values = RND_DISPLAY_VALUES,
    .compute = compute,
};
