/* Relative RMSE: the unbiased curve of convergence, over the gaze disc or the sphere. */
#include "renderer.h"
#include "sphere.h"

double rnd_relative_rmse(const float *test, const float *reference, int width, int height,
                         const float gaze[3], float radius)
{
    double square = 0.0, light = 0.0, weights = 0.0;
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            const float v = ((float)y + 0.5f) / (float)height;
            const vec3s d = rnd_from_uv(((float)x + 0.5f) / (float)width, v);
            if (radius < (float)M_PI && rnd_angle(d, rnd_vec(gaze)) > radius) continue;
            const size_t i = 3 * ((size_t)y * width + x);
            const double weight = sin(M_PI * v), r = rnd_luminance(reference + i);
            const double difference = rnd_luminance(test + i) - r;
            square += weight * difference * difference;
            light += weight * r;
            weights += weight;
        }
    return light > 0.0 ? sqrt(square / weights) / (light / weights) : INFINITY;
}
