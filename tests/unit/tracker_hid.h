/* Report descriptors as tests write them: items, as the HID specification names them. */
#ifndef FOVEAD_TESTS_TRACKER_HID_H
#define FOVEAD_TESTS_TRACKER_HID_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "hid_report.h"

#include "../device/descriptors.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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
#define MAX_1(n)            0x25, n
#define MAX_2(n)            0x26, (n)&255, (n) >> 8 & 255
#define MAX_4(n)            0x27, (n)&255, (n) >> 8 & 255, (n) >> 16 & 255, (n) >> 24 & 255
#define PHYSICAL(low, high) 0x36, (low)&255, (low) >> 8 & 255, 0x46, (high)&255, (high) >> 8 & 255
#define UNIT(n)             0x66, (n)&255, (n) >> 8 & 255
#define EXPONENT(n)         0x55, (n)&15
#define INPUT               0x81, 0x02
#define PADDING             0x81, 0x03
#define TRACKER             PAGE(0x12), USAGE(0x01), OPEN(1)
#define GAZE                USAGE(0x24), OPEN(2)
#define XY                  USAGE(0x21), USAGE(0x22)

#define CM     0x11
#define INCH   0x13
#define DEGREE 0x14
#define SECOND 0x1001

static inline void parse(const uint8_t *bytes, size_t size, struct trk_hid_layout *out_layout)
{
    char error[TRK_ERROR_SIZE] = "";
    if (!trk_hid_parse(bytes, size, out_layout, error)) fail_msg("%s", error);
}

static inline void close_to(double value, double expected)
{
    if (!(fabs(value - expected) <= 1e-9 * fmax(1, fabs(expected))))
        fail_msg("%.12g is not %.12g", value, expected);
}

#endif
