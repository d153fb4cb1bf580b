/* The one-euro filter on the sphere, and its constants. */
#include "filter.h"

#include "arc.h"

#include <string.h>

/* Cut-off at rest, and how it rises with speed. Public gaze software uses 1 Hz and 0.05 Hz per deg/s at 120
 * Hz. But 1 Hz lags 160 ms behind slow movement, so both are from the upper part of the useful ranges, 1 to 3
 * Hz and 0.02 to 0.1 Hz per deg/s. The speed itself is low-passed at 1 Hz, as in Casiez et al. 2012. */
static const double min_cutoff_hz = 2, cutoff_per_deg_s = 0.08, speed_cutoff_hz = 1;

/* The weight of a new value in a first-order low-pass (Casiez et al. 2012, equations 1 and 2). */
static double share(double cutoff_hz, double dt_s)
{
    double tau_s = 1 / (2 * M_PI * cutoff_hz);
    return 1 / (1 + tau_s / dt_s);
}

void trk_filter_step(struct trk_filter *filter, const float direction[3], double dt_s)
{
    if (filter->count++ == 0) {
        memcpy(filter->raw, direction, sizeof filter->raw);
        memcpy(filter->value, direction, sizeof filter->value);
        memset(filter->velocity_deg_s, 0, sizeof filter->velocity_deg_s);
        return;
    }
    vec3 moved, arc;
    double speed_share = share(speed_cutoff_hz, dt_s);
    trk_arc(filter->raw, direction, moved);
    for (int i = 0; i < 3; i++) {
        double velocity = moved[i] / dt_s;
        filter->velocity_deg_s[i] += (float)(speed_share * (velocity - filter->velocity_deg_s[i]));
    }
    double cutoff_hz = min_cutoff_hz + cutoff_per_deg_s * glm_vec3_norm(filter->velocity_deg_s);
    double step = fmax(share(cutoff_hz, dt_s), 1.0 / filter->count);
    trk_arc(filter->value, direction, arc);
    glm_vec3_scale(arc, (float)step, arc);
    trk_along(filter->value, arc, filter->value);
    memcpy(filter->raw, direction, sizeof filter->raw);
}

void trk_filter_reset(struct trk_filter *filter)
{
    filter->count = 0;
}
