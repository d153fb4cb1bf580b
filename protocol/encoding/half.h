/* half.h: IEEE 754 half floats without a processor flag or a compiler's half type.
 *
 * After F. Giesen, "Float->half variants" and "Half to float done quick" (2012, public domain): plain integer
 * and float arithmetic that compilers turn into vector code. No operand is a subnormal float, so the result
 * does not depend on whether the thread flushes those to zero, as renderers like to.
 */
#ifndef FOVEAD_HALF_H
#define FOVEAD_HALF_H

#include <stdint.h>
#include <string.h>

#define PRO_HALF_MAX 65504.0f

static inline float float_of_bits(uint32_t bits)
{
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static inline uint32_t bits_of_float(float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

/* The nearest half, ties to even. Values beyond the range of halves become the largest ones; NaN becomes 0.
 */
static inline uint16_t half_from_float(float value)
{
    const float magic = 0.5f; /* its last bit is 2^-24, the unit of subnormal halves */
    uint32_t sign = bits_of_float(value) >> 16 & 0x8000;
    float size = float_of_bits(bits_of_float(value) & 0x7fffffff);
    size = size < PRO_HALF_MAX ? size : PRO_HALF_MAX;
    uint32_t bits = value == value ? bits_of_float(size) : 0;
    uint32_t normal = (bits - (112u << 23) + 0xfff + ((bits >> 13) & 1)) >> 13;
    uint32_t subnormal = bits_of_float(float_of_bits(bits) + magic) - bits_of_float(magic);
    return (uint16_t)(sign | (bits < (113u << 23) ? subnormal : normal));
}

/* Exponent all ones: not a finite number. */
static inline int half_is_finite(uint16_t half)
{
    return (half & 0x7c00) != 0x7c00;
}

/* The value of a finite half, exactly. */
static inline float half_to_float(uint16_t half)
{
    uint32_t bits = ((half & 0x7fffu) << 13) + (112u << 23);
    float subnormal = float_of_bits(bits + (1u << 23)) - float_of_bits(113u << 23);
    float size = (half & 0x7c00) == 0 ? subnormal : float_of_bits(bits);
    return half & 0x8000 ? -size : size;
}

#endif
