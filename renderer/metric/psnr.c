/* PSNR: kept because older results are given in it; it does not know what an eye sees. */
#include "renderer.h"
#include "scene/srgb.h"

double rnd_psnr(const float *test, const float *reference, size_t count)
{
    double sum = 0.0;
    for (size_t i = 0; i < count; i++) {
        const double difference = rnd_srgb_encode(test[i]) - rnd_srgb_encode(reference[i]);
        sum += difference * difference;
    }
    return -10.0 * log10(sum / (double)count);
}
