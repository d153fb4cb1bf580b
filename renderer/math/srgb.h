/* The sRGB transfer function (IEC 61966-2-1). */
#ifndef FOVEAD_RENDERER_SRGB_H
#define FOVEAD_RENDERER_SRGB_H

#include <math.h>
#include <stdint.h>

/* Linear light to sRGB, both 0..1; clamps. */
static inline float rnd_srgb_encode(float linear)
{
    if (!(linear > 0.0f)) return 0.0f;
    if (linear >= 1.0f) return 1.0f;
    return linear <= 0.0031308f ? 12.92f * linear : 1.055f * powf(linear, 1.0f / 2.4f) - 0.055f;
}

/* sRGB to linear light, both 0..1. */
static inline float rnd_srgb_to_linear(float encoded)
{
    return encoded <= 0.04045f ? encoded / 12.92f : powf((encoded + 0.055f) / 1.055f, 2.4f);
}

/* An sRGB byte to linear light, 0..1: a table, since textures are decoded at every hit. */
extern float rnd_srgb_table[256];

static inline float rnd_srgb_decode(uint8_t byte)
{
    return rnd_srgb_table[byte];
}

/* The byte of linear light in 0..1, to its nearest but for one in the darkest: a table, for mipmaps. */
enum { RND_SRGB_STEPS = 8192 };
extern uint8_t rnd_srgb_bytes[RND_SRGB_STEPS + 1];

static inline uint8_t rnd_srgb_byte(float linear)
{
    return rnd_srgb_bytes[(int)(linear * RND_SRGB_STEPS + 0.5f)];
}

#endif
