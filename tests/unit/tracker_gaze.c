/* Which samples have a gaze, and where it points: one rule for steering, counting and reporting. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "tracker.h"

#include <math.h>
#include <string.h>

enum { BOTH = TRK_DIRECTION, LEFT = TRK_LEFT_DIRECTION, RIGHT = TRK_RIGHT_DIRECTION };
enum { LEFT_LID = TRK_LEFT_OPENNESS, RIGHT_LID = TRK_RIGHT_OPENNESS };

/* The combined gaze points ahead, the left eye's 0.1 to the right, and the right eye's 0.1 up. The head is
 * turned to the left by a quarter turn, which takes -Z to -X. */
static struct trk_sample sample_with(uint32_t valid, float left_openness, float right_openness)
{
    const float length = sqrtf(1.01f);
    struct trk_sample sample = {
        .sequence = 1,
        .valid = valid,
        .direction = {0, 0, -1},
        .eye = {{.direction = {0.1f / length, 0, -1 / length}, .openness = left_openness},
                {.direction = {0, 0.1f / length, -1 / length}, .openness = right_openness}},
        .head = {0, 0, 0, 0, sqrtf(0.5f), 0, sqrtf(0.5f)},
    };
    return sample;
}

static void known_cases(void **state)
{
    (void)state;
    static const struct {
        uint32_t valid;
        float left, right; /* openness */
        const char *source;
        float head[3]; /* not normalised */
    } cases[] = {
        {BOTH, 0, 0, "both eyes", {0, 0, -1}},
        {LEFT, 0, 0, "left eye", {0.1f, 0, -1}},
        {RIGHT, 0, 0, "right eye", {0, 0.1f, -1}},
        {LEFT | RIGHT, 0, 0, "both eyes", {0.05f, 0.05f, -1}},
        {LEFT | RIGHT | LEFT_LID | RIGHT_LID, 0.2f, 1, "right eye", {0, 0.1f, -1}},
        {LEFT | RIGHT | LEFT_LID | RIGHT_LID, 1, 0.2f, "left eye", {0.1f, 0, -1}},
        {RIGHT | LEFT_LID, 0, 0, "right eye", {0, 0.1f, -1}},
        {BOTH | LEFT | RIGHT | LEFT_LID | RIGHT_LID, 1, 0.2f, "both eyes", {0, 0, -1}},
        {BOTH | LEFT | RIGHT | LEFT_LID | RIGHT_LID, 0.2f, 0.2f, NULL, {0}},
        {LEFT | LEFT_LID, 0.2f, 0, NULL, {0}},
        {LEFT_LID | RIGHT_LID, 1, 1, NULL, {0}},
        {TRK_SCREEN | TRK_ORIGIN, 0, 0, NULL, {0}},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        for (int turned = 0; turned < 2; turned++) {
            struct trk_sample sample = sample_with(cases[i].valid, cases[i].left, cases[i].right);
            float head[3] = {9, 9, 9}, world[3] = {9, 9, 9};
            const char *source = "";
            if (turned) sample.valid |= TRK_HEAD;
            assert_int_equal(trk_gaze_direction(&sample, head, &source), cases[i].source != NULL);
            assert_int_equal(trk_world_direction(&sample, world), cases[i].source != NULL);
            if (!cases[i].source) {
                assert_true(head[0] == 9 && world[0] == 9);
                continue;
            }
            const float *v = cases[i].head, length = sqrtf(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
            const float expected[3] = {turned ? v[2] : v[0], v[1], turned ? -v[0] : v[2]};
            assert_string_equal(source, cases[i].source);
            for (int k = 0; k < 3; k++) {
                assert_float_equal(head[k], v[k] / length, 1e-6);
                assert_float_equal(world[k], expected[k] / length, 1e-6);
            }
        }
}

/* Whatever a sample holds, it steers if and only if it has a gaze, and then to that gaze. */
static void what_is_valid_steers(void **state)
{
    (void)state;
    static const uint32_t bits[] = {BOTH, LEFT, RIGHT, LEFT_LID, RIGHT_LID, TRK_HEAD};
    int with = 0, without = 0;
    for (unsigned set = 0; set < 1u << 6; set++)
        for (int lids = 0; lids < 4; lids++) {
            uint32_t valid = 0;
            for (int i = 0; i < 6; i++) valid |= set >> i & 1 ? bits[i] : 0;
            const struct trk_sample sample = sample_with(valid, lids & 1, lids >> 1);
            struct trk_attention *attention =
                trk_attention_create(&(struct trk_attention_options){.raw = true});
            struct trk_aim gaze;
            float world[3];
            assert_non_null(attention);
            trk_attend(attention, &sample, 1, &gaze);
            trk_attention_destroy(attention);
            const bool has_gaze = trk_world_direction(&sample, world);
            assert_int_equal(gaze.state == TRK_FALLBACK, !has_gaze);
            for (int k = 0; k < 3 && has_gaze; k++) assert_float_equal(gaze.direction[k], world[k], 1e-6);
            *(has_gaze ? &with : &without) += 1;
        }
    assert_true(with > 50 && without > 50);
}

/* Eyes that look in opposite directions, and numbers that make no direction. */
static void what_is_no_direction(void **state)
{
    (void)state;
    struct trk_sample sample = sample_with(LEFT | RIGHT, 0, 0);
    float world[3];
    for (int k = 0; k < 3; k++) sample.eye[1].direction[k] = -sample.eye[0].direction[k];
    assert_false(trk_world_direction(&sample, world));
    sample = sample_with(BOTH, 0, 0);
    sample.direction[1] = NAN;
    assert_false(trk_world_direction(&sample, world));
    memset(sample.direction, 0, sizeof sample.direction);
    assert_false(trk_world_direction(&sample, world));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(known_cases),
        cmocka_unit_test(what_is_valid_steers),
        cmocka_unit_test(what_is_no_direction),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
