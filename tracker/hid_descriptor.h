/* hid_descriptor: what a HID report descriptor says about an eye tracker.
 *
 * A pure function turns the bytes of a report descriptor (HID 1.11, 6.2.2) into a table. The table says in
 * which report, and where in it, each quantity is, and what it means; hid_report decodes reports with it. The
 * parser knows usage page 0x12 "Eye and Head Trackers" (HUTRR74), with any report id, order, size, unit and
 * exponent, and ignores everything else in the descriptor. */
#ifndef FOVEAD_TRACKER_HID_DESCRIPTOR_H
#define FOVEAD_TRACKER_HID_DESCRIPTOR_H

#include "tracker.h"

enum trk_hid_type { TRK_HID_INPUT, TRK_HID_OUTPUT, TRK_HID_FEATURE, TRK_HID_TYPES };

/* X, Y and Z of the same thing are consecutive. */
enum trk_hid_quantity {
    TRK_HID_TIMESTAMP,
    TRK_HID_GAZE_X,
    TRK_HID_GAZE_Y,
    TRK_HID_LEFT_X,
    TRK_HID_LEFT_Y,
    TRK_HID_LEFT_Z,
    TRK_HID_RIGHT_X,
    TRK_HID_RIGHT_Y,
    TRK_HID_RIGHT_Z,
    TRK_HID_HEAD_X,
    TRK_HID_HEAD_Y,
    TRK_HID_HEAD_Z,
    TRK_HID_TURN_X, /* the head's rotation about X */
    TRK_HID_TURN_Y,
    TRK_HID_TURN_Z,
    TRK_HID_NEAREST, /* the smallest and largest tracking distance */
    TRK_HID_FARTHEST,
    TRK_HID_WIDTH, /* of the calibrated screen */
    TRK_HID_HEIGHT,
    TRK_HID_FREQUENCY, /* of sampling */
    TRK_HID_STATUS,    /* of the configuration: enum trk_hid_status */
    TRK_HID_MODE,      /* request of a device mode: TRK_HID_ASK_* */
    TRK_HID_QUANTITIES
};

enum trk_hid_status {
    TRK_HID_READY = 1,
    TRK_HID_CONFIGURING = 2,
    TRK_HID_NEEDS_SCREEN = 3,
    TRK_HID_NEEDS_USER = 4,
};

enum { TRK_HID_ASK_GAZE = 1, TRK_HID_ASK_EYES = 2, TRK_HID_ASK_HEAD = 4 };

struct trk_hid_field {
    enum trk_hid_quantity quantity;
    enum trk_hid_type type;
    uint8_t report;     /* id of the report; 0 if reports are not numbered */
    uint8_t bits;       /* 1 to 64, little endian */
    uint16_t first_bit; /* counted from the first byte after the report id */
    bool is_signed;
    bool has_range;    /* a value outside low..high means "not available" */
    int64_t low, high; /* logical */
    /* value = offset + scale * raw, in m, s, rad or Hz. A gaze point without a unit is a share of the screen,
     * 0 to 1; status and mode are the raw numbers. For a timestamp the ticks are kept, and scale is seconds
     * per tick. */
    double scale, offset;
    bool is_share; /* a gaze point without a unit */
};

enum { TRK_HID_MAX_FIELDS = 64, TRK_HID_MAX_DESCRIPTOR = 4096, TRK_HID_MAX_REPORT_BITS = 8 * 4096 };

struct trk_hid_layout {
    bool numbered;         /* reports begin with an id */
    bool has_unknown_turn; /* the head's rotation is left out, because its unit is not an angle */
    size_t fields;
    struct trk_hid_field field[TRK_HID_MAX_FIELDS];
    uint16_t bits[TRK_HID_TYPES][256]; /* of each report without its id; up to TRK_HID_MAX_REPORT_BITS */
};

/* Parse a descriptor of size bytes. Returns false and a line in out_error, which names the byte, if the
 * descriptor is malformed or does not describe an eye tracker that reports a gaze point. */
bool trk_hid_parse(const uint8_t *bytes, size_t size, struct trk_hid_layout *out_layout,
                   char out_error[TRK_ERROR_SIZE]);

/* The field with this quantity in reports of this type: the first if there are several, NULL if there is
 * none. */
const struct trk_hid_field *trk_hid_find(const struct trk_hid_layout *layout, enum trk_hid_type type,
                                         enum trk_hid_quantity quantity);

/* After how many bits a timestamp wraps: the declared range may be smaller than the field. */
unsigned trk_hid_clock_bits(const struct trk_hid_field *timestamp);

#endif
