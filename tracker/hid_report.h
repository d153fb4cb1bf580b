/* hid_report: what the HID reports of an eye tracker say. Pure functions turn the bytes of a report into
 * numbers, by the layout of its descriptor, and the numbers into a gaze sample in our frame.
 *
 * Usage page 0x12 gives a gaze point on the screen, measured from the top left corner of the calibrated area,
 * +X right and +Y down. Eye and head positions are taken to be measured from the same corner, +Z towards the
 * viewer; no public source says so. The origin of our frame is where the viewer's eyes should be: in front of
 * the middle of the screen, at its distance. */
#ifndef FOVEAD_TRACKER_HID_REPORT_H
#define FOVEAD_TRACKER_HID_REPORT_H

#include "hid_descriptor.h"

struct trk_hid_values {
    uint32_t has; /* bit of every enum trk_hid_quantity that is there and available */
    uint64_t ticks;
    double value[TRK_HID_QUANTITIES]; /* m, s, rad, Hz, a number, or a share of the screen: see the field */
    bool is_share;                    /* the gaze point */
};

/* Decode a report of size bytes, the first of them its id if layout->numbered. False if the descriptor knows
 * no such report, or it is shorter than declared. Bytes beyond are left aside. Values outside their range are
 * not available. */
bool trk_hid_decode(const struct trk_hid_layout *layout, enum trk_hid_type type, const uint8_t *bytes,
                    size_t size, struct trk_hid_values *out_values);

/* Fill in what the values tell of the gaze on a screen whose size and distance are known: valid, and the
 * fields that its bits name. All else in *out_sample is left alone. */
void trk_hid_sample(const struct trk_hid_values *values, const struct trk_screen *screen,
                    struct trk_sample *out_sample);

/* Put a value into a report, the first byte of which is its id or, unnumbered, 0; for a mode request. False
 * if value is outside the field's range, or bytes end before it. */
bool trk_hid_encode(const struct trk_hid_field *field, uint64_t value, uint8_t *bytes, size_t size);

#endif
