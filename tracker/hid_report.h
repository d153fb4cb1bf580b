/* hid_report: what the HID reports of an eye tracker say. Pure functions turn the bytes of a report into
 * numbers, by the layout of its descriptor, and the numbers into a gaze sample in our frame.
 *
 * Usage page 0x12 gives a gaze point on the screen, measured from the top left corner of the calibrated area,
 * +X right and +Y down. Eye and head positions are assumed to be measured from the same corner, with +Z
 * towards the viewer; no public source says so. The origin of our frame is where the viewer's eyes should be:
 * in front of the middle of the screen, at its distance. */
#ifndef FOVEAD_TRACKER_HID_REPORT_H
#define FOVEAD_TRACKER_HID_REPORT_H

#include "hid_descriptor.h"

struct trk_hid_values {
    uint32_t has; /* one bit per enum trk_hid_quantity: it is in the report and available */
    uint64_t ticks;
    double value[TRK_HID_QUANTITIES]; /* m, s, rad, Hz, number or share of the screen: see trk_hid_field */
    bool is_share;                    /* of the gaze point */
};

/* Decode a report of size bytes, which begins with its id if layout->numbered. Returns false if the
 * descriptor has no such report, or if the report is shorter than declared. Extra bytes are ignored. Values
 * outside their range are not available. */
bool trk_hid_decode(const struct trk_hid_layout *layout, enum trk_hid_type type, const uint8_t *bytes,
                    size_t size, struct trk_hid_values *out_values);

/* Fill in what the values say about the gaze on a screen of known size and distance: valid, and the fields
 * that its bits name. Nothing else in *out_sample is changed. */
void trk_hid_sample(const struct trk_hid_values *values, const struct trk_screen *screen,
                    struct trk_sample *out_sample);

/* Put a value into a report whose first byte is its id, or 0 if reports are not numbered. This is for a mode
 * request. Returns false if the value is outside the field's range, or the field beyond the end of bytes. */
bool trk_hid_encode(const struct trk_hid_field *field, uint64_t value, uint8_t *bytes, size_t size);

#endif
