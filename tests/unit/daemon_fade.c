/* How slowly a client should show a tile. Nothing is rendered: counts and errors in, milliseconds out. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>

#include <cmocka.h>

#include "fade.h"
#include "renderer.h"

static void noise_changes_as_a_running_mean_does(void **state)
{
    (void)state;
    /* Paths of deviation 1: the error of 400 is 0.05, and the mean of 100 changes by sqrt(1 / 100 - 1 / 400).
     */
    assert_float_equal(dmn_change(0.05f, 100, 400), sqrt(0.0075), 1e-6);
    assert_float_equal(dmn_change(0.05f, 400, 400), 0, 0);
    assert_float_equal(dmn_change(0.05f, 400, 100), 0, 0);
    /* An error that is not known counts as large; a finer tile brings detail. */
    assert_float_equal(dmn_change(INFINITY, 100, 200), 1, 1e-6);
    assert_true(dmn_change(0, 0, 400) > 0.1f);
    assert_true(dmn_change(0.3f, 0, 400) > dmn_change(0, 0, 400));
}

static void a_fade_is_as_long_as_the_eye_needs(void **state)
{
    const float limit = rnd_visible_flicker(20, 20);

    (void)state;
    /* When paths have doubled, the change is the error. */
    assert_int_equal(dmn_fade_ms(20, 20, 0.99f * limit, 1000, 2000), 0);
    assert_int_equal(dmn_fade_ms(20, 20, 1.01f * limit, 1000, 2000), 101);
    assert_in_range(dmn_fade_ms(20, 20, 4 * limit, 1000, 2000), 399, 400);
    assert_int_equal(dmn_fade_ms(20, 20, 40 * limit, 1000, 2000), DMN_LONGEST_FADE_MS);
    assert_int_equal(dmn_fade_ms(20, 20, INFINITY, 1000, 2000), DMN_LONGEST_FADE_MS);
    /* Further out the eye sees less of it; in the fovea nothing is held back. */
    assert_true(dmn_fade_ms(50, 20, 4 * limit, 1000, 2000) < dmn_fade_ms(20, 20, 4 * limit, 1000, 2000));
    assert_int_equal(dmn_fade_ms(0, 20, 1, 0, 2000), 0);
    assert_int_equal(dmn_fade_ms(5.7f, 20, 1, 1000, 2000), 0);
    assert_true(dmn_fade_ms(6, 20, 1, 1000, 2000) > 0);
}

/* Whatever changes, a tenth of a second shows no more of it than the eye lets pass, unless it would take too
 * long. */
static void no_step_is_seen(void **state)
{
    (void)state;
    for (float e = 6; e < 180; e += 7)
        for (float ppd = 3; ppd < 60; ppd *= 2)
            for (float error = 0.001f; error < 2; error *= 1.5f)
                for (uint64_t now = 1100; now < 100000; now *= 2) {
                    uint32_t ms = dmn_fade_ms(e, ppd, error, 1000, now);
                    float change = dmn_change(error, 1000, now), limit = rnd_visible_flicker(e, ppd);

                    assert_true(ms <= DMN_LONGEST_FADE_MS);
                    if (ms < DMN_LONGEST_FADE_MS)
                        assert_true(change * 100 / fmaxf((float)ms + 1, 100) <= limit);
                }
}

static void only_what_replaces_something_fades(void **state)
{
    const float ahead[3] = {0, 0, -1};
    const struct dmn_tile now = {.samples = 1 << 16, .error = 0.5f};
    struct dmn_pyramid pyramid;
    struct dmn_tile *sent;
    int behind = 0, ahead_x = 8; /* columns of 16; rows 3 and 4 of 8 touch the horizon */

    (void)state;
    assert_true(dmn_pyramid_init(&pyramid, 1024, 512, 4));
    sent = calloc(pyramid.count, sizeof(*sent));
    assert_non_null(sent);
    assert_int_equal(dmn_fade_of(&pyramid, sent, ahead, 0, behind, 4, &now), 0); /* nothing is shown there */
    sent[dmn_pyramid_index(&pyramid, 3, 1, 0)].samples = 1000;
    assert_int_equal(dmn_fade_of(&pyramid, sent, ahead, 0, behind, 4, &now), 0); /* a coarse tile elsewhere */
    sent[dmn_pyramid_index(&pyramid, 2, 0, 1)].samples = 1000;
    assert_true(dmn_fade_of(&pyramid, sent, ahead, 0, behind, 4, &now) > 0);
    sent[dmn_pyramid_index(&pyramid, 0, 0, 4)] = now;
    assert_int_equal(dmn_fade_of(&pyramid, sent, ahead, 0, behind, 4, &now), 0); /* the same paths */
    /* The tile at the gaze is shown at once, whatever was there. */
    sent[dmn_pyramid_index(&pyramid, 0, ahead_x, 3)].samples = 1000;
    assert_int_equal(dmn_fade_of(&pyramid, sent, ahead, 0, ahead_x, 3, &now), 0);
    free(sent);
    dmn_pyramid_finish(&pyramid);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(noise_changes_as_a_running_mean_does),
        cmocka_unit_test(a_fade_is_as_long_as_the_eye_needs),
        cmocka_unit_test(no_step_is_seen),
        cmocka_unit_test(only_what_replaces_something_fades),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
