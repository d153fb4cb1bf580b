/* Gaze reports of a page 0x12 tracker under the reference descriptor, for the fake devices. */
#ifndef FOVEAD_TEST_HID_TRACKER_H
#define FOVEAD_TEST_HID_TRACKER_H

#include <math.h>
#include <stdint.h>

/* The size of its screen, and the radius of the circle around the screen's middle that its gaze follows, in
 * um. */
enum {
    HID_WIDTH_UM = 600000,
    HID_HEIGHT_UM = 340000,
    HID_RADIUS_UM = 100000,
    HID_STEPS = 500, /* reports per turn */
    HID_REPORT = 65,
    HID_VENDOR = 0xdeed,
    HID_PRODUCT = 0xfeed,
};

static inline void hid_put(uint8_t *out, uint64_t value, int bytes)
{
    for (int i = 0; i < bytes; i++) out[i] = (uint8_t)(value >> 8 * i);
}

/* Make report number n, stamped with clock_us. The eyes are at 65 cm; the head is unknown. */
static inline void hid_fill(uint8_t report[HID_REPORT], uint64_t n, uint64_t clock_us)
{
    double angle = 2 * M_PI * (double)(n % HID_STEPS) / HID_STEPS;
    const int32_t um[8] = {
        HID_WIDTH_UM / 2 + (int32_t)lrint(HID_RADIUS_UM * cos(angle)),
        HID_HEIGHT_UM / 2 + (int32_t)lrint(HID_RADIUS_UM * sin(angle)),
        HID_WIDTH_UM / 2 - 32000,
        HID_HEIGHT_UM / 2,
        650000,
        HID_WIDTH_UM / 2 + 32000,
        HID_HEIGHT_UM / 2,
        650000,
    };
    report[0] = 0x10;
    hid_put(report + 1, clock_us, 8);
    for (int i = 0; i < 8; i++) hid_put(report + 9 + 4 * i, (uint32_t)um[i], 4);
    for (int i = 8; i < 14; i++) hid_put(report + 9 + 4 * i, INT32_MAX, 4);
}

/* Make the status report, which is the same as input and as feature. Returns its length. */
static inline int hid_status(uint8_t *out, unsigned status, unsigned hz)
{
    out[0] = 0x13;
    out[1] = (uint8_t)status;
    hid_put(out + 2, hz, 2);
    return 4;
}

/* Make the feature report whose id is in out[0]: configuration (the size of the screen) or status. Returns
 * its length, or 0 if there is no such report. */
static inline int hid_feature(uint8_t out[19], unsigned hz)
{
    for (int i = 1; i < 19; i++) out[i] = 0;
    if (out[0] == 0x13) return hid_status(out, 1, hz);
    if (out[0] != 0x12) return 0;
    hid_put(out + 11, HID_WIDTH_UM, 4);
    hid_put(out + 15, HID_HEIGHT_UM, 4);
    return 19;
}

#endif
