/* What to render for: held, widened, given up, filtered, frozen, recentred; sample by sample. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "arc.h"
#include "events.h"
#include "source/observer.h"
#include "tracker_samples.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define MS UINT64_C(1000000)

static void at(double azimuth_deg, double elevation_deg, float out[3])
{
    double a = azimuth_deg * M_PI / 180, e = elevation_deg * M_PI / 180;
    out[0] = (float)(sin(a) * cos(e));
    out[1] = (float)sin(e);
    out[2] = (float)(-cos(a) * cos(e));
}

static struct trk_attention *attention;
static struct trk_gaze gaze;
static uint64_t tick; /* samples of 120 Hz so far */

static void begin(const struct trk_attention_options *options)
{
    trk_attention_destroy(attention);
    attention = trk_attention_create(options);
    assert_non_null(attention);
    tick = 0;
}

static int enter(void **state)
{
    (void)state;
    begin(&(struct trk_attention_options){0});
    return 0;
}

static int leave(void **state)
{
    (void)state;
    trk_attention_destroy(attention);
    attention = NULL;
    return 0;
}

static uint64_t now_ns(void)
{
    return tick * 1000000000 / 120;
}

static struct trk_sample sample_of(uint32_t valid, double azimuth_deg)
{
    struct trk_sample s = {.sequence = ++tick, .valid = valid};
    s.device_ns = now_ns();
    s.arrival_ns = 5000 * MS + now_ns();
    at(azimuth_deg, 0, s.direction);
    at(azimuth_deg, 0, s.eye[0].direction);
    at(azimuth_deg, 0, s.eye[1].direction);
    s.eye[0].openness = s.eye[1].openness = valid & TRK_DIRECTION ? 1 : 0.1f;
    return s;
}

static void turn_head(struct trk_sample *sample, double azimuth_deg)
{
    versor head; /* aligned, as cglm wants it */
    glm_quatv(head, (float)(-azimuth_deg * M_PI / 180), GLM_YUP);
    memcpy(&sample->head[3], head, sizeof head);
}

static void take(const struct trk_sample *sample)
{
    trk_attend(attention, sample, sample->arrival_ns, &gaze);
}

/* n samples at this azimuth. */
static void look(int n, double azimuth_deg)
{
    for (int i = 0; i < n; i++) {
        struct trk_sample s = sample_of(TRK_DIRECTION, azimuth_deg);
        take(&s);
    }
}

static void hide(int n, uint32_t valid)
{
    for (int i = 0; i < n; i++) {
        struct trk_sample s = sample_of(valid, 0);
        take(&s);
    }
}

static void aims_at(double azimuth_deg, double tolerance_deg)
{
    float direction[3];
    at(azimuth_deg, 0, direction);
    if (!(trk_angle_deg(direction, gaze.direction) <= tolerance_deg))
        fail_msg("%.2f degrees from %.2f (%s: %s)", trk_angle_deg(direction, gaze.direction), azimuth_deg,
                 trk_state_name(gaze.state), gaze.why);
}

static void is(enum trk_state state, const char *source)
{
    if (gaze.state != state || strcmp(gaze.source, source) != 0)
        fail_msg("%s from %s (%s), expected %s from %s", trk_state_name(gaze.state), gaze.source, gaze.why,
                 trk_state_name(state), source);
}

static void before_the_first_gaze(void **state)
{
    (void)state;
    trk_attend(attention, NULL, 0, &gaze);
    is(TRK_FALLBACK, "view centre");
    aims_at(0, 1e-3);
    assert_true(gaze.spread == 4 && gaze.sequence == 0);
    versor view;
    glm_quatv(view, (float)(-M_PI / 2), GLM_YUP); /* to the right */
    trk_attention_view(attention, view);
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

/* The times: held for 500 ms, four times wider at 2 s and then at the view's centre; a known lid is a blink.
 */
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
    look(1, 20); /* seen again, and not yet believed */
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
        s.eye[1].openness = 0.8f; /* one eye open, and not seen */
        take(&s);
    }
    is(TRK_LOST, "last gaze");
}

/* A device that goes on reporting the eye as it rolls under its lid moves no aim. Nor does one lid that is
 * down, where the other eye is seen. */
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
    for (int i = 0; i < 30; i++) { /* of the eye that is seen, the lid is not told */
        struct trk_sample s = sample_of(TRK_LEFT_OPENNESS | TRK_RIGHT_DIRECTION, 20);
        take(&s);
    }
    is(TRK_FIXATION, "right eye");
}

/* A sample that is taken late says where gaze is all the same; only what follows can be silence. */
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

/* A recording that is replayed at a tenth of its pace is not lost between its samples, and a blink in it is
 * no longer than it was: all is judged on the recording's clock. */
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
    trk_attention_pace(attention, 0); /* as fast as it is read: no time passes in between */
    look(3, 20);
    trk_attend(attention, NULL, UINT64_MAX, &gaze);
    is(TRK_FIXATION, "both eyes");
}

/* A tracker that says nothing at all is lost after 75 ms; a pointer that says nothing rests. */
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

static void one_eye_is_enough(void **state)
{
    (void)state;
    for (int i = 0; i < 30; i++) {
        struct trk_sample s = sample_of(TRK_LEFT_DIRECTION, 10);
        at(90, 0, s.eye[1].direction); /* not valid */
        take(&s);
    }
    is(TRK_FIXATION, "left eye");
    aims_at(10, 0.01);
    for (int i = 0; i < 30; i++) {
        struct trk_sample s = sample_of(TRK_RIGHT_DIRECTION, 10);
        at(90, 0, s.eye[0].direction);
        take(&s);
    }
    is(TRK_FIXATION, "right eye");
    aims_at(10, 0.01);
    for (int i = 0; i < 30; i++) {
        struct trk_sample s = sample_of(TRK_LEFT_DIRECTION | TRK_RIGHT_DIRECTION, 0);
        at(9, 0, s.eye[0].direction);
        at(11, 0, s.eye[1].direction);
        take(&s);
    }
    is(TRK_FIXATION, "both eyes");
    aims_at(10, 0.01);
}

/* A shift of less than a degree is none; a larger one moves the aim at once when it is a saccade. */
static void dead_zone(void **state)
{
    (void)state;
    look(60, 0);
    look(120, 0.8);
    aims_at(0, 0.01);
    assert_false(gaze.moved);
    look(240, 1.6); /* too small a step for an onset: the filter goes there */
    assert_true(gaze.direction[0] > sin(0.8 * M_PI / 180));
    look(1, 12);
    aims_at(12, 0.01);
    is(TRK_SACCADE, "both eyes");
    look(30, 12);
    is(TRK_FIXATION, "both eyes");
    aims_at(12, 0.01);
    begin(&(struct trk_attention_options){.raw = true});
    look(60, 0);
    look(1, 0.5);
    aims_at(0.5, 0.001);
}

/* At 20 deg/s, 100 ms with 3.6 Hz of cut-off: the aim lags and follows, outside any dead zone. */
static void pursuit(void **state)
{
    (void)state;
    look(60, 0);
    for (int i = 0; i < 120; i++) {
        double azimuth = i / 6.0;
        look(1, azimuth);
        assert_int_not_equal(gaze.state, TRK_SACCADE);
        if (i < 60) continue;
        is(TRK_PURSUIT, "both eyes");
        assert_true(gaze.moved);
        aims_at(azimuth - 0.8, 0.3);
    }
}

/* The eye reopens on its way elsewhere: nothing is believed until it rests, or 150 ms have passed. */
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

/* A short gap is bridged, and an eye that is elsewhere after it is followed at once. */
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

static void freezing(void **state)
{
    (void)state;
    look(60, 10);
    trk_attention_freeze(attention, true);
    look(60, -40);
    is(TRK_FROZEN, "last gaze");
    aims_at(10, 0.01);
    assert_false(gaze.moved);
    assert_int_equal(gaze.sequence, 120);
    hide(600, 0);
    is(TRK_FROZEN, "last gaze");
    assert_true(gaze.spread == 1);
    look(60, -40);
    trk_attention_freeze(attention, false);
    trk_attend(attention, NULL, 5000 * MS + now_ns(), &gaze);
    is(TRK_FIXATION, "both eyes");
    aims_at(-40, 0.01);
    assert_true(gaze.moved);
}

/* Another device, whose clock starts again. */
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

/* Eyes on a still target while the head turns at 60 deg/s: filtered in the world, the aim does not move. */
static void head_turns(void **state)
{
    (void)state;
    for (int i = 0; i < 240; i++) {
        double turned = i < 60 ? 0 : (i - 60) * 0.5;
        struct trk_sample s = sample_of(TRK_DIRECTION | TRK_HEAD, 30 - turned);
        turn_head(&s, turned);
        take(&s);
        is(TRK_FIXATION, "both eyes");
        aims_at(30, 0.02);
    }
    for (int i = 0; i < 400; i++) {
        struct trk_sample s = sample_of(TRK_HEAD, 0);
        turn_head(&s, 50);
        take(&s);
    }
    is(TRK_FALLBACK, "view centre");
    aims_at(50, 0.01);
}

/* Without noise prediction is never worse than to follow, and takes two fifths of what is left in mid-flight.
 */
static void prediction(void **state)
{
    (void)state;
    static const double amplitudes[] = {5, 8, 10, 13};
    for (size_t k = 0; k < sizeof amplitudes / sizeof *amplitudes; k++) {
        begin(&(struct trk_attention_options){.predict = true});
        look(60, 0);
        double best = 1;
        for (int i = 0; i < 12; i++) {
            double azimuth = trk_saccade_deg(amplitudes[k], (i + 1) / 120.0), left = amplitudes[k] - azimuth;
            look(1, azimuth);
            if (gaze.state != TRK_SACCADE) continue;
            is(TRK_SACCADE, "prediction");
            float landing[3];
            at(amplitudes[k], 0, landing);
            double error = trk_angle_deg(landing, gaze.direction);
            assert_true(error < left + 0.1);
            if (left > 1) best = fmin(best, error / left);
        }
        assert_true(best < 0.6);
        aims_at(amplitudes[k], 0.1);
    }
}

/* The same calls give the same answers, to the bit. */
static void repeats_itself(void **state)
{
    (void)state;
    struct trk_log log;
    assert_true(trk_synthesise(3, 60, &log));
    struct trk_gaze *first = calloc(log.count, sizeof *first);
    assert_non_null(first);
    for (int pass = 0; pass < 2; pass++) {
        begin(&(struct trk_attention_options){.predict = true});
        for (size_t i = 0; i < log.count; i++) {
            memset(&gaze, 0, sizeof gaze);
            trk_attend(attention, sample_at(&log, i), sample_at(&log, i)->arrival_ns, &gaze);
            if (pass == 0)
                first[i] = gaze;
            else
                assert_memory_equal(&gaze, &first[i], sizeof gaze);
            assert_float_equal(glm_vec3_norm(gaze.direction), 1, 1e-5);
        }
    }
    free(first);
    trk_log_finish(&log);
}

/* Whatever the bytes of a sample are, the answer is a direction. */
static void anything(void **state)
{
    (void)state;
    uint64_t seed = 1, arrival_ns = 0;
    for (int i = 0; i < 200000; i++) {
        struct trk_sample s;
        unsigned char bytes[sizeof s];
        for (size_t k = 0; k < sizeof bytes; k++)
            bytes[k] = (unsigned char)((seed = seed * 6364136223846793005 + 1442695040888963407) >> 56);
        memcpy(&s, bytes, sizeof s);
        if (i % 2) s.device_ns = (uint64_t)i * 8333333; /* else time leaps */
        if (i % 3) at((double)(seed >> 40) / 1e5, 20, s.direction);
        if (i % 5) s.head[3] = s.head[4] = s.head[5] = 0, s.head[6] = 1;
        s.arrival_ns = arrival_ns += seed >> 38;
        take(&s);
        assert_float_equal(glm_vec3_norm(gaze.direction), 1, 1e-4);
        assert_true(gaze.spread >= 1 && gaze.spread <= 4 && gaze.noise_deg > 0 && gaze.noise_deg < 180);
        assert_non_null(gaze.why);
        assert_non_null(gaze.source);
    }
}

/* --- recentring ----------------------------------------------------------------------------------------- */

static void recentring(void **state)
{
    (void)state;
    char error[TRK_ERROR_SIZE] = "";
    float rotation[4], target[3];
    assert_false(trk_recentre(attention, NULL, error));
    assert_non_null(strstr(error, "expected a look at the target"));
    look(60, 6);
    assert_true(trk_recentre(attention, NULL, error)); /* looks straight on, says the user */
    look(60, 6);
    aims_at(0, 0.01);
    look(60, 26);
    aims_at(20, 0.01);
    at(23, 0, target);
    assert_true(trk_recentre(attention, target, error)); /* replaces: 26 measured is 23 */
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

/* In the head frame: the slip of a headset turns with the head. */
static void recentring_turns_with_the_head(void **state)
{
    (void)state;
    char error[TRK_ERROR_SIZE] = "";
    for (int turn = 0; turn < 2; turn++)
        for (int i = 0; i < 60; i++) {
            struct trk_sample s = sample_of(TRK_DIRECTION | TRK_HEAD, 0);
            at(0, 5, s.direction); /* five degrees too high */
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
#define TEST(f) cmocka_unit_test_setup_teardown(f, enter, leave)
    const struct CMUnitTest tests[] = {
        TEST(before_the_first_gaze),
        TEST(holds_widens_gives_up),
        TEST(lids_tell),
        TEST(lids_hold),
        TEST(late_is_not_silent),
        TEST(slow_replay),
        TEST(silence),
        TEST(one_eye_is_enough),
        TEST(dead_zone),
        TEST(pursuit),
        TEST(reopening),
        TEST(short_gaps),
        TEST(freezing),
        TEST(clock_goes_back),
        TEST(head_turns),
        TEST(prediction),
        TEST(repeats_itself),
        TEST(anything),
        TEST(recentring),
        TEST(recentring_turns_with_the_head),
        TEST(recentre_file),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
