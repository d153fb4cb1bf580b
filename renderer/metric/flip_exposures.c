/* The exposures of HDR-FLIP (Andersson et al. 2021, section 4). At the first one the brightest pixel of the
 * reference is just below white, at the last one the median pixel. */
#include "metric/flip.h"
#include "math/sphere.h"

#include <float.h>
#include <math.h>
#include <stdint.h>
#include <string.h>

/* The limit of the range, for panoramas that are half black, which no exposure shows. A sun's disc is some 20
 * stops above the shade. */
static const double MOST_STOPS = 24.0;

static float luminance_at(const float *rgb)
{
    return fminf(FLT_MAX, fmaxf(0.0f, rnd_luminance(rgb)));
}

static uint32_t bits_of(float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

/* The luminance of that rank. Floats that are not negative are ordered as their bits are: find eight bits at
 * a time. */
static float luminance_at_rank(const float *rgb, size_t count, uint64_t rank)
{
    uint32_t found = 0;
    for (int shift = 24; shift >= 0; shift -= 8) {
        uint64_t number[256] = {0};
        for (size_t i = 0; i < count; i++) {
            const uint32_t bits = bits_of(luminance_at(rgb + 3 * i));
            if ((uint64_t)bits >> (shift + 8) == found) number[bits >> shift & 255]++;
        }
        uint32_t next = 0;
        while (rank >= number[next]) rank -= number[next++];
        found = found << 8 | next;
    }
    float value;
    memcpy(&value, &found, sizeof value);
    return value;
}

struct rnd_flip_exposures rnd_flip_exposures(const float *reference, size_t count)
{
    /* Where the curve of rnd_flip_tone() reaches 0.85: the larger root. */
    const double a = 0.9036 - 0.85 * 0.8748, b = 0.018 - 0.85 * 0.354, c = -0.85 * 0.14;
    const double white = (-b + sqrt(b * b - 4.0 * a * c)) / (2.0 * a);
    float most = 0.0f;
    for (size_t i = 0; i < count; i++) most = fmaxf(most, luminance_at(reference + 3 * i));
    float median = luminance_at_rank(reference, count, count / 2);
    if (most <= 0.0f) most = median = 1.0f; /* all is black: any exposure shows that */
    struct rnd_flip_exposures out = {.start = log2(white / most)};
    out.stop = fmin(out.start + MOST_STOPS, log2(white / median));
    out.count = (int)fmax(2.0, ceil(out.stop - out.start));
    return out;
}
