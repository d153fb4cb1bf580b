/* What HDR-FLIP adds to FLIP: the exposures at which pictures are compared, and the tone curve. */
#ifndef FOVEAD_RENDERER_FLIP_H
#define FOVEAD_RENDERER_FLIP_H

#include <stddef.h>

/* One channel as a display shows it, 0 to 1 (the ACES curve by Narkowicz). The curve rises again below 0, and
 * so does the authors' program; such light comes from resampled pictures, not from a render. */
static inline float rnd_flip_tone(double light)
{
    /* Above 13 it is 1, and below -1: the bound only keeps squares finite. */
    const float c = (float)(light > 1e4 ? 1e4 : light < -1e4 ? -1e4 : light);
    const float shown = (c * (0.9036f * c + 0.018f)) / (c * (0.8748f * c + 0.354f) + 0.14f);
    return shown < 0.0f ? 0.0f : shown < 1.0f ? shown : 1.0f;
}

struct rnd_flip_exposures {
    double start, stop; /* the first and the last, stops */
    int count;          /* 2 to 24, evenly from start to stop */
};

/* The exposures for a reference of count x RGB. */
struct rnd_flip_exposures rnd_flip_exposures(const float *reference, size_t count);

#endif
