/* The tables of sRGB bytes as linear light, and back. */
#include "math/srgb.h"

float rnd_srgb_table[256];
uint8_t rnd_srgb_bytes[RND_SRGB_STEPS + 1];

__attribute__((constructor)) static void fill_table(void)
{
    for (int i = 0; i < 256; i++) {
        const double s = i / 255.0;
        rnd_srgb_table[i] = (float)(s <= 0.04045 ? s / 12.92 : pow((s + 0.055) / 1.055, 2.4));
    }
    for (int i = 0; i <= RND_SRGB_STEPS; i++)
        rnd_srgb_bytes[i] = (uint8_t)(255.0f * rnd_srgb_encode((float)i / RND_SRGB_STEPS) + 0.5f);
}
