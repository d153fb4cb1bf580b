/* Relative MSE: squares of the error, of which those in dark places count as much as those in bright ones. */
#include "renderer.h"

double rnd_relative_mse(const float *test, const float *reference, size_t count)
{
    double sum = 0.0;
    for (size_t i = 0; i < count; i++) {
        const double r = reference[i], difference = test[i] - r;
        sum += difference * difference / (r * r + RND_RELATIVE_MSE_EPSILON);
    }
    return sum / (double)count;
}
