/* Half floats (IEEE 754 binary16), where memory matters more than the last digits. */
#ifndef FOVEAD_RENDERER_HALF_H
#define FOVEAD_RENDERER_HALF_H

#include <stdint.h>
#include <string.h>

/* The nearest half float, even where two are as near. What is too large becomes the largest one, 65504; x
 * is not a NaN. */
static inline uint16_t rnd_half_encode(float x)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    const uint32_t sign = bits >> 16 & 0x8000u;
    bits &= 0x7fffffffu;
    if (bits >= 0x477ff000u) return (uint16_t)(sign | 0x7bffu);
    if (bits < 0x38800000u) { /* below 2^-14 halves are multiples of 2^-24, as floats from 1/2 to 1 are */
        const float half = (sign ? -x : x) + 0.5f;
        memcpy(&bits, &half, sizeof bits);
        return (uint16_t)(sign | (bits - 0x3f000000u));
    }
    bits += 0xfffu + (bits >> 13 & 1u);
    return (uint16_t)(sign | (bits - 0x38000000u) >> 13);
}

static inline float rnd_half_decode(uint16_t half)
{
    const uint32_t bits = (uint32_t)(half & 0x7fffu) << 13;
    float x;
    memcpy(&x, &bits, sizeof x);
    return (half & 0x8000u ? -x : x) * 0x1p112f;
}

#endif
