/* Gaze at a screen goes through the view that the screen shows. */
#include "tracker_attention.h"

#include "gaze.h"
#include "view.h"

static const uint32_t on_screen = TRK_DIRECTION | TRK_SCREEN;
static const float full[4] = {0, 0, 1, 1}, right_half[4] = {0.5f, 0, 0.5f, 1};

/* A view turned to the right, then up, then rolled against the clock; degrees. */
static struct trk_view view_of(double yaw, double pitch, double roll, double width, double height,
                               const float screen[4])
{
    struct trk_view view = {.fov = {(float)glm_rad((float)width), (float)glm_rad((float)height)}};
    versor a, b, c;
    glm_quatv(a, (float)(-yaw * M_PI / 180), GLM_YUP);
    glm_quatv(b, (float)(pitch * M_PI / 180), GLM_XUP);
    glm_quatv(c, (float)(roll * M_PI / 180), GLM_ZUP);
    glm_quat_mul(a, b, a);
    glm_quat_mul(a, c, a);
    memcpy(view.orientation, a, sizeof a);
    memcpy(view.screen, screen, sizeof view.screen);
    return view;
}

static void shows(const struct trk_view *view, float x, float y, double azimuth, double elevation)
{
    float direction[3] = {0}, expected[3], back[2];
    at(azimuth, elevation, expected);
    assert_true(trk_view_direction(view, (float[]){x, y}, direction));
    if (!(trk_angle_deg(direction, expected) < 0.001f))
        fail_msg("%g,%g is seen at %g %g %g, expected %g right, %g up", (double)x, (double)y,
                 (double)direction[0], (double)direction[1], (double)direction[2], azimuth, elevation);
    assert_float_equal(glm_vec3_norm(direction), 1, 1e-6);
    assert_true(trk_view_point(view, direction, back));
    assert_float_equal(back[0], x, 1e-5);
    assert_float_equal(back[1], y, 1e-5);
}

static void points_of_a_view(void **state)
{
    (void)state;
    struct trk_view view = view_of(90, 0, 0, 90, 60, full);
    shows(&view, 0.5f, 0.5f, 90, 0);
    shows(&view, 1, 0.5f, 135, 0);
    shows(&view, 0, 0.5f, 45, 0);
    shows(&view, 0.5f, 0, 90, 30);
    shows(&view, 0.5f, 1, 90, -30);
    shows(&view, 1, 0, 135, atan(tan(M_PI / 6) / M_SQRT2) * 180 / M_PI);
    shows(&view, 0.75f, 0.5f, 90 + atan(0.5) * 180 / M_PI, 0); /* straight lines stay straight */
    view = view_of(0, 90, 0, 90, 60, full);
    shows(&view, 0.5f, 0.5f, 0, 90);
    shows(&view, 1, 0.5f, 90, 45);
    shows(&view, 0.5f, 1, 0, 60);
    shows(&view, 0.5f, 0, 180, 60);
    view = view_of(30, -90, 0, 90, 60, full);
    shows(&view, 0.5f, 0.5f, 0, -90);
    shows(&view, 0, 0.5f, -60, -45);
    shows(&view, 0.5f, 0, 30, -60);
    view = view_of(0, 0, 90, 90, 60, full);
    shows(&view, 1, 0.5f, 0, 45);
    view = view_of(170, 0, 0, 90, 60, full);
    shows(&view, 1, 0.5f, -145, 0);
    view = view_of(-90, 0, 0, 90, 60, right_half);
    shows(&view, 0.75f, 0.5f, -90, 0);
    shows(&view, 1, 0.5f, -45, 0);
    shows(&view, 0.5f, 0.5f, -135, 0);
}

static void points_beside_a_view(void **state)
{
    (void)state;
    const struct trk_view view = view_of(90, 0, 0, 90, 60, right_half);
    static const float beside[][2] = {{0.49f, 0.5f}, {1.01f, 0.5f}, {0.75f, -0.01f},
                                      {0.75f, 1.1f}, {NAN, 0.5f},   {0.75f, INFINITY}};
    float direction[3] = {7, 7, 7}, point[2], expected[3];
    for (size_t i = 0; i < sizeof beside / sizeof *beside; i++)
        assert_false(trk_view_direction(&view, beside[i], direction));
    assert_true(direction[0] == 7 && direction[2] == 7);
    trk_view_nearest(&view, (float[]){3, 0.5f}, direction);
    at(135, 0, expected);
    assert_true(trk_angle_deg(direction, expected) < 0.001f);
    static const double unseen[][2] = {{-90, 0}, {44, 0}, {136, 0}, {90, 31}, {0, 90}, {0, 0}};
    for (size_t i = 0; i < sizeof unseen / sizeof *unseen; i++) {
        at(unseen[i][0], unseen[i][1], direction);
        assert_false(trk_view_point(&view, direction, point));
    }
}

static void points_from_the_desk(void **state)
{
    (void)state;
    float direction[3], back[2];
    for (int i = 0; i < 400; i++) {
        const float point[2] = {(float)(i % 20) / 5 - 1.5f, (float)(i / 20) / 5 - 1.5f};
        trk_desk_direction(point, direction);
        assert_float_equal(glm_vec3_norm(direction), 1, 1e-6);
        trk_desk_point(direction, back);
        for (int k = 0; k < 2; k++) assert_float_equal(back[k], point[k], 1e-5);
    }
    trk_desk_direction((float[]){1, 0.5f}, direction); /* 0.26 m to the right, 0.65 m away */
    assert_float_equal(atan2(direction[0], -direction[2]) * 180 / M_PI, 21.8014, 1e-3);
    trk_desk_point((float[]){1, 0, 0}, back);
    assert_true(isfinite(back[0]) && back[0] > 1000);
}

/* --- the aim --- */

/* n samples of an eye that looks there. */
static void look_at(int n, float x, float y)
{
    for (int i = 0; i < n; i++) {
        struct trk_sample s = sample_of(on_screen, 0);
        s.screen[0] = x;
        s.screen[1] = y;
        trk_desk_direction(s.screen, s.direction);
        take(&s);
    }
}

static void show(double yaw, double width, const float screen[4])
{
    const struct trk_view view = view_of(yaw, 0, 0, width, 60, screen);
    trk_attention_view(attention, &view);
}

static void the_aim_goes_through_the_view(void **state)
{
    (void)state;
    look_at(60, 1, 0.5f);
    aims_at(21.80, 0.01); /* no view is known: at its true angle */
    show(90, 90, full);
    look_at(60, 0.5f, 0.5f);
    aims_at(90, 0.01);
    is(TRK_FIXATION, "both eyes");
    look_at(60, 1, 0.5f);
    aims_at(135, 0.01);
    look_at(60, 0, 0.5f);
    aims_at(45, 0.01);
    show(-170, 90, right_half);
    look_at(60, 0.75f, 0.5f);
    aims_at(-170, 0.01);
    look_at(60, 0.5f, 0.5f);
    aims_at(145, 0.01);
}

/* While the eye stays where it is on the screen, the aim turns with the view, by samples and without them,
 * and nothing is taken for a saccade. */
static void the_aim_turns_with_the_view(void **state)
{
    (void)state;
    static const float places[] = {0.5f, 1, 0.25f};
    static const double beyond[] = {0, 45, -26.565};
    for (int k = 0; k < 3; k++) {
        show(0, 90, full);
        look_at(60, places[k], 0.5f);
        for (int i = 1; i <= 200; i++) {
            show(3 * i, 90, full); /* 360 degrees per second */
            trk_attend(attention, NULL, gaze.time_ns, &gaze);
            aims_at(3 * i + beyond[k], 0.01);
            look_at(1, places[k], 0.5f);
            aims_at(3 * i + beyond[k], 0.01);
            is(TRK_FIXATION, "both eyes");
        }
        for (int i = 0; i < 60; i++) { /* and with its zoom */
            const double width = 90 - i;
            show(0, width, full);
            look_at(1, 1, 0.5f);
            if (places[k] == 1) aims_at(width / 2, 0.01);
            if (places[k] == 1) is(TRK_FIXATION, "both eyes");
        }
    }
    /* The eye's own jumps are still seen. */
    show(0, 90, full);
    look_at(60, 0.2f, 0.5f);
    look_at(2, 0.5f, 0.5f);
    look_at(1, 0.8f, 0.5f);
    is(TRK_SACCADE, "both eyes");
}

static void beside_the_view(void **state)
{
    (void)state;
    show(90, 90, right_half);
    look_at(60, 0.2f, 0.5f); /* from the beginning */
    is(TRK_FIXATION, "view centre");
    aims_at(90, 0.01);
    look_at(60, 0.875f, 0.5f);
    aims_at(116.565, 0.01);
    look_at(1200, 0.2f, 0.5f); /* for ten seconds: held, and not lost */
    is(TRK_FIXATION, "last gaze");
    assert_string_equal(gaze.why, "the eye looks beside the view");
    assert_true(gaze.spread == 1);
    aims_at(116.565, 0.01);
    show(-90, 90, right_half);
    look_at(1, 0.2f, 0.5f);
    aims_at(-63.435, 0.01);
    look_at(60, 0.75f, 0.5f);
    is(TRK_FIXATION, "both eyes");
    aims_at(-90, 0.01);
    show(0, 90, (float[]){0, 0, 0.5f, 1}); /* the window moves away from under the eye */
    look_at(1, 0.75f, 0.5f);
    is(TRK_FIXATION, "last gaze");
    aims_at(45, 0.01); /* its nearest edge */
}

static void a_blink_while_the_view_turns(void **state)
{
    (void)state;
    show(0, 90, full);
    look_at(60, 1, 0.5f);
    for (int i = 0; i < 30; i++) {
        show(i, 90, full);
        hide(1, TRK_LEFT_OPENNESS | TRK_RIGHT_OPENNESS);
        aims_at(i + 45, 0.01);
    }
    is(TRK_BLINK, "last gaze");
    hide(300, TRK_LEFT_OPENNESS | TRK_RIGHT_OPENNESS);
    is(TRK_FALLBACK, "view centre");
    aims_at(29, 0.01);
    look_at(60, 1, 0.5f);
    aims_at(74, 0.01);
}

static void the_view_goes(void **state)
{
    (void)state;
    show(90, 90, full);
    look_at(60, 1, 0.5f);
    trk_attention_view(attention, NULL);
    trk_attend(attention, NULL, gaze.time_ns, &gaze);
    aims_at(135, 0.01);
    assert_false(gaze.moved);
    look_at(60, 1, 0.5f);
    aims_at(21.80, 0.01);
}

static void frozen_in_the_world(void **state)
{
    (void)state;
    show(90, 90, full);
    look_at(60, 1, 0.5f);
    trk_attention_freeze(attention, true);
    show(0, 90, full);
    look_at(60, 0.5f, 0.5f);
    is(TRK_FROZEN, "last gaze");
    aims_at(135, 0.01);
    trk_attention_freeze(attention, false);
    look_at(1, 0.5f, 0.5f);
    aims_at(0, 0.01);
}

/* The user looks at the middle of the view, and the tracker says 4.6 degrees beside it. */
static void recentring_on_a_screen(void **state)
{
    (void)state;
    char error[TRK_ERROR_SIZE] = "";
    float target[3];
    show(90, 90, full);
    look_at(60, 0.6f, 0.5f);
    assert_true(trk_recentre(attention, NULL, error));
    look_at(60, 0.6f, 0.5f);
    aims_at(90, 0.01);
    show(-30, 90, full); /* the correction is of the tracker, and does not turn with the view */
    look_at(60, 0.6f, 0.5f);
    aims_at(-30, 0.01);
    at(-30 - 26.565, 0, target);
    look_at(60, 0.3f, 0.5f);
    assert_true(trk_recentre(attention, target, error)); /* replaces: 0.3 is 0.25 */
    look_at(60, 0.3f, 0.5f);
    aims_at(-30 - 26.565, 0.01);
    at(90, 0, target);
    assert_false(trk_recentre(attention, target, error));
    assert_non_null(strstr(error, "the target is not in the view"));
    look_at(60, 1.1f, 0.5f);
    assert_false(trk_recentre(attention, NULL, error));
    assert_non_null(strstr(error, "expected at most 20"));
}

/* Where the head is before the screen does not matter for where on the screen the eyes look. */
static void heads_before_a_screen(void **state)
{
    (void)state;
    const uint32_t eyes = TRK_LEFT_DIRECTION | TRK_RIGHT_DIRECTION;
    struct trk_sample s = sample_of(on_screen | eyes | TRK_HEAD | TRK_ORIGIN | TRK_LEFT_ORIGIN, -30);
    float world[3], expected[3];
    turn_head(&s, 40);
    assert_true(trk_world_direction(&s, world));
    trk_drop_head(&s);
    assert_int_equal(s.valid, on_screen | eyes);
    at(10, 0, expected);
    assert_true(trk_angle_deg(world, expected) < 0.001f);
    assert_true(trk_angle_deg(s.direction, expected) < 0.001f);
    for (int i = 0; i < 2; i++) assert_true(trk_angle_deg(s.eye[i].direction, expected) < 0.001f);
    trk_drop_head(&s); /* without a pose: as it is */
    assert_true(trk_angle_deg(s.direction, expected) < 0.001f);

    show(90, 90, full);
    for (int i = 0; i < 60; i++) {
        s = sample_of(on_screen | TRK_HEAD, 0);
        s.screen[0] = 1;
        s.screen[1] = 0.5f;
        turn_head(&s, i);
        take(&s);
    }
    is(TRK_FIXATION, "both eyes");
    aims_at(135, 0.01);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(points_of_a_view),
        TEST(points_beside_a_view),
        TEST(points_from_the_desk),
        TEST(the_aim_goes_through_the_view),
        TEST(the_aim_turns_with_the_view),
        TEST(beside_the_view),
        TEST(a_blink_while_the_view_turns),
        TEST(the_view_goes),
        TEST(frozen_in_the_world),
        TEST(recentring_on_a_screen),
        TEST(heads_before_a_screen),
    };
    return cmocka_run_group_tests_name("tracker_view", tests, NULL, NULL);
}
