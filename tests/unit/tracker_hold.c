/* What to render for while gaze is unknown: the aim is held, widened, given up and taken up again. */
#include "tracker_attention.h"

static void before_the_first_gaze(void **state)
{
    (void)state;
    trk_attend(attention, NULL, 0, &gaze);
    is(TRK_FALLBACK, "view centre");
    aims_at(0, 1e-3);
    assert_true(gaze.spread == 4 && gaze.sequence == 0);
    const struct trk_view right = {
        .orientation = {0, -(float)M_SQRT1_2, 0, (float)M_SQRT1_2}, .fov = {1, 1}, .screen = {0, 0, 1, 1}};
    trk_attention_view(attention, &right);
    trk_attend(attention, NULL, 1, &gaze);
    aims_at(90, 1e-3);
    assert_true(gaze.moved && gaze.time_ns == 1);
    trk_attend(attention, NULL, 2, &gaze);
    assert_false(gaze.moved);
    look(1, 5);
    is(TRK_FIXATION, "both eyes");
    aims_at(5, 1e-3);
    assert_true(gaze.spread == 1 && gaze.sequence == 1 && gaze.moved);
}

/* The aim is held for 500 ms, widens up to four times until 2 s, and is then at the view's centre. */
static void holds_widens_gives_up(void **state)
{
    (void)state;
    look(60, 20);
    const uint64_t last_device_ns = now_ns(), last_ns = 5000 * MS + last_device_ns;
    for (uint64_t ms = 0; ms < 3000; ms++) {
        static const enum trk_state states[] = {TRK_FIXATION, TRK_BLINK, TRK_LOST, TRK_FALLBACK};
        if (ms % 8 == 4) {
            struct trk_sample s = sample_of(0, 0);
            s.device_ns = last_device_ns + ms * MS;
            s.arrival_ns = last_ns + ms * MS;
            take(&s);
        } else {
            trk_attend(attention, NULL, last_ns + ms * MS, &gaze);
        }
        if (ms < 4) continue;
        int phase = ms < 75 ? 0 : ms <= 500 ? 1 : ms < 2000 ? 2 : 3;
        is(states[phase], phase < 3 ? "last gaze" : "view centre");
        aims_at(phase < 3 ? 20 : 0, 0.01);
        double spread = ms <= 500 ? 1 : ms < 2000 ? 1 + 3 * ((double)ms - 500) / 1500 : 4;
        assert_float_equal(gaze.spread, spread, 1e-5);
    }
    look(1, 20); /* the eye is seen again, but not trusted yet */
    is(TRK_BLINK, "last gaze");
    look(2, 20);
    is(TRK_FIXATION, "both eyes");
    aims_at(20, 0.01);
    assert_true(gaze.spread == 1);
}

static void lids_tell(void **state)
{
    (void)state;
    const uint32_t lids = TRK_LEFT_OPENNESS | TRK_RIGHT_OPENNESS;
    look(60, 20);
    hide(1, lids);
    is(TRK_BLINK, "last gaze");
    hide(100, lids);
    is(TRK_BLINK, "last gaze"); /* 833 ms */
    hide(20, lids);
    is(TRK_LOST, "last gaze");
    begin(&(struct trk_attention_options){0});
    look(60, 20);
    for (int i = 0; i < 20; i++) {
        struct trk_sample s = sample_of(lids, 0);
        s.eye[1].openness = 0.8f; /* one lid is up, but no eye is seen */
        take(&s);
    }
    is(TRK_LOST, "last gaze");
}

/* A device that goes on reporting the eye as it rolls under its lid does not move the aim. One lid that is
 * down does not hold the aim: the other eye steers. */
static void lids_hold(void **state)
{
    (void)state;
    const uint32_t lids = TRK_LEFT_OPENNESS | TRK_RIGHT_OPENNESS;
    const uint32_t eyes = TRK_LEFT_DIRECTION | TRK_RIGHT_DIRECTION;
    for (int combined = 0; combined < 2; combined++) {
        begin(&(struct trk_attention_options){0});
        look(60, 20);
        for (int i = 0; i < 30; i++) {
            struct trk_sample s = sample_of(lids | (combined ? TRK_DIRECTION : eyes), 20);
            s.eye[0].openness = s.eye[1].openness = i % 2 ? 0 : 0.3f;
            at(20, -0.5 * i, s.direction);
            at(20, -0.5 * i, s.eye[0].direction);
            at(20, -0.5 * i, s.eye[1].direction);
            take(&s);
            is(TRK_BLINK, "last gaze");
            assert_string_equal(gaze.why, "the lids are down");
            aims_at(20, 0.01);
        }
        look(3, 20);
        is(TRK_FIXATION, "both eyes");
        for (int i = 0; i < 30; i++) {
            struct trk_sample s = sample_of(lids | eyes, 20);
            s.eye[0].openness = 1;
            s.eye[1].openness = 0;
            at(20, -15, s.eye[1].direction);
            take(&s);
        }
        is(TRK_FIXATION, "left eye");
        aims_at(20, 0.01);
    }
    begin(&(struct trk_attention_options){0});
    look(60, 20);
    for (int i = 0; i < 30; i++) { /* the openness of the eye that is seen is unknown */
        struct trk_sample s = sample_of(TRK_LEFT_OPENNESS | TRK_RIGHT_DIRECTION, 20);
        take(&s);
    }
    is(TRK_FIXATION, "right eye");
}

/* A sample that is read late still tells where the gaze is. Silence is judged by what follows it. */
static void late_is_not_silent(void **state)
{
    (void)state;
    look(60, 20);
    for (int i = 0; i < 30; i++) {
        struct trk_sample s = sample_of(TRK_DIRECTION, 20);
        trk_attend(attention, &s, s.arrival_ns + 1000 * MS, &gaze);
        is(TRK_FIXATION, "both eyes");
        trk_attend(attention, NULL, s.arrival_ns + 1074 * MS, &gaze);
        is(TRK_FIXATION, "both eyes");
    }
    trk_attend(attention, NULL, 5000 * MS + now_ns() + 1075 * MS, &gaze);
    is(TRK_LOST, "last gaze");
}

/* When a recording is replayed at a tenth of its pace, its gaze is not lost between samples, and its blinks
 * are not longer: times are judged on the recording's clock. */
static void slow_replay(void **state)
{
    (void)state;
    const uint32_t lids = TRK_LEFT_OPENNESS | TRK_RIGHT_OPENNESS;
    trk_attention_pace(attention, 0.1);
    uint64_t arrival_ns = 0;
    for (int i = 0; i < 180; i++) {
        const bool blinks = i >= 100 && i < 140; /* a third of a second */
        struct trk_sample s = sample_of(blinks ? lids : TRK_DIRECTION, 20);
        s.arrival_ns = arrival_ns = 5000 * MS + 10 * now_ns();
        take(&s);
        trk_attend(attention, NULL, arrival_ns + 50 * MS, &gaze);
        if (blinks || i >= 142)
            is(blinks ? TRK_BLINK : TRK_FIXATION, blinks ? "last gaze" : "both eyes");
        else if (i < 100)
            is(TRK_FIXATION, "both eyes");
        assert_true(gaze.spread == 1);
        aims_at(20, 0.01);
    }
    trk_attend(attention, NULL, arrival_ns + 749 * MS, &gaze);
    is(TRK_FIXATION, "both eyes");
    trk_attend(attention, NULL, arrival_ns + 750 * MS, &gaze);
    is(TRK_LOST, "last gaze");
    trk_attention_pace(attention, 0); /* no pace: no time passes between samples */
    look(3, 20);
    trk_attend(attention, NULL, UINT64_MAX, &gaze);
    is(TRK_FIXATION, "both eyes");
}

/* A tracker that sends nothing has lost the gaze after 75 ms. A pointer that sends nothing rests. */
static void silence(void **state)
{
    (void)state;
    look(60, 20);
    uint64_t last_ns = 5000 * MS + now_ns();
    trk_attend(attention, NULL, last_ns + 74 * MS, &gaze);
    is(TRK_FIXATION, "both eyes");
    trk_attend(attention, NULL, last_ns + 75 * MS, &gaze);
    is(TRK_LOST, "last gaze");
    trk_attend(attention, NULL, last_ns + 1250 * MS, &gaze);
    assert_float_equal(gaze.spread, 2.5, 1e-5);
    trk_attend(attention, NULL, last_ns + 2000 * MS, &gaze);
    is(TRK_FALLBACK, "view centre");

    begin(&(struct trk_attention_options){.silence_is_rest = true});
    trk_attend(attention, NULL, 0, &gaze);
    assert_true(gaze.spread == 1);
    look(1, 20);
    trk_attend(attention, NULL, 3600000 * MS, &gaze);
    is(TRK_FIXATION, "both eyes");
    aims_at(20, 0.01);
    tick += 1000;
    look(1, -30);
    is(TRK_FIXATION, "both eyes");
    aims_at(-30, 0.01);
}

/* The eye reopens while it moves elsewhere: its gaze is not trusted until it rests, or 150 ms have passed. */
static void reopening(void **state)
{
    (void)state;
    look(60, 0);
    hide(15, 0);
    for (int i = 0; i < 10; i++) {
        look(1, 30 - 3 * i);
        is(TRK_BLINK, "last gaze");
        aims_at(0, 0.01);
    }
    look(6, 2);
    is(TRK_FIXATION, "both eyes");
    aims_at(2, 1);
    hide(15, 0);
    for (int i = 0; i < 40; i++) {
        look(1, i % 2 ? 30 : 20); /* never at rest */
        if (i < 18) is(TRK_BLINK, "last gaze");
    }
    assert_true(gaze.state != TRK_BLINK);
}

/* A short gap is bridged. If the eye is elsewhere after it, the aim follows at once. */
static void short_gaps(void **state)
{
    (void)state;
    look(60, 10);
    hide(4, 0);
    is(TRK_FIXATION, "last gaze");
    aims_at(10, 0.01);
    assert_true(gaze.spread == 1);
    look(1, 10);
    is(TRK_FIXATION, "both eyes");
    hide(4, 0);
    look(1, 12.5); /* 60 deg/s: no onset */
    aims_at(12.5, 0.5);
}

/* Another device takes over, and its clock starts at 0. */
static void clock_goes_back(void **state)
{
    (void)state;
    look(600, 10);
    hide(30, 0);
    uint64_t arrival_ns = 5000 * MS + now_ns();
    for (int i = 0; i < 60; i++) {
        struct trk_sample s = sample_of(TRK_DIRECTION, -20);
        s.device_ns = (uint64_t)i * 8333333;
        s.arrival_ns = arrival_ns += 8333333;
        take(&s);
        aims_at(-20, 0.01);
        is(TRK_FIXATION, "both eyes");
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(before_the_first_gaze),
        TEST(holds_widens_gives_up),
        TEST(lids_tell),
        TEST(lids_hold),
        TEST(late_is_not_silent),
        TEST(slow_replay),
        TEST(silence),
        TEST(reopening),
        TEST(short_gaps),
        TEST(clock_goes_back),
    };
    return cmocka_run_group_tests_name("tracker_hold", tests, NULL, NULL);
}
