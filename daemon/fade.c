/* How slowly a client should show a tile, so that the change is not seen as flicker. */
#include <math.h>

#include "fade.h"
#include "renderer.h"

/* A change is cut up into parts of 100 ms, half a period of 5 Hz. */
static const float STEP_MS = 100;

/* Relative standard deviation of the detail that a tile adds to the next coarser level: one octave of a
 * typical picture. */
static const float DETAIL = 0.25f;

float dmn_change(float error, uint64_t before, uint64_t now)
{
    const float known = fminf(error, 1);

    if (before == 0) return hypotf(known, DETAIL);
    return now > before ? known * sqrtf((float)((double)now / (double)before - 1)) : 0;
}

uint32_t dmn_fade_ms(float eccentricity_deg, float pixels_per_degree, float error, uint64_t before,
                     uint64_t now)
{
    float parts;

    if (rnd_acuity(eccentricity_deg) >= 1) return 0;
    parts = dmn_change(error, before, now) / rnd_visible_flicker(eccentricity_deg, pixels_per_degree);
    return parts <= 1 ? 0 : (uint32_t)fminf(STEP_MS * parts, DMN_LONGEST_FADE_MS);
}

uint32_t dmn_fade_of(const struct dmn_pyramid *pyramid, const struct dmn_tile *sent, const float gaze[3],
                     int level, int x, int y, const struct dmn_tile *now)
{
    size_t index = dmn_pyramid_index(pyramid, level, x, y);
    float eccentricity_deg = dmn_pyramid_eccentricity(pyramid, level, index, gaze) * (float)(180 / M_PI);
    bool shown = false;

    for (int l = level; l < pyramid->levels && !shown; l++)
        shown = sent[dmn_pyramid_index(pyramid, l, x >> (l - level), y >> (l - level))].samples > 0;
    /* A pixel of a coarser level is w times as wide as one of level 0. Its error is w times smaller, and so
     * is the smallest change that the eye can see in it. So the density of level 0 is right for all levels.
     */
    return shown ? dmn_fade_ms(eccentricity_deg, dmn_pyramid_density(pyramid), now->error,
                               sent[index].samples, now->samples)
                 : 0;
}
