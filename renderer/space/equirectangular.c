/* Directions from angles. This file needs no library, so that clients can use it without a scene. */
#include "renderer.h"

#include <math.h>

void rnd_direction(float azimuth, float elevation, float out_direction[3])
{
    const float c = cosf(elevation);
    out_direction[0] = c * sinf(azimuth);
    out_direction[1] = sinf(elevation);
    out_direction[2] = -c * cosf(azimuth);
}
