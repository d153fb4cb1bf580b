/* Gaze packets of the PlayStation VR2: each field at its offset, each flag by itself, both lengths, and
 * hostile bytes. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "gaze.h"
#include "psvr2_packet.h"

#include "../device/psvr2.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Parse a copy of exactly this size, so that a sanitizer notices any access beyond it. */
static bool parse(const uint8_t *bytes, size_t size, struct trk_sample *out_sample, uint32_t *out_clock)
{
    uint8_t *exact = malloc(size ? size : 1);
    assert_non_null(exact);
    if (size) memcpy(exact, bytes, size);
    memset(out_sample, 0, sizeof *out_sample);
    bool ok = trk_packet_parse(&trk_psvr2_layout, exact, size, out_sample, out_clock);
    free(exact);
    return ok;
}

static void near(const float *v, double x, double y, double z)
{
    if (fabs(v[0] - x) > 1e-6 || fabs(v[1] - y) > 1e-6 || fabs(v[2] - z) > 1e-6)
        fail_msg("%g %g %g should be %g %g %g", (double)v[0], (double)v[1], (double)v[2], x, y, z);
}

static const uint32_t all = TRK_DIRECTION | TRK_ORIGIN | 0xff0;

/* The headset's +X is to the left, its +Z forward. */
static void every_field(void **state)
{
    (void)state;
    uint8_t packet[PSVR2_PACKET];
    struct trk_sample sample;
    uint32_t clock;
    psvr2_fill(packet, 0x1fedcba98);
    assert_true(parse(packet, sizeof packet, &sample, &clock));
    assert_int_equal(sample.valid, all);
    assert_int_equal(clock, 0xfedcba98);
    near(sample.direction, 0.6, 0, -0.8);
    near(sample.origin, 0.001, 0.002, -0.003);
    near(sample.eye[0].origin, -0.032, 0.001, -0.002);
    near(sample.eye[1].origin, 0.032, 0.001, -0.002);
    near(sample.eye[0].direction, 0, 0.6, -0.8);
    near(sample.eye[1].direction, 0, -0.6, -0.8);
    assert_true(sample.eye[0].pupil_mm == 3.5f && sample.eye[1].pupil_mm == 4.5f);
    assert_true(sample.eye[0].openness == 1 && sample.eye[1].openness == 0);
}

static void every_flag_on_its_own(void **state)
{
    (void)state;
    static const struct {
        size_t flag;
        uint32_t bit;
    } flags[] = {
        {0x05c, TRK_LEFT_ORIGIN},   {0x06c, TRK_LEFT_DIRECTION}, {0x07c, TRK_LEFT_PUPIL},
        {0x09c, TRK_LEFT_OPENNESS}, {0x0a4, TRK_RIGHT_ORIGIN},   {0x0b4, TRK_RIGHT_DIRECTION},
        {0x0c4, TRK_RIGHT_PUPIL},   {0x0e4, TRK_RIGHT_OPENNESS}, {0x0ec, TRK_ORIGIN},
        {0x0fc, TRK_DIRECTION},
    };
    uint8_t packet[PSVR2_PACKET];
    struct trk_sample sample;
    uint32_t clock;
    for (size_t i = 0; i < sizeof flags / sizeof *flags; i++) {
        psvr2_fill(packet, 1);
        memset(packet + flags[i].flag, 0, 4);
        assert_true(parse(packet, sizeof packet, &sample, &clock));
        assert_int_equal(sample.valid, all & ~flags[i].bit);
        for (size_t j = 0; j < sizeof flags / sizeof *flags; j++) memset(packet + flags[j].flag, 0, 4);
        packet[flags[i].flag + 3] = 0x80; /* any bit counts */
        assert_true(parse(packet, sizeof packet, &sample, &clock));
        assert_int_equal(sample.valid, flags[i].bit);
    }
}

static void lengths(void **state)
{
    (void)state;
    static const struct {
        size_t size;
        bool ok;
    } cases[] = {{0, false}, {1, false}, {2, false}, {323, false}, {324, true}, {328, true}, {336, true}};
    uint8_t packet[400] = {0};
    struct trk_sample sample;
    uint32_t clock;
    psvr2_fill(packet, 1);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        assert_int_equal(parse(packet, cases[i].size, &sample, &clock), cases[i].ok);
    packet[1] = 'C'; /* a calibration */
    assert_false(parse(packet, 328, &sample, &clock));
}

/* A flag is set, but its field holds what no eye can do: the field is not valid. */
static void impossible_values(void **state)
{
    (void)state;
    static const float bad[] = {NAN, INFINITY, -INFINITY, 1e30f};
    uint8_t packet[PSVR2_PACKET];
    struct trk_sample sample;
    uint32_t clock;
    for (int i = 0; i < 4; i++) {
        psvr2_fill(packet, 1);
        memcpy(packet + 0x104, &bad[i], 4); /* combined direction */
        memcpy(packet + 0x0f0, &bad[i], 4); /* combined origin */
        memcpy(packet + 0x080, &bad[i], 4); /* left pupil */
        assert_true(parse(packet, sizeof packet, &sample, &clock));
        assert_int_equal(sample.valid, all & ~(uint32_t)(TRK_DIRECTION | TRK_ORIGIN | TRK_LEFT_PUPIL));
    }
    psvr2_fill(packet, 1);
    memset(packet + 0x100, 0, 12);
    assert_true(parse(packet, sizeof packet, &sample, &clock));
    assert_int_equal(sample.valid, all & ~(uint32_t)TRK_DIRECTION);
    memset(packet + 4, 0xff, sizeof packet - 4);
    assert_true(parse(packet, sizeof packet, &sample, &clock));
    assert_int_equal(sample.valid, TRK_LEFT_OPENNESS | TRK_RIGHT_OPENNESS);
}

/* When the device reports a blink, the lid is down, and the gaze that it goes on reporting is ignored. */
static void blinks(void **state)
{
    (void)state;
    uint8_t packet[PSVR2_PACKET];
    struct trk_sample sample;
    uint32_t clock;
    float head[3];
    bool known;
    psvr2_fill(packet, 1);
    assert_true(parse(packet, sizeof packet, &sample, &clock));
    assert_true(trk_gaze_direction(&sample, head, NULL)); /* the left eye is open */
    psvr2_u32(packet, 0x0a0, 1);
    assert_true(parse(packet, sizeof packet, &sample, &clock));
    assert_true((sample.valid & TRK_DIRECTION) && trk_lids_closed(&sample, &known) && known);
    assert_false(trk_gaze_direction(&sample, head, NULL));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_field), cmocka_unit_test(every_flag_on_its_own),
        cmocka_unit_test(lengths),     cmocka_unit_test(impossible_values),
        cmocka_unit_test(blinks),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
