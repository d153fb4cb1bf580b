/* OD: uniform in the equirectangular image, wherever the eye looks. */
#include "distribution/distribution.h"
#include "math/uv.h"

static void od_sample(const struct rnd_aim *aim, size_t count, const float *u, float *out)
{
    (void)aim;
#pragma omp simd
    for (size_t i = 0; i < count; i++) {
        const struct rnd_v3 d = rnd_v3_from_uv(u[2 * i], u[2 * i + 1]);
        out[3 * i] = d.x;
        out[3 * i + 1] = d.y;
        out[3 * i + 2] = d.z;
    }
}

static float od_density(const struct rnd_aim *aim, const float direction[3])
{
    (void)aim;
    const float c2 = direction[0] * direction[0] + direction[2] * direction[2];
    return (float)(0.5 / (M_PI * M_PI)) / fmaxf(sqrtf(c2), 1e-6f);
}

const struct rnd_distribution rnd_distribution_od = {
    .name = "od",
    .summary = "uniform in the equirectangular image",
    .source = "Koskela 2018, section 4.1: omnidirectional preview",
    .covers_sphere = true,
    .sample = od_sample,
    .density = od_density,
};
