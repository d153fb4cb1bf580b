/* The sRGB bytes as linear light: a table, since textures are decoded at every hit. */
#include "scene/srgb.h"

static float table[256];

__attribute__((constructor)) static void fill_table(void)
{
    for (int i = 0; i < 256; i++) {
        const double s = i / 255.0;
        table[i] = (float)(s <= 0.04045 ? s / 12.92 : pow((s + 0.055) / 1.055, 2.4));
    }
}

float rnd_srgb_decode(uint8_t byte)
{
    return table[byte];
}
