/* The parser of report descriptors and the decoder of reports: the reference descriptor, other legal layouts,
 * and hostile bytes. */
#include "tracker_hid.h"

struct layout {
    const char *name;
    uint8_t descriptor[160];
    size_t descriptor_size;
    uint8_t report[40];
    size_t report_size;
    bool is_share;
    double x, y; /* m or share */
    uint64_t ticks;
    unsigned clock_bits; /* 0: no clock */
    double tick_ns;
};

#define BYTES(...) {__VA_ARGS__}, sizeof((uint8_t[]){__VA_ARGS__})

static const struct layout layouts[] = {
    {"no report ids, shares of the screen, a 32-bit clock",
     BYTES(TRACKER, USAGE(0x20), MIN_1(0), SIZE(32), COUNT(1), INPUT, GAZE, XY, MAX_4(65535), SIZE(16),
           COUNT(2), INPUT, CLOSE, CLOSE),
     BYTES(1, 2, 3, 4, 0xff, 0xff, 0, 0), true, 1, 0, 0x04030201, 32, 1000},
    {"Y before X, twelve bits each, after five bits of padding",
     BYTES(TRACKER, ID(7), SIZE(5), COUNT(1), PADDING, GAZE, USAGE(0x22), USAGE(0x21), MIN_1(0), MAX_2(4095),
           SIZE(12), COUNT(2), INPUT, CLOSE, CLOSE),
     BYTES(7, 0xff, 0xff, 0x01, 0x00), true, 0, 1, 0, 0, 0},
    {"inches, thousandths",
     BYTES(TRACKER, ID(1), GAZE, XY, UNIT(INCH), EXPONENT(-3), MIN_2(-20000), MAX_2(20000), SIZE(16),
           COUNT(2), INPUT, CLOSE, CLOSE),
     BYTES(1, 0xe8, 0x03, 0x18, 0xfc), false, 0.0254, -0.0254, 0, 0, 0},
    {"a physical range in millimetres",
     BYTES(TRACKER, ID(1), GAZE, XY, UNIT(CM), EXPONENT(-1), PHYSICAL(-100, 300), MIN_1(0), MAX_2(4000),
           SIZE(16), COUNT(2), INPUT, CLOSE, CLOSE),
     BYTES(1, 0, 0, 0xd0, 0x07), false, -0.1, 0.1, 0, 0, 0},
    {"a range of usages",
     BYTES(TRACKER, ID(1), GAZE, RANGE(0x21, 0x22), MIN_1(0), MAX_1(100), SIZE(8), COUNT(2), INPUT, CLOSE,
           CLOSE),
     BYTES(1, 25, 50), true, 0.25, 0.5, 0, 0, 0},
    {"a range of usages whose beginning is unknown",
     BYTES(TRACKER, ID(1), GAZE, RANGE(0x1f, 0x22), MIN_1(0), MAX_1(100), SIZE(8), COUNT(4), INPUT, CLOSE,
           CLOSE),
     BYTES(1, 90, 91, 25, 50), true, 0.25, 0.5, 91, 8, 1000},
    {"usages of four bytes under another page",
     BYTES(PAGE(1), EXTENDED(0x12, 0x01), OPEN(1), ID(1), EXTENDED(0x12, 0x24), OPEN(2), EXTENDED(0x12, 0x21),
           EXTENDED(0x12, 0x22), MIN_1(0), MAX_1(100), SIZE(8), COUNT(2), INPUT, CLOSE, CLOSE),
     BYTES(1, 75, 100), true, 0.75, 1, 0, 0, 0},
    {"pushed and popped",
     BYTES(TRACKER, ID(1), UNIT(CM), EXPONENT(-4), MIN_2(0), MAX_4(1000000), SIZE(32), 0xa4, UNIT(SECOND),
           EXPONENT(-3), MAX_2(255), SIZE(8), COUNT(3), USAGE(0x20), INPUT, 0xb4, COUNT(2), GAZE, XY, INPUT,
           CLOSE, CLOSE),
     BYTES(1, 1, 0, 1, 0x40, 0x42, 0x0f, 0, 0x20, 0xa1, 0x07, 0), false, 1, 0.5, 0x10001, 24, 1e6},
    {"nanoseconds in two halves, the clock last",
     BYTES(TRACKER, ID(1), GAZE, XY, MIN_1(0), MAX_1(100), SIZE(8), COUNT(2), INPUT, CLOSE, UNIT(SECOND),
           0x55, 0xf7, SIZE(32), USAGE(0x20), INPUT, CLOSE),
     BYTES(1, 10, 20, 1, 0, 0, 0, 2, 0, 0, 0), true, 0.1, 0.2, 0x200000001, 64, 1},
    {"a mouse before it in the same device",
     BYTES(PAGE(1), USAGE(2), OPEN(1), ID(1), USAGE(0x30), USAGE(0x31), MIN_1(-127), MAX_1(127), SIZE(8),
           COUNT(2), 0x81, 6, CLOSE, TRACKER, ID(2), GAZE, XY, MIN_1(0), MAX_1(200), INPUT, CLOSE, CLOSE),
     BYTES(2, 100, 50), true, 0.5, 0.25, 0, 0, 0},
    {"alternative usages between delimiters",
     BYTES(TRACKER, ID(1), GAZE, 0xa9, 1, USAGE(0x21), USAGE(0x23), 0xa9, 0, USAGE(0x22), MIN_1(0),
           MAX_1(100), SIZE(8), COUNT(2), INPUT, CLOSE, CLOSE),
     BYTES(1, 30, 60), true, 0.3, 0.6, 0, 0, 0},
    {"25 ff after 15 00 is 255",
     BYTES(TRACKER, ID(1), GAZE, XY, MIN_1(0), MAX_1(0xff), SIZE(8), COUNT(2), INPUT, CLOSE, CLOSE),
     BYTES(1, 0xff, 51), true, 1, 0.2, 0, 0, 0},
    {"the maximum before the minimum",
     BYTES(TRACKER, ID(1), GAZE, XY, MAX_1(100), MIN_1(-100), SIZE(8), COUNT(2), INPUT, CLOSE, CLOSE),
     BYTES(1, 156, 0), true, 0, 0.5, 0, 0, 0},
    {"a long item, and a collection without a usage around X and Y",
     BYTES(TRACKER, ID(1), 0xfe, 3, 0xf0, 1, 2, 3, GAZE, OPEN(0), XY, MIN_1(0), MAX_1(100), SIZE(8), COUNT(2),
           INPUT, CLOSE, CLOSE, CLOSE),
     BYTES(1, 40, 80), true, 0.4, 0.8, 0, 0, 0},
    {"24 bits, with a status before it in the report",
     BYTES(TRACKER, ID(200), USAGE_2(0x301), MIN_1(0), MAX_1(4), SIZE(8), COUNT(1), INPUT, GAZE, XY, UNIT(CM),
           EXPONENT(-4), MAX_4(2000000), SIZE(24), COUNT(2), INPUT, CLOSE, CLOSE),
     BYTES(200, 1, 0x40, 0x42, 0x0f, 0x20, 0xa1, 0x07), false, 1, 0.5, 0, 0, 0},
    {"one item for each number",
     BYTES(TRACKER, ID(1), GAZE, MIN_1(0), MAX_1(100), SIZE(8), COUNT(1), USAGE(0x21), INPUT, USAGE(0x99),
           INPUT, USAGE(0x22), INPUT, CLOSE, CLOSE),
     BYTES(1, 11, 99, 22), true, 0.11, 0.22, 0, 0, 0},
    {"a unit left over from the clock is no unit of length",
     BYTES(TRACKER, ID(1), UNIT(SECOND), EXPONENT(-6), MIN_1(0), MAX_2(10000), SIZE(16), COUNT(1),
           USAGE(0x20), INPUT, GAZE, XY, COUNT(2), INPUT, CLOSE, CLOSE),
     BYTES(1, 5, 0, 0x88, 0x13, 0x10, 0x27), true, 0.5, 1, 5, 16, 1000},
};

static void put_i32(uint8_t *out, int32_t value)
{
    for (int i = 0; i < 4; i++) out[i] = (uint8_t)((uint32_t)value >> 8 * i);
}

static void reference_is_understood(void **state)
{
    (void)state;
    static const struct {
        enum trk_hid_type type;
        enum trk_hid_quantity quantity;
        uint8_t report, bits;
        uint16_t first_bit;
        double scale;
    } fields[] = {
        {TRK_HID_INPUT, TRK_HID_TIMESTAMP, 0x10, 64, 0, 1e-6},
        {TRK_HID_INPUT, TRK_HID_GAZE_X, 0x10, 32, 64, 1e-6},
        {TRK_HID_INPUT, TRK_HID_GAZE_Y, 0x10, 32, 96, 1e-6},
        {TRK_HID_INPUT, TRK_HID_LEFT_X, 0x10, 32, 128, 1e-6},
        {TRK_HID_INPUT, TRK_HID_LEFT_Y, 0x10, 32, 160, 1e-6},
        {TRK_HID_INPUT, TRK_HID_LEFT_Z, 0x10, 32, 192, 1e-6},
        {TRK_HID_INPUT, TRK_HID_RIGHT_X, 0x10, 32, 224, 1e-6},
        {TRK_HID_INPUT, TRK_HID_RIGHT_Z, 0x10, 32, 288, 1e-6},
        {TRK_HID_INPUT, TRK_HID_HEAD_X, 0x10, 32, 320, 1e-6},
        {TRK_HID_INPUT, TRK_HID_HEAD_Z, 0x10, 32, 384, 1e-6},
        {TRK_HID_FEATURE, TRK_HID_NEAREST, 0x11, 32, 8, 1e-6},
        {TRK_HID_FEATURE, TRK_HID_FARTHEST, 0x11, 32, 72, 1e-6},
        {TRK_HID_FEATURE, TRK_HID_WIDTH, 0x12, 32, 80, 1e-6},
        {TRK_HID_FEATURE, TRK_HID_HEIGHT, 0x12, 32, 112, 1e-6},
        {TRK_HID_FEATURE, TRK_HID_STATUS, 0x13, 8, 0, 1},
        {TRK_HID_FEATURE, TRK_HID_FREQUENCY, 0x13, 16, 8, 1},
        {TRK_HID_INPUT, TRK_HID_STATUS, 0x13, 8, 0, 1},
        {TRK_HID_INPUT, TRK_HID_FREQUENCY, 0x13, 16, 8, 1},
        {TRK_HID_FEATURE, TRK_HID_MODE, 0x14, 8, 0, 1},
    };
    struct trk_hid_layout layout;
    assert_int_equal(sizeof reference_descriptor, 366);
    parse(reference_descriptor, sizeof reference_descriptor, &layout);
    assert_true(layout.numbered);
    for (size_t i = 0; i < sizeof fields / sizeof *fields; i++) {
        const struct trk_hid_field *field = trk_hid_find(&layout, fields[i].type, fields[i].quantity);
        assert_non_null(field);
        assert_int_equal(field->report, fields[i].report);
        assert_int_equal(field->bits, fields[i].bits);
        assert_int_equal(field->first_bit, fields[i].first_bit);
        close_to(field->scale, fields[i].scale);
    }
    assert_int_equal(layout.bits[TRK_HID_INPUT][0x10], 64 * 8);
    assert_int_equal(layout.bits[TRK_HID_FEATURE][0x11], 21 * 8);
    assert_int_equal(layout.bits[TRK_HID_FEATURE][0x12], 18 * 8);
    /* The reference descriptor states the head's rotation in centimetres, which cannot be turned into an
     * angle. */
    assert_null(trk_hid_find(&layout, TRK_HID_INPUT, TRK_HID_TURN_X));
    assert_true(layout.has_unknown_turn);
    assert_int_equal(trk_hid_clock_bits(trk_hid_find(&layout, TRK_HID_INPUT, TRK_HID_TIMESTAMP)), 64);
}

static void reference_report_is_decoded(void **state)
{
    (void)state;
    struct trk_hid_layout layout;
    struct trk_hid_values values;
    uint8_t report[65] = {0x10, 8, 7, 6, 5, 4, 3, 2, 1};
    parse(reference_descriptor, sizeof reference_descriptor, &layout);
    static const int32_t um[14] = {265500, 149500,    235500,    149500,    650000,    295500,    149500,
                                   650000, INT32_MAX, INT32_MAX, INT32_MAX, INT32_MAX, INT32_MAX, INT32_MAX};
    for (int i = 0; i < 14; i++) put_i32(report + 9 + 4 * i, um[i]);
    assert_true(trk_hid_decode(&layout, TRK_HID_INPUT, report, sizeof report, &values));
    assert_int_equal(values.ticks, 0x0102030405060708);
    close_to(values.value[TRK_HID_GAZE_X], 0.2655);
    close_to(values.value[TRK_HID_LEFT_Z], 0.65);
    assert_false(values.has >> TRK_HID_HEAD_X & 1); /* out of range: not available */
    assert_false(values.is_share);

    /* A longer report is decoded; a shorter one, or one with an unknown id, is not. */
    assert_false(trk_hid_decode(&layout, TRK_HID_INPUT, report, 64, &values));
    assert_false(trk_hid_decode(&layout, TRK_HID_INPUT, report, 0, &values));
    report[0] = 0x77;
    assert_false(trk_hid_decode(&layout, TRK_HID_INPUT, report, sizeof report, &values));

    /* An input report and a feature report may have the same id and differ. */
    static const uint8_t status[] = {0x13, 4, 0xf4, 0x01};
    for (int type = TRK_HID_INPUT; type <= TRK_HID_FEATURE; type += 2) {
        assert_true(trk_hid_decode(&layout, type, status, sizeof status, &values));
        close_to(values.value[TRK_HID_STATUS], TRK_HID_NEEDS_USER);
        close_to(values.value[TRK_HID_FREQUENCY], 500);
        assert_false(values.has >> TRK_HID_GAZE_X & 1);
    }
}

static void short_form(void **state)
{
    (void)state;
    struct trk_hid_layout layout;
    struct trk_hid_values values;
    parse(short_descriptor, sizeof short_descriptor, &layout);
    static const uint8_t report[] = {18, 0xff, 0xff, 0xff, 0x7f, 0x01, 0x80, 0xff, 0x7f};
    assert_true(trk_hid_decode(&layout, TRK_HID_INPUT, report, sizeof report, &values));
    assert_int_equal(values.ticks, 0x7fffffff);
    assert_int_equal(trk_hid_clock_bits(trk_hid_find(&layout, TRK_HID_INPUT, TRK_HID_TIMESTAMP)), 31);
    assert_true(values.is_share);
    close_to(values.value[TRK_HID_GAZE_X], 0);
    close_to(values.value[TRK_HID_GAZE_Y], 1);
}

static void other_layouts(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof layouts / sizeof *layouts; i++) {
        const struct layout *expected = &layouts[i];
        struct trk_hid_layout layout;
        struct trk_hid_values values;
        char error[TRK_ERROR_SIZE] = "";
        if (!trk_hid_parse(expected->descriptor, expected->descriptor_size, &layout, error))
            fail_msg("%s: %s", expected->name, error);
        if (!trk_hid_decode(&layout, TRK_HID_INPUT, expected->report, expected->report_size, &values) ||
            trk_hid_decode(&layout, TRK_HID_INPUT, expected->report, expected->report_size - 1, &values))
            fail_msg("%s: the report is not of %zu bytes", expected->name, expected->report_size);
        trk_hid_decode(&layout, TRK_HID_INPUT, expected->report, expected->report_size, &values);
        double x = values.value[TRK_HID_GAZE_X], y = values.value[TRK_HID_GAZE_Y];
        const struct trk_hid_field *clock = trk_hid_find(&layout, TRK_HID_INPUT, TRK_HID_TIMESTAMP);
        if (!(values.has >> TRK_HID_GAZE_X & 1) || !(values.has >> TRK_HID_GAZE_Y & 1) ||
            values.is_share != expected->is_share || fabs(x - expected->x) > 1e-9 ||
            fabs(y - expected->y) > 1e-9)
            fail_msg("%s: gaze point %g %g%s", expected->name, x, y,
                     values.is_share ? " of the screen" : " m");
        if (values.ticks != expected->ticks ||
            (clock ? trk_hid_clock_bits(clock) : 0) != expected->clock_bits ||
            (clock && fabs(clock->scale * 1e9 - expected->tick_ns) > 1e-3))
            fail_msg("%s: clock %llu", expected->name, (unsigned long long)values.ticks);
    }
}

/* --- bytes that are not a descriptor --- */

static void refused(const char *name, const uint8_t *bytes, size_t size, const char *why)
{
    struct trk_hid_layout layout;
    char error[TRK_ERROR_SIZE] = "";
    uint8_t *exact = malloc(size ? size : 1);
    assert_non_null(exact);
    if (size) memcpy(exact, bytes, size);
    if (trk_hid_parse(exact, size, &layout, error) || !strstr(error, why))
        fail_msg("%s: '%s' should say '%s'", name, error, why);
    free(exact);
}

#define REFUSED(why, ...)                                                                                    \
    refused(#__VA_ARGS__, (const uint8_t[]){__VA_ARGS__}, sizeof((uint8_t[]){__VA_ARGS__}), why)

static void hostile_bytes(void **state)
{
    (void)state;
    uint8_t many[TRK_HID_MAX_DESCRIPTOR + 1] = {0};
    refused("nothing", many, 0, "no eye tracker");
    memset(many, 0xc0, sizeof many);
    refused("4097 bytes", many, sizeof many, "expected up to 4096");
    REFUSED("byte 0: the end of a collection", CLOSE);
    REFUSED("end within a collection", TRACKER);
    REFUSED("no gaze point", TRACKER, CLOSE);
    REFUSED("no eye tracker", PAGE(1), USAGE(2), OPEN(1), CLOSE);
    REFUSED("no eye tracker", PAGE(0x12), USAGE(2), OPEN(1), CLOSE);
    REFUSED("byte 2: a report id", PAGE(1), ID(0));
    REFUSED("report id", 0x86, 0, 1);
    REFUSED("pop without a push", 0xb4);
    REFUSED("cut short", 0x27, 1, 2, 3);
    REFUSED("cut short", 0xfe);
    REFUSED("cut short", 0xfe, 2, 0, 0);
    REFUSED("4096 bytes", 0x77, 0xff, 0xff, 0xff, 0xff, 0x97, 0xff, 0xff, 0xff, 0xff, INPUT);
    REFUSED("4096 bytes", SIZE(1), 0x97, 0x01, 0x80, 0, 0, INPUT);
    REFUSED("4096 bytes", SIZE(1), 0x97, 0x00, 0x80, 0, 0, INPUT, COUNT(1), INPUT);
    /* The gaze point is wider than 64 bits, lacks a range, lacks Y, is a feature, or is only padding. */
    REFUSED("no gaze point", TRACKER, GAZE, XY, MIN_1(0), MAX_1(1), SIZE(65), COUNT(2), INPUT, CLOSE, CLOSE);
    REFUSED("no gaze point", TRACKER, GAZE, XY, SIZE(8), COUNT(2), INPUT, CLOSE, CLOSE);
    REFUSED("no gaze point", TRACKER, GAZE, XY, MIN_1(0), MAX_1(9), SIZE(8), COUNT(1), INPUT, CLOSE, CLOSE);
    REFUSED("no gaze point", TRACKER, GAZE, XY, MIN_1(0), MAX_1(9), SIZE(8), COUNT(2), 0xb1, 2, CLOSE, CLOSE);
    REFUSED("no gaze point", TRACKER, GAZE, XY, MIN_1(0), MAX_1(9), SIZE(8), COUNT(2), 0x81, 0, CLOSE, CLOSE);
    for (size_t i = 0; i < sizeof many; i += 2) many[i] = 0xa1;
    refused("33 collections", many, 200, "32 collections");
    memset(many, 0xa4, sizeof many);
    refused("17 pushes", many, 200, "16 pushes");
}

/* A good descriptor that is cut at any byte, or changed in any byte, is either parsed or refused with one
 * line. */
static void every_beginning_and_every_byte(void **state)
{
    (void)state;
    char error[TRK_ERROR_SIZE];
    struct trk_hid_layout layout;
    struct trk_hid_values values;
    const size_t size = sizeof reference_descriptor;
    for (size_t length = 0; length < size; length++)
        refused("a beginning", reference_descriptor, length, length ? "report descriptor" : "no eye tracker");
    uint8_t *copy = malloc(size), report[64] = {0};
    assert_non_null(copy);
    memcpy(copy, reference_descriptor, size);
    int understood = 0;
    for (size_t at = 0; at < size; at++) {
        for (int value = 0; value < 256; value++) {
            copy[at] = (uint8_t)value;
            bool ok = trk_hid_parse(copy, size, &layout, error);
            assert_true(ok == (*error == '\0'));
            for (report[0] = 0x10; ok && report[0] <= 0x14; report[0]++)
                trk_hid_decode(&layout, TRK_HID_INPUT, report, sizeof report, &values);
            understood += ok;
        }
        copy[at] = reference_descriptor[at];
    }
    assert_true(understood > 10000); /* most changes are harmless */
    free(copy);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(reference_is_understood),
        cmocka_unit_test(reference_report_is_decoded),
        cmocka_unit_test(short_form),
        cmocka_unit_test(other_layouts),
        cmocka_unit_test(hostile_bytes),
        cmocka_unit_test(every_beginning_and_every_byte),
    };
    return cmocka_run_group_tests_name("tracker_hid_descriptor", tests, NULL, NULL);
}
