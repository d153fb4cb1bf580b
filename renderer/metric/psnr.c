/* PSNR, for comparison with older results. It knows nothing of what an eye sees. */
#include "metric/metric.h"
#include "math/srgb.h"

static double square(float reference, float test)
{
    const double difference = rnd_srgb_encode(test) - rnd_srgb_encode(reference);
    return difference * difference;
}

static bool compute(const struct rnd_pair *pair, float *out_map, struct rnd_measure *out_measure,
                    char out_error[RND_ERROR_SIZE])
{
    (void)out_map;
    (void)out_error;
    out_measure->value = -10.0 * log10(rnd_pair_mean(pair, square));
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
