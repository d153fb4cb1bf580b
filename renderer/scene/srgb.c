/* The table of sRGB bytes as linear light. */
#include "scene/srgb.h"

float rnd_srgb_table[256];

__attribute__((constructor)) static void fill_table(void)
{
    for (int i = 0; i < 256; i++) {
        const double s = i / 255.0;
        rnd_srgb_table[i] = (float)(s <= 0.04045 ? s / 12.92 : pow((s + 0.055) / 1.055, 2.4));
    }
}
