/* Whose view steers: a headset before windows, among equals the latest that asked, then the one before. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <string.h>

#include "steering.h"

enum { CLIENTS = 4 };

static struct dmn_steering steering;
static struct dmn_shown client[CLIENTS];
static const struct trk_view view = {.orientation = {0, 0, 0, 1}, .fov = {1, 1}, .screen = {0, 0, 1, 1}};

static int setup(void **state)
{
    (void)state;
    memset(&steering, 0, sizeof(steering));
    memset(client, 0, sizeof(client));
    return 0;
}

static void window(int i, bool asks)
{
    dmn_steering_show(&steering, &client[i], &view, false, asks);
}

static void headset(int i)
{
    dmn_steering_show(&steering, &client[i], &view, true, true);
}

static void leave(int i)
{
    dmn_steering_show(&steering, &client[i], NULL, false, false);
}

static int first(void)
{
    return steering.first ? (int)(steering.first - client) : -1;
}

static void the_latest_that_asked(void **state)
{
    (void)state;
    assert_int_equal(first(), -1);
    leave(0); /* has shown nothing */
    assert_int_equal(first(), -1);
    assert_int_equal(steering.changes, 0);
    window(0, true);
    assert_int_equal(first(), 0);
    window(1, true);
    assert_int_equal(first(), 1);
    window(2, true);
    window(0, false); /* its window was resized */
    assert_int_equal(first(), 2);
    window(0, true);
    assert_int_equal(first(), 0);
    assert_int_equal(steering.changes, 4);
    window(0, true);
    assert_int_equal(steering.changes, 4);
    leave(0);
    assert_int_equal(first(), 2);
    leave(1);
    assert_int_equal(first(), 2);
    leave(2);
    assert_int_equal(first(), -1);
    assert_int_equal(steering.changes, 6);
}

/* Pages that were opened and left alone do not fight, however often they tell their views. */
static void who_has_not_asked(void **state)
{
    (void)state;
    window(0, false);
    window(1, false);
    window(2, false);
    for (int i = 0; i < 9; i++) window(i % 3, false);
    assert_int_equal(first(), 0);
    assert_int_equal(steering.changes, 1);
    window(2, true);
    assert_int_equal(first(), 2);
    window(3, false);
    assert_int_equal(first(), 2);
    leave(2);
    assert_int_equal(first(), 0);
    window(2, false); /* back, and has forgotten that it asked */
    assert_int_equal(first(), 0);
    leave(0);
    assert_int_equal(first(), 1);
    leave(1);
    assert_int_equal(first(), 3);
}

static void headsets_before_windows(void **state)
{
    (void)state;
    window(0, true);
    headset(1);
    assert_int_equal(first(), 1);
    for (int i = 0; i < 9; i++) window(0, true);
    assert_int_equal(first(), 1);
    headset(2);
    for (int i = 0; i < 9; i++) headset(1 + i % 2); /* as heads move */
    assert_int_equal(first(), 2);
    assert_int_equal(steering.changes, 3);
    leave(2);
    assert_int_equal(first(), 1);
    window(1, false); /* takes the headset off: its page asked before the other one */
    assert_int_equal(first(), 0);
    leave(0);
    assert_int_equal(first(), 1);
    headset(1);
    window(0, true);
    assert_int_equal(first(), 1);
}

static void the_newest_view(void **state)
{
    struct trk_view other = view;

    (void)state;
    window(0, true);
    other.fov[0] = 2;
    dmn_steering_show(&steering, &client[0], &other, false, false);
    assert_true(steering.first->view.fov[0] == 2);
    dmn_steering_show(&steering, &client[0], &view, false, true);
    assert_true(steering.first->view.fov[0] == 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(the_latest_that_asked, setup),
        cmocka_unit_test_setup(who_has_not_asked, setup),
        cmocka_unit_test_setup(headsets_before_windows, setup),
        cmocka_unit_test_setup(the_newest_view, setup),
    };
    return cmocka_run_group_tests_name("daemon_steering", tests, NULL, NULL);
}
