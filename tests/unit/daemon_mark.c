/* What is drawn where the eye looks: points at the right angle from the gaze, and no line across the
 * picture. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "mark.h"

enum { WIDTH = 4096, HEIGHT = 2048 };

struct mark {
    struct dmn_stroke stroke[DMN_MARK_MOST];
    size_t count;
    double left, right, top, bottom; /* of its lines */
};

static void direction_at(double azimuth_deg, double elevation_deg, float out[3])
{
    const double a = azimuth_deg * M_PI / 180, e = elevation_deg * M_PI / 180;

    out[0] = (float)(cos(e) * sin(a));
    out[1] = (float)sin(e);
    out[2] = (float)(-cos(e) * cos(a));
}

/* Degrees between the gaze and a point of the picture. */
static double angle_to(const float gaze[3], const struct dmn_stroke *stroke)
{
    float point[3];
    double cosine = 0;

    direction_at(((double)stroke->x / WIDTH - 0.5) * 360, (0.5 - (double)stroke->y / HEIGHT) * 180, point);
    for (int i = 0; i < 3; i++) cosine += (double)gaze[i] * (double)point[i];
    return acos(fmin(1, cosine)) * 180 / M_PI;
}

static bool is_at_seam(const struct dmn_stroke *stroke)
{
    return stroke->x == 0 || stroke->x == WIDTH;
}

/* Draw it, and check what holds for every gaze. */
static struct mark mark_at(double azimuth_deg, double elevation_deg)
{
    struct mark mark = {.left = WIDTH, .top = HEIGHT};
    float gaze[3];
    size_t middles = 0;

    direction_at(azimuth_deg, elevation_deg, gaze);
    mark.count = dmn_mark(gaze, WIDTH, HEIGHT, mark.stroke);
    assert_in_range(mark.count, 64 + 8, DMN_MARK_MOST);
    assert_false(mark.stroke[0].down);
    for (size_t i = 0; i < mark.count; i++) {
        const struct dmn_stroke *stroke = &mark.stroke[i];
        const double angle = angle_to(gaze, stroke);

        if (!(stroke->x >= 0 && stroke->x <= WIDTH && stroke->y >= 0 && stroke->y <= HEIGHT))
            fail_msg("(%g, %g) is outside the picture", (double)stroke->x, (double)stroke->y);
        middles += angle < 0.05;
        if (!is_at_seam(stroke) && angle > 0.05 && fabs(angle - 0.6) > 0.01 && fabs(angle - 2.5) > 0.01)
            fail_msg("(%g, %g) is %g degrees from the gaze", (double)stroke->x, (double)stroke->y, angle);
        if (stroke->down && fabs((double)(stroke->x - stroke[-1].x)) > WIDTH / 2)
            fail_msg("a line from %g to %g", (double)stroke[-1].x, (double)stroke->x);
        mark.left = fmin(mark.left, (double)stroke->x);
        mark.right = fmax(mark.right, (double)stroke->x);
        mark.top = fmin(mark.top, (double)stroke->y);
        mark.bottom = fmax(mark.bottom, (double)stroke->y);
    }
    assert_true(middles >= 4); /* where the arms of the cross begin */
    return mark;
}

static void near(double value, double expected)
{
    if (fabs(value - expected) > 1) fail_msg("%g, expected %g", value, expected);
}

/* 2.5 degrees are 28.4 pixels. */
static void ahead(void **state)
{
    const struct mark mark = mark_at(0, 0);

    (void)state;
    near(mark.left, 2048 - 28.4);
    near(mark.right, 2048 + 28.4);
    near(mark.top, 1024 - 28.4);
    near(mark.bottom, 1024 + 28.4);
    /* The circle is closed. */
    near((double)mark.stroke[64].x, (double)mark.stroke[0].x);
    near((double)mark.stroke[64].y, (double)mark.stroke[0].y);
}

/* Wider by about 1 / cos(elevation). */
static void up(void **state)
{
    const struct mark mark = mark_at(90, 60);

    (void)state;
    near((mark.left + mark.right) / 2, 3072);
    near(mark.right - mark.left, 2 * asin(sin(2.5 * M_PI / 180) / cos(M_PI / 3)) / (2 * M_PI) * WIDTH);
    near(mark.top, (90 - 62.5) / 180 * HEIGHT);
    near(mark.bottom, (90 - 57.5) / 180 * HEIGHT);
}

/* One half at each edge, up to the edge. */
static void at_the_seam(void **state)
{
    const struct mark mark = mark_at(180, 0);
    size_t edges = 0;

    (void)state;
    assert_true(mark.left == 0 && mark.right == WIDTH);
    for (size_t i = 0; i < mark.count; i++) edges += is_at_seam(&mark.stroke[i]);
    assert_true(edges >= 4); /* the circle crosses the seam twice */
    for (size_t i = 0; i < mark.count; i++)
        assert_true(mark.stroke[i].x < 40 || mark.stroke[i].x > WIDTH - 40);
}

/* All around, at one height. */
static void at_the_poles(void **state)
{
    for (int sign = -1; sign <= 1; sign += 2) {
        const struct mark mark = mark_at(30, sign * 90);
        const double height = sign > 0 ? 28.4 : HEIGHT - 28.4;

        assert_true(mark.left == 0 && mark.right == WIDTH);
        for (int i = 0; i <= 64; i++) near((double)mark.stroke[i].y, height);
    }
    (void)state;
}

static void everywhere(void **state)
{
    (void)state;
    for (int azimuth = -180; azimuth <= 180; azimuth += 1)
        for (int elevation = -90; elevation <= 90; elevation += 5) mark_at(azimuth, elevation);
    for (int tenths = 860; tenths < 900; tenths++) mark_at(179.9, tenths * 0.1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ahead),        cmocka_unit_test(up),         cmocka_unit_test(at_the_seam),
        cmocka_unit_test(at_the_poles), cmocka_unit_test(everywhere),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
