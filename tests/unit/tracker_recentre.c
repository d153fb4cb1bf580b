/* Recentring: correcting the gaze by looking at a target, and the file that keeps the rotation. */
#include "tracker_attention.h"

#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

static void recentring(void **state)
{
    (void)state;
    char error[TRK_ERROR_SIZE] = "";
    float rotation[4], target[3];
    assert_false(trk_recentre(attention, NULL, error));
    assert_non_null(strstr(error, "expected a look at the target"));
    look(60, 6);
    assert_true(trk_recentre(attention, NULL, error)); /* the user says that this gaze is straight ahead */
    look(60, 6);
    aims_at(0, 0.01);
    look(60, 26);
    aims_at(20, 0.01);
    at(23, 0, target);
    assert_true(trk_recentre(attention, target, error)); /* replaces the first: a measured 26 becomes 23 */
    look(60, 26);
    aims_at(23, 0.01);
    trk_recentre_get(attention, rotation);
    assert_float_equal(2 * asin(fabs((double)rotation[1])) * 180 / M_PI, 3, 0.01);
    look(60, 60);
    assert_false(trk_recentre(attention, NULL, error));
    assert_non_null(strstr(error, "expected at most 20"));
    look(2, 40);
    assert_false(trk_recentre(attention, NULL, error)); /* in mid-saccade */
    float after[4];
    trk_recentre_get(attention, after);
    assert_memory_equal(after, rotation, sizeof after);

    begin(&(struct trk_attention_options){0});
    assert_true(trk_recentre_set(attention, rotation));
    look(60, 26);
    aims_at(23, 0.01);
    static const float bad[][4] = {{0, 0, 0, 0}, {0, 0, 0, 2}, {NAN, 0, 0, 1}, {0, 0.5f, 0, 0.8660254f}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) assert_false(trk_recentre_set(attention, bad[i]));
}

/* The rotation is in the head frame, because a headset that has slipped turns with the head. */
static void recentring_turns_with_the_head(void **state)
{
    (void)state;
    char error[TRK_ERROR_SIZE] = "";
    for (int turn = 0; turn < 2; turn++)
        for (int i = 0; i < 60; i++) {
            struct trk_sample s = sample_of(TRK_DIRECTION | TRK_HEAD, 0);
            at(0, 5, s.direction); /* gaze is measured five degrees too high */
            turn_head(&s, turn ? 90 : 0);
            take(&s);
            if (turn == 0 && i == 59) assert_true(trk_recentre(attention, NULL, error));
        }
    aims_at(90, 0.01);
}

static void recentre_file(void **state)
{
    (void)state;
    char error[TRK_ERROR_SIZE] = "", dir[] = "tracker_attention.XXXXXX", path[64], *name = path;
    const float rotation[4] = {0, sinf(0.05f), 0, cosf(0.05f)};
    float back[4] = {0};
    assert_non_null(mkdtemp(dir));
    snprintf(path, sizeof path, "%s/recentre", dir);
    assert_false(trk_recentre_load(path, back, error));
    assert_non_null(strstr(error, "No such file"));
    FILE *kept = fopen(path, "w");
    assert_non_null(kept);
    trk_recentre_print(rotation, kept);
    assert_int_equal(fclose(kept), 0);
    if (!trk_recentre_load(path, back, error)) fail_msg("%s", error);
    assert_memory_equal(back, rotation, sizeof back);

    static const char *const bad[] = {"",
                                      "fovead-recentre 1\n",
                                      "fovead-recentre 1\n0 0 0\n",
                                      "0 0 0 1\n",
                                      "fovead-recentre 1\n0 0 0 1",
                                      "fovead-recentre 1\n0 0 0 2\n",
                                      "fovead-recentre 1\nnan 0 0 1\n",
                                      "fovead-recentre 1\n0 0 0 1\nmore\n",
                                      "fovead-recentre 2\n0 0 0 1\n"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        FILE *file = fopen(name, "w");
        assert_non_null(file);
        fputs(bad[i], file);
        fclose(file);
        assert_false(trk_recentre_load(path, back, error));
        assert_true(strstr(error, path) && strstr(error, "expected") && !strchr(error, '\n'));
        assert_memory_equal(back, rotation, sizeof back);
    }
    unlink(path);
    rmdir(dir);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(recentring),
        TEST(recentring_turns_with_the_head),
        TEST(recentre_file),
    };
    return cmocka_run_group_tests_name("tracker_recentre", tests, NULL, NULL);
}
