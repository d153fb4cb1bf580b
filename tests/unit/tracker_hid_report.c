/* HID reports of eye trackers: requests to them, and gaze rays from gaze points, eyes and heads. */
#include "tracker_hid.h"

static void mode_is_encoded_in_its_range(void **state)
{
    (void)state;
    struct trk_hid_layout layout;
    uint8_t report[2] = {0};
    parse(reference_descriptor, sizeof reference_descriptor, &layout);
    const struct trk_hid_field *mode = trk_hid_find(&layout, TRK_HID_FEATURE, TRK_HID_MODE);
    assert_true(trk_hid_encode(mode, 7, report, sizeof report));
    assert_int_equal(report[0], 0x14);
    assert_int_equal(report[1], 7);
    assert_false(trk_hid_encode(mode, 8, report, sizeof report));
    assert_false(trk_hid_encode(mode, 7, report, 1));
}

static void near(const float *v, double x, double y, double z)
{
    if (fabs(v[0] - x) > 1e-5 || fabs(v[1] - y) > 1e-5 || fabs(v[2] - z) > 1e-5)
        fail_msg("%g %g %g should be %g %g %g", (double)v[0], (double)v[1], (double)v[2], x, y, z);
}

/* A screen of 0.6 x 0.4 m at a distance of 0.8 m: its top right corner is 0.3 m to the right and 0.2 m up. */
static const struct trk_screen screen = {0.6f, 0.4f, 0.8f};

static struct trk_hid_values gaze_at(double x, double y)
{
    struct trk_hid_values values = {.has = 3u << TRK_HID_GAZE_X};
    values.value[TRK_HID_GAZE_X] = x;
    values.value[TRK_HID_GAZE_Y] = y;
    return values;
}

static void set_point(struct trk_hid_values *values, enum trk_hid_quantity first, double x, double y,
                      double z)
{
    values->has |= 7u << first;
    values->value[first] = x;
    values->value[first + 1] = y;
    values->value[first + 2] = z;
}

static void points_become_rays(void **state)
{
    (void)state;
    struct trk_sample sample = {0};
    struct trk_hid_values values = gaze_at(0.3, 0.2);
    trk_hid_sample(&values, &screen, &sample);
    assert_int_equal(sample.valid, TRK_DIRECTION | TRK_SCREEN);
    near(sample.direction, 0, 0, -1);

    values = gaze_at(0.6, 0);
    double length = sqrt(0.3 * 0.3 + 0.2 * 0.2 + 0.8 * 0.8);
    trk_hid_sample(&values, &screen, &sample);
    near(sample.direction, 0.3 / length, 0.2 / length, -0.8 / length); /* right and up */
    assert_true(fabsf(sample.screen[0] - 1) < 1e-6f && sample.screen[1] == 0);

    /* The same as shares. */
    values = gaze_at(1, 0);
    values.is_share = true;
    trk_hid_sample(&values, &screen, &sample);
    near(sample.direction, 0.3 / length, 0.2 / length, -0.8 / length);

    /* A gaze point needs both coordinates. */
    values.has = 1u << TRK_HID_GAZE_X;
    trk_hid_sample(&values, &screen, &sample);
    assert_int_equal(sample.valid, 0);
}

static void eyes_are_where_rays_begin(void **state)
{
    (void)state;
    struct trk_sample sample = {0};
    struct trk_hid_values values = gaze_at(0.3, 0.2);
    set_point(&values, TRK_HID_LEFT_X, 0.27, 0.2, 0.4);
    set_point(&values, TRK_HID_RIGHT_X, 0.33, 0.2, 0.4);
    trk_hid_sample(&values, &screen, &sample);
    assert_int_equal(sample.valid, TRK_DIRECTION | TRK_SCREEN | TRK_ORIGIN | TRK_LEFT_DIRECTION |
                                       TRK_LEFT_ORIGIN | TRK_RIGHT_DIRECTION | TRK_RIGHT_ORIGIN);
    near(sample.origin, 0, 0, -0.4);
    near(sample.direction, 0, 0, -1);
    double length = sqrt(0.03 * 0.03 + 0.4 * 0.4);
    near(sample.eye[0].origin, -0.03, 0, -0.4);
    near(sample.eye[0].direction, 0.03 / length, 0, -0.4 / length); /* the left eye looks to the right */
    near(sample.eye[1].direction, -0.03 / length, 0, -0.4 / length);

    /* An eye whose position is unknown is left out. */
    set_point(&values, TRK_HID_LEFT_X, 0, 0, 0);
    trk_hid_sample(&values, &screen, &sample);
    assert_false(sample.valid & (TRK_LEFT_ORIGIN | TRK_LEFT_DIRECTION));
    near(sample.origin, 0.03, 0, -0.4);
}

/* A head that is turned to its left by 90 degrees, and whose eyes look at the screen: they look to the head's
 * right. */
static void head_pose_takes_rays_along(void **state)
{
    (void)state;
    struct trk_sample sample = {0};
    struct trk_hid_values values = gaze_at(0.3, 0.2);
    float world[3];
    set_point(&values, TRK_HID_HEAD_X, 0.3, 0.1, 0.8);
    set_point(&values, TRK_HID_TURN_X, 0, M_PI / 2, 0);
    trk_hid_sample(&values, &screen, &sample);
    assert_true(sample.valid & TRK_HEAD);
    near(sample.head, 0, 0.1, 0);
    near(sample.direction, 1, 0, 0);
    assert_true(trk_world_direction(&sample, world));
    near(world, 0, 0, -1);
    /* Reversing Y also reverses rotations about X: a positive one looks down. */
    set_point(&values, TRK_HID_TURN_X, M_PI / 2, 0, 0);
    trk_hid_sample(&values, &screen, &sample);
    near(sample.head + 3, -M_SQRT1_2, 0, 0);
    assert_true(trk_world_direction(&sample, world));
    near(world, 0, 0, -1);
}

static void head_pose_in_degrees(void **state)
{
    (void)state;
    static const uint8_t descriptor[] = {
        TRACKER,       ID(1),        GAZE,     XY,           UNIT(CM),     EXPONENT(-1),
        MIN_2(-18000), MAX_2(18000), SIZE(16), COUNT(2),     INPUT,        CLOSE,
        USAGE(0x27),   OPEN(0),      XY,       USAGE(0x23),  COUNT(3),     INPUT,
        CLOSE,         USAGE(0x28),  OPEN(0),  UNIT(DEGREE), EXPONENT(-2), RANGE(0x29, 0x2b),
        INPUT,         CLOSE,        CLOSE};
    struct trk_hid_layout layout;
    struct trk_hid_values values;
    uint8_t report[17] = {1};
    parse(descriptor, sizeof descriptor, &layout);
    report[13] = 0x28; /* 9000, which is 90 degrees about Y */
    report[14] = 0x23;
    assert_true(trk_hid_decode(&layout, TRK_HID_INPUT, report, sizeof report, &values));
    close_to(values.value[TRK_HID_TURN_Y], M_PI / 2);
    assert_false(layout.has_unknown_turn);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(mode_is_encoded_in_its_range), cmocka_unit_test(points_become_rays),
        cmocka_unit_test(eyes_are_where_rays_begin),    cmocka_unit_test(head_pose_takes_rays_along),
        cmocka_unit_test(head_pose_in_degrees),
    };
    return cmocka_run_group_tests_name("tracker_hid_report", tests, NULL, NULL);
}
