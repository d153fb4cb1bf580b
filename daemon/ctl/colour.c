/* Colours for numbers: perceptually even, from dark to bright. */
#include <math.h>

#include "ctl.h"

static float to_linear(float srgb)
{
    return srgb <= 0.04045f ? srgb / 12.92f : powf((srgb + 0.055f) / 1.055f, 2.4f);
}

/* Maps by van der Walt and Smith 2015 (matplotlib), as the polynomials of M. Zucker. */
void ctl_colour(enum ctl_colours colours, float t, float out_rgb[3])
{
    static const float C[][7][3] = {
        [CTL_INFERNO] = {{0.00021894f, 0.00165100f, -0.01948090f},
                         {0.10651342f, 0.56395644f, 3.93271239f},
                         {11.6024931f, -3.97285397f, -15.9423941f},
                         {-41.7039961f, 17.4363989f, 44.3541452f},
                         {77.1629357f, -33.4023589f, -81.8073093f},
                         {-71.3194282f, 32.6260643f, 73.2095199f},
                         {25.1311262f, -12.2426690f, -23.0703250f}},
        [CTL_MAGMA] = {{-0.00213649f, -0.00074966f, -0.00538613f},
                       {0.25166054f, 0.67752324f, 2.49402660f},
                       {8.35371728f, -3.57771951f, 0.31446790f},
                       {-27.6687331f, 14.2647308f, -13.6492132f},
                       {52.1761398f, -27.9436061f, 12.9441694f},
                       {-50.7685254f, 29.0465828f, 4.23415299f},
                       {18.6557051f, -11.4897735f, -5.60196151f}},
    };

    for (int c = 0; c < 3; c++) {
        float value = 0;

        for (int i = 6; i >= 0; i--) value = value * t + C[colours][i][c];
        out_rgb[c] = to_linear(fminf(1, fmaxf(0, value)));
    }
}
