/* Shared by the tests of the report descriptor parser and of the report decoder. */
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
