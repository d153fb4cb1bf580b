/* rgb9e5.c: linear radiance in 4 bytes per pixel, as a GPU takes it: three mantissas of 9 bits that share
 * an exponent of 5 (EXT_texture_shared_exponent, OpenGL 2006, "Overview" and appendix). */
#include "encoding.h"

#include <endian.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MANTISSA = 9, BIAS = 15, MOST_EXPONENT = 31 };
#define LARGEST ((float)((1 << MANTISSA) - 1) / (1 << MANTISSA) * (1 << (MOST_EXPONENT - BIAS)))

static float clamped(float x)
{
    return x > 0.0f ? fminf(x, LARGEST) : 0.0f; /* NaN becomes 0 */
}

static uint32_t pack(const float rgb[3])
{
    const float r = clamped(rgb[0]), g = clamped(rgb[1]), b = clamped(rgb[2]), most = fmaxf(r, fmaxf(g, b));
    int exponent;
    frexpf(most, &exponent); /* most is below 2^exponent */
    exponent = most > 0.0f && exponent > -BIAS ? exponent + BIAS : 0;
    if (lroundf(ldexpf(most, MANTISSA + BIAS - exponent)) == 1 << MANTISSA) exponent++;
    const int shift = MANTISSA + BIAS - exponent;
    return (uint32_t)lroundf(ldexpf(r, shift)) | (uint32_t)lroundf(ldexpf(g, shift)) << 9 |
           (uint32_t)lroundf(ldexpf(b, shift)) << 18 | (uint32_t)exponent << 27;
}

static uint8_t *encode(const float *rgb, unsigned size, size_t *out_count)
{
    const size_t pixels = (size_t)size * size;
    uint32_t *words = malloc(pixels * sizeof *words);
    for (size_t i = 0; words && i < pixels; i++) words[i] = htole32(pack(&rgb[3 * i]));
    *out_count = pixels * sizeof *words;
    return (uint8_t *)words;
}

static bool decode(const uint8_t *bytes, size_t count, unsigned size, float *out_rgb)
{
    const size_t pixels = (size_t)size * size;
    if (count != pixels * sizeof(uint32_t)) return false;
    for (size_t i = 0; i < pixels; i++) {
        uint32_t word;
        memcpy(&word, bytes + i * sizeof word, sizeof word);
        word = le32toh(word);
        const int shift = (int)(word >> 27) - BIAS - MANTISSA;
        for (int c = 0; c < 3; c++) out_rgb[3 * i + (size_t)c] = ldexpf((float)(word >> 9 * c & 511), shift);
    }
    return true;
}

const struct pro_codec pro_rgb9e5 = {FOVEA__ENCODING__ENCODING_RGB9E5, encode, decode};
