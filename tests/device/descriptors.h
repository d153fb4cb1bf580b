/* Report descriptors of eye trackers: the reference descriptor of usage page 0x12, short forms of it, and
 * other legal layouts. For the tests of the parser, and as seeds of the fuzzers. */
#ifndef FOVEAD_TEST_DESCRIPTORS_H
#define FOVEAD_TEST_DESCRIPTORS_H

#include <stddef.h>
#include <stdint.h>

/* --- items, as the HID specification names them --- */

#define PAGE(n)             0x05, n
#define USAGE(n)            0x09, n
#define USAGE_2(n)          0x0a, (n)&255, (n) >> 8
#define EXTENDED(page, n)   0x0b, n, 0, page, 0
#define RANGE(low, high)    0x19, low, 0x29, high
#define OPEN(kind)          0xa1, kind
#define CLOSE               0xc0
#define ID(n)               0x85, n
#define SIZE(n)             0x75, n
#define COUNT(n)            0x95, n
#define MIN_1(n)            0x15, (n)&255
#define MIN_2(n)            0x16, (n)&255, (n) >> 8 & 255
#define MIN_4(n)            0x17, (n)&255, (n) >> 8 & 255, (n) >> 16 & 255, (n) >> 24 & 255
#define MAX_1(n)            0x25, n
#define MAX_2(n)            0x26, (n)&255, (n) >> 8 & 255
#define MAX_4(n)            0x27, (n)&255, (n) >> 8 & 255, (n) >> 16 & 255, (n) >> 24 & 255
#define PHYSICAL(low, high) 0x36, (low)&255, (low) >> 8 & 255, 0x46, (high)&255, (high) >> 8 & 255
#define UNIT_1(n)           0x65, n
#define UNIT(n)             0x66, (n)&255, (n) >> 8 & 255
#define EXPONENT(n)         0x55, (n)&15
#define INPUT               0x81, 0x02
#define PADDING             0x81, 0x03
#define FEATURE             0xb1, 0x02
#define FEATURE_CONSTANT    0xb1, 0x03
#define TRACKER             PAGE(0x12), USAGE(0x01), OPEN(1)
#define GAZE                USAGE(0x24), OPEN(2)
#define XY                  USAGE(0x21), USAGE(0x22)

#define CM     0x11
#define INCH   0x13
#define DEGREE 0x14
#define SECOND 0x1001

/* --- descriptors --- */

/* Tracking data, input report 0x10: a timestamp, then the gaze point, the eyes, the head and its rotation, in
 * 32-bit um within 2 m. */
#define THREE(usage) USAGE(usage), OPEN(0), COUNT(3), XY, USAGE(0x23), PADDING, CLOSE
#define TRACKING                                                                                             \
    USAGE(0x10), OPEN(2), ID(0x10), MIN_1(0), MAX_2(255), SIZE(8), USAGE(0x20), UNIT(SECOND), EXPONENT(-6),  \
        COUNT(8), INPUT, COUNT(1), SIZE(32), UNIT_1(CM), EXPONENT(-4), MIN_4(-2000000), MAX_4(2000000),      \
        USAGE(0x24), OPEN(0), COUNT(2), XY, PADDING, CLOSE, THREE(0x25), THREE(0x26), THREE(0x27),           \
        USAGE(0x28), OPEN(0), COUNT(3), USAGE(0x29), USAGE(0x2a), USAGE(0x2b), PADDING, CLOSE, CLOSE
/* Feature report 0x11. */
#define CAPABILITIES                                                                                         \
    USAGE(0x11), OPEN(2), ID(0x11), SIZE(8), COUNT(1), USAGE_2(0x100), MIN_1(0), MAX_1(1), UNIT_1(0),        \
        EXPONENT(0), FEATURE_CONSTANT, OPEN(0), COUNT(5), SIZE(32), MIN_4(-2000000), MAX_4(2000000),         \
        UNIT_1(CM), EXPONENT(-4), USAGE_2(0x101), USAGE_2(0x102), USAGE_2(0x103), USAGE_2(0x104),            \
        USAGE_2(0x105), FEATURE_CONSTANT, CLOSE, CLOSE
/* Feature report 0x12. */
#define CONFIGURATION                                                                                        \
    USAGE(0x12), OPEN(2), ID(0x12), SIZE(8), MIN_1(0), MAX_2(255), COUNT(1), SIZE(16), MAX_4(65535),         \
        UNIT_1(0), EXPONENT(0), USAGE_2(0x200), FEATURE_CONSTANT, USAGE_2(0x201), FEATURE_CONSTANT,          \
        SIZE(32), MAX_4(2147483647), USAGE_2(0x202), FEATURE_CONSTANT, SIZE(16), MIN_1(0), MAX_4(65535),     \
        USAGE_2(0x203), FEATURE_CONSTANT, OPEN(0), UNIT_1(CM), EXPONENT(-4), MAX_4(2147483647), SIZE(32),    \
        USAGE_2(0x204), FEATURE_CONSTANT, USAGE_2(0x205), FEATURE_CONSTANT, CLOSE, CLOSE
/* Report 0x13, feature and input: the state of the device, then its frequency in Hz. */
#define STATUS(item)                                                                                         \
    USAGE(0x13), OPEN(2), ID(0x13), SIZE(8), UNIT_1(0), EXPONENT(0), MAX_1(4), USAGE_2(0x301), item,         \
        SIZE(16), MAX_4(65535), UNIT(0xf001), EXPONENT(0), USAGE_2(0x300), item, CLOSE
/* Feature report 0x14. */
#define CONTROL                                                                                              \
    USAGE(0x14), OPEN(2), ID(0x14), SIZE(8), MAX_1(7), UNIT_1(0), EXPONENT(0), USAGE_2(0x400), FEATURE, CLOSE

/* The 366 bytes of the public virtual eye tracker by the standard's authors. Gaze is flagged as constant, the
 * timestamp is eight bytes under one usage, and a limit is carried over from the item before. */
static const uint8_t reference_descriptor[] = {TRACKER,         TRACKING,      CAPABILITIES, CONFIGURATION,
                                               STATUS(FEATURE), STATUS(INPUT), CONTROL,      CLOSE};

/* Report 18: a 31-bit microsecond counter in 32 bits, then 16-bit signed X and Y without unit or physical
 * range. */
static const uint8_t short_descriptor[] = {
    0x05, 0x12, 0x09, 0x01, 0xa1, 0x01, 0x85, 0x12, 0x09, 0x20, 0x15, 0x00, 0x27, 0xff, 0xff,
    0xff, 0x7f, 0x75, 0x20, 0x95, 0x01, 0x81, 0x02, 0x09, 0x24, 0xa1, 0x02, 0x09, 0x21, 0x09,
    0x22, 0x16, 0x01, 0x80, 0x26, 0xff, 0x7f, 0x75, 0x10, 0x95, 0x02, 0x81, 0x02, 0xc0, 0xc0,
};

#endif
