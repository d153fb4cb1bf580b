/* The classifier, live and over logs, against known movements: some are made here, others are the observer's.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "arc.h"
#include "events.h"
#include "gaze.h"
#include "log/samples.h"
#include "source/observer.h"
#include "tracker_samples.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void at(double azimuth_deg, double elevation_deg, float out[3])
{
    double a = azimuth_deg * M_PI / 180, e = elevation_deg * M_PI / 180;
    out[0] = (float)(sin(a) * cos(e));
    out[1] = (float)sin(e);
    out[2] = (float)(-cos(a) * cos(e));
}

static double noise(unsigned *seed, double deg)
{
    double sum = 0; /* Irwin-Hall distribution, with variance 1 */
    for (int i = 0; i < 12; i++) sum += (double)((*seed = *seed * 1664525 + 1013904223) >> 8) * 0x1p-24;
    return deg * (sum - 6);
}

/* One second of rest, then two seconds in which the eye turns in the head and the head in the world at these
 * speeds. The classifier must never report a saccade, and in the last second it must always report `state`.
 */
static void turning(double eye_deg_s, double head_deg_s, double noise_deg, enum trk_state state)
{
    struct trk_classifier c;
    unsigned seed = 1;
    int same = 0;
    trk_classifier_init(&c);
    for (int k = 0; k < 360; k++) {
        double t_s = k < 120 ? 0 : (k - 120) / 120.0, right = noise(&seed, noise_deg),
               up = noise(&seed, noise_deg);
        float head[3], world[3];
        at(eye_deg_s * t_s + right, up, head);
        at((eye_deg_s + head_deg_s) * t_s + right, up, world);
        trk_classify(&c, (uint64_t)(k * 1e9 / 120), head, world);
        assert_int_not_equal(c.state, TRK_SACCADE);
        if (k >= 240) same += c.state == state;
    }
    assert_int_equal(same, 120);
}

static void head_and_eye(void **state)
{
    (void)state;
    turning(0, 0, 0.15, TRK_FIXATION);
    turning(-100, 100, 0.15, TRK_FIXATION); /* the eye holds its target while the head turns */
    turning(-300, 300, 0, TRK_FIXATION);
    turning(0, 150, 0.15, TRK_PURSUIT); /* the head carries the eye along */
    turning(20, 0, 0.15, TRK_PURSUIT);
    turning(20, 0, 0.3, TRK_PURSUIT);
    turning(30, 0, 0.05, TRK_PURSUIT);
    turning(-10, 40, 0.05, TRK_PURSUIT);
    turning(2, 0, 0.02, TRK_FIXATION); /* drift */
}

/* A saccade on the main sequence that starts and ends at rest, while the head turns, at rates from 60 Hz to 1
 * kHz. */
static void saccades_at_any_rate(void **state)
{
    (void)state;
    static const double rates[] = {60, 90, 120, 250, 500, 1000}, amplitudes[] = {5, 10, 25};
    for (size_t i = 0; i < sizeof rates / sizeof *rates * 3; i++) {
        double rate = rates[i / 3], amplitude = amplitudes[i % 3];
        struct trk_classifier c;
        unsigned seed = 3;
        double onset_s = NAN, end_s = NAN, peak = 0;
        int onsets = 0;
        enum trk_state before = TRK_FIXATION;
        trk_classifier_init(&c);
        for (int k = 0; k < 2 * rate; k++) {
            double t_s = k / rate, gone = t_s < 1 ? 0 : trk_saccade_deg(amplitude, t_s - 1);
            double right = noise(&seed, 0.1), up = noise(&seed, 0.1), turned = 40 * t_s;
            float head[3], world[3];
            at(gone - turned + right, up, head); /* the head turns at 40 deg/s throughout */
            at(gone + right, up, world);
            trk_classify(&c, (uint64_t)(t_s * 1e9), head, world);
            if (c.state == TRK_SACCADE && before != TRK_SACCADE) onsets++, onset_s = t_s;
            if (c.state != TRK_SACCADE && before == TRK_SACCADE) end_s = t_s, peak = c.peak_deg_s;
            before = c.state;
        }
        /* The closed form is slow in its first and last 25 ms: the eye is fast from about 14 ms after its
         * start. */
        double duration_s = trk_saccade_s(amplitude) - 0.05;
        assert_int_equal(onsets, 1);
        assert_true(onset_s > 1.010 && onset_s <= ceil(1.0136 * rate) / rate + fmax(2.01 / rate, 0.019));
        assert_true(end_s > 1.025 + duration_s && end_s < 1.025 + duration_s + fmax(2.01 / rate, 0.02));
        double true_peak = 600 * (1 - exp(-amplitude / 6));
        if (rate >= 120 && rate <= 250) assert_true(fabs(peak - true_peak) < 0.2 * true_peak);
        assert_true(trk_angle_deg(c.from, (float[3]){0, 0, -1}) < 1.2);
    }
}

/* The 33 ms between samples of a webcam at 30 Hz are no gap: jumps between them are saccades. */
static void slow_trackers(void **state)
{
    (void)state;
    struct trk_classifier c;
    int onsets = 0;
    enum trk_state before = TRK_FIXATION;
    trk_classifier_init(&c);
    for (int k = 0; k < 90; k++) {
        float direction[3];
        at(k / 15 * 8, 0, direction);
        trk_classify(&c, (uint64_t)(k * 1e9 / 30), direction, direction);
        onsets += c.state == TRK_SACCADE && before != TRK_SACCADE;
        before = c.state;
    }
    assert_int_equal(onsets, 5);
}

/* At 120 Hz the onset shows within two samples in 95 % of the saccades of least_deg and more, with hardly a
 * false alarm. noise_deg is rms from sample to sample, as precision is usually stated; the standard deviation
 * of each axis is half of it. */
static void onsets_at(double noise_deg, double least_deg, double most_alarms)
{
    enum { TICKS = 10 * 60 * 120 };
    struct trk_observer observer;
    struct trk_classifier c;
    struct trk_truth truth;
    trk_observer_init_with(&observer, 21, 120, noise_deg, 0);
    trk_classifier_init(&c);
    int judged = 0, in_time = 0, alarms = 0, rest = 0;
    uint64_t number = 0;
    int first = -1, hidden = 0;
    bool found = false;
    double end_s = 0, amplitude = 0, noise_sum = 0;
    for (int k = 0; k < TICKS; k++) {
        struct trk_sample sample;
        float head[3], world[3];
        trk_observer_next(&observer, &sample);
        trk_observer_truth(&observer, &truth);
        hidden = truth.is_hidden ? 0 : hidden + 1;
        double t_s = k / 120.0;
        if (truth.is_saccade && truth.saccade_number != number) {
            number = truth.saccade_number;
            first = (int)ceil(truth.onset_s * 120), found = false;
            end_s = truth.end_s, amplitude = hidden > 15 ? truth.amplitude_deg : 0;
        }
        if (truth.is_hidden) amplitude = 0;
        enum trk_state before = c.state;
        if (trk_gaze_direction(&sample, head, NULL)) {
            trk_to_world(&sample, head, world);
            trk_classify(&c, sample.device_ns, head, world);
        }
        bool onset = c.state == TRK_SACCADE && before != TRK_SACCADE;
        bool near = first >= 0 && k >= first - 1 && t_s < end_s + 0.025;
        if (onset && near && k <= first + 2) found = true;
        alarms += onset && !near && hidden > 30;
        if (first >= 0 && k == first + 2)
            judged += amplitude >= least_deg, in_time += amplitude >= least_deg && found;
        rest += !truth.is_hidden;
        noise_sum += c.noise_deg;
    }
    double per_minute = alarms / (rest / 120.0 / 60);
    print_message("%d of %d onsets within 2 samples, %.2f false alarms a minute, noise %.3f degrees\n",
                  in_time, judged, per_minute, noise_sum / TICKS);
    assert_true(judged > 500);
    assert_true(in_time >= 0.95 * judged);
    assert_true(per_minute < most_alarms);
    assert_true(fabs(noise_sum / TICKS - noise_deg / 2) < 0.03 * noise_deg);
}

static void onsets_of_the_observer(void **state)
{
    (void)state;
    onsets_at(0.3, 1, 0.5);
    onsets_at(0.6, 3, 1.5);
}

/* --- logs --- */

static struct trk_log script;

/* Append n samples that move from azimuth a to b (degrees). If `hidden`, they have no gaze. A negative
 * openness leaves the lids unknown. */
static void play(int n, double a, double b, bool hidden, float openness)
{
    static unsigned seed = 5;
    for (int i = 0; i < n; i++) {
        struct trk_sample s = {.sequence = script.count + 1, .device_ns = script.count * 1000000000 / 120};
        s.arrival_ns = s.device_ns;
        if (openness >= 0) {
            s.valid = TRK_LEFT_OPENNESS;
            s.eye[0].openness = openness;
        }
        if (!hidden) s.valid |= TRK_DIRECTION;
        at(a + (b - a) * (i + 1) / n + noise(&seed, 0.05), noise(&seed, 0.05), s.direction);
        assert_true(trk_samples_add(&script, &s));
    }
}

/* Change the time of sample i. */
static void move(size_t i, uint64_t device_ns)
{
    struct trk_sample s = *sample_at(&script, i);
    s.device_ns = device_ns;
    assert_true(trk_samples_put(&script, i, &s));
}

struct expected {
    enum trk_state type;
    double start_s, end_s, amplitude_deg, azimuth_deg;
};

static void finds(const struct expected *expected, size_t count, double tolerance_s)
{
    struct trk_events events;
    assert_true(trk_events_find(&script, &events));
    for (size_t i = 0; i < events.count; i++) {
        const struct trk_event *e = &events.events[i];
        if (i >= count || e->type != expected[i].type ||
            fabs((double)e->start_ns * 1e-9 - expected[i].start_s) > tolerance_s ||
            fabs((double)e->end_ns * 1e-9 - expected[i].end_s) > tolerance_s)
            fail_msg("event %zu is %s from %.3f to %.3f", i, trk_state_name(e->type),
                     (double)e->start_ns * 1e-9, (double)e->end_ns * 1e-9);
        if (e->type <= TRK_SACCADE) {
            float direction[3];
            at(expected[i].azimuth_deg, 0, direction);
            assert_true(trk_angle_deg(direction, e->direction) < 0.3);
            if (e->type == TRK_SACCADE)
                assert_true(fabs(trk_angle_deg(e[-1].direction, e->direction) - expected[i].amplitude_deg) <
                            0.3);
        }
        assert_true(e->first <= e->last && e->last < script.count);
        if (i) assert_true(e->start_ns >= e[-1].end_ns);
    }
    assert_int_equal(events.count, count);
    size_t sum = 0;
    for (int i = 0; i <= TRK_LOST; i++) sum += events.counts[i];
    assert_int_equal(sum, count);
    assert_true(events.noise_deg < 0.2);
    trk_events_finish(&events);
    trk_log_finish(&script);
}

static void events_of_a_log(void **state)
{
    (void)state;
    play(60, 0, 0, false, -1);   /* 0.5 s of fixation */
    play(4, 0, 10, false, -1);   /* a saccade, 10 degrees in 33 ms */
    play(56, 10, 10, false, -1); /* until 1.0 s */
    play(24, 0, 0, true, -1);    /* nothing for 0.2 s */
    play(60, 10, 10, false, -1); /* until 1.7 s */
    play(6, 0, 0, true, -1);     /* a drop-out of 50 ms */
    play(54, 10, 10, false, -1); /* until 2.2 s */
    play(120, 0, 0, true, -1);   /* a loss until 3.2 s */
    play(36, 0, 0, false, -1);   /* until 3.5 s */
    static const struct expected expected[] = {
        {TRK_FIXATION, 0, 0.5, 0, 0},        {TRK_SACCADE, 0.5, 0.533, 10, 10},
        {TRK_FIXATION, 0.533, 0.925, 0, 10}, {TRK_BLINK, 0.925, 1.35, 0, 0},
        {TRK_FIXATION, 1.35, 2.2, 0, 10},    {TRK_LOST, 2.2, 3.2, 0, 0},
        {TRK_FIXATION, 3.2, 3.5, 0, 0},
    };
    finds(expected, sizeof expected / sizeof *expected, 0.0127); /* 1.5 samples */
}

/* The lids tell a blink from a loss. When the tracker sends nothing, that is a loss without samples. */
static void lids_and_silence(void **state)
{
    (void)state;
    play(60, 0, 0, false, 1);   /* until 0.5 s */
    play(6, 0, 0, true, 0.1f);  /* 50 ms with the lids down */
    play(54, 0, 0, false, 1);   /* until 1.0 s */
    play(24, 0, 0, true, 0.9f); /* lids up, but no gaze, until 1.2 s */
    play(60, 0, 0, false, 1);   /* until 1.7 s */
    play(60, 0, 0, false, 1);
    for (size_t i = 204; i < script.count; i++)
        move(i, trk_log_time(&script, i) + 500000000); /* no samples until 2.2 s */
    static const struct expected expected[] = {
        {TRK_FIXATION, 0, 0.425, 0, 0}, {TRK_BLINK, 0.425, 0.7, 0, 0},  {TRK_FIXATION, 0.7, 1.0, 0, 0},
        {TRK_LOST, 1.0, 1.2, 0, 0},     {TRK_FIXATION, 1.2, 1.7, 0, 0}, {TRK_LOST, 1.7, 2.2, 0, 0},
        {TRK_FIXATION, 2.2, 2.7, 0, 0},
    };
    finds(expected, sizeof expected / sizeof *expected, 0.0127);
}

/* A device goes on reporting an eye that is under its lid: that is a blink all the same. */
static void seen_under_the_lid(void **state)
{
    (void)state;
    play(60, 0, 0, false, 1);     /* until 0.5 s */
    play(24, 0, 15, false, 0.1f); /* gaze rolls away, until 0.7 s */
    play(60, 0, 0, false, 1);     /* until 1.2 s */
    static const struct expected expected[] = {
        {TRK_FIXATION, 0, 0.425, 0, 0}, {TRK_BLINK, 0.425, 0.85, 0, 0}, {TRK_FIXATION, 0.85, 1.2, 0, 0}};
    finds(expected, sizeof expected / sizeof *expected, 0.0127);
}

/* When one eye is under its lid, the combined gaze is that of the open eye. */
static void winks(void **state)
{
    (void)state;
    for (int left = 0; left < 2; left++) {
        struct trk_sample s = {.valid = TRK_LEFT_DIRECTION | TRK_RIGHT_DIRECTION | TRK_LEFT_OPENNESS |
                                        TRK_RIGHT_OPENNESS};
        float open[3];
        at(10, 0, open);
        at(10, 0, s.eye[!left].direction);
        at(10, 20, s.eye[left].direction);
        s.eye[!left].openness = 0.9f;
        s.eye[left].openness = 0.2f;
        trk_combine(&s);
        assert_true((s.valid & TRK_DIRECTION) && trk_angle_deg(open, s.direction) < 0.01f);
    }
}

/* After a short gap the eye is elsewhere: that is a saccade in the gap, even though the distance is too small
 * for an onset. */
static void jump_in_a_gap(void **state)
{
    (void)state;
    play(60, 0, 0, false, -1);
    play(6, 0, 0, true, -1); /* 3.6 degrees in 58 ms are 62 deg/s */
    play(54, 3.6, 3.6, false, -1);
    static const struct expected expected[] = {{TRK_FIXATION, 0, 0.5, 0, 0},
                                               {TRK_SACCADE, 0.5, 0.55, 3.6, 3.6},
                                               {TRK_FIXATION, 0.55, 0.992, 0, 3.6}};
    finds(expected, sizeof expected / sizeof *expected, 0.001);
}

static void nothing_and_little(void **state)
{
    (void)state;
    struct trk_events events;
    assert_true(trk_events_find(&script, &events)); /* no samples */
    assert_int_equal(events.count, 0);
    trk_events_finish(&events);
    play(1, 0, 0, false, -1);
    assert_true(trk_events_find(&script, &events)); /* too short to be a fixation */
    assert_int_equal(events.count, 0);
    trk_events_finish(&events);
    trk_log_finish(&script);
    play(40, 0, 0, true, -1);
    assert_true(trk_events_find(&script, &events));
    assert_int_equal(events.count, 1);
    assert_int_equal(events.counts[TRK_BLINK], 1);
    trk_events_finish(&events);
    trk_log_finish(&script);
    play(60, 0, 0, false, -1);
    for (size_t i = 0; i < script.count; i++) move(i, 7); /* time stands still */
    assert_true(trk_events_find(&script, &events));
    trk_events_finish(&events);
    trk_log_finish(&script);
}

/* Half an hour of the observer with its usual noise: the events agree with the true ones in number, size and
 * time. */
static void events_of_the_observer(void **state)
{
    (void)state;
    enum { TICKS = 30 * 60 * 120 };
    struct trk_log log;
    struct trk_events events;
    struct trk_observer observer;
    assert_true(trk_synthesise(31, TICKS / 120, &log));
    assert_true(trk_events_find(&log, &events));
    trk_observer_init(&observer, 31);
    size_t next = 0, true_count = 0, found = 0, blinks = 0;
    double amplitude_error = 0, start_s = 0, end_s = 0;
    uint64_t number = 0;
    int seen = 0;
    bool was_blink = false;
    for (int k = 0; k < TICKS; k++) {
        struct trk_sample sample;
        struct trk_truth truth;
        trk_observer_next(&observer, &sample);
        trk_observer_truth(&observer, &truth);
        seen = truth.is_hidden ? 0 : seen + 1;
        blinks += truth.is_blink && !was_blink;
        was_blink = truth.is_blink;
        if (!truth.is_saccade || truth.saccade_number == number) continue;
        number = truth.saccade_number;
        if (seen < 60 || truth.amplitude_deg < 3) continue;
        uint64_t middle_ns = (uint64_t)((truth.onset_s + truth.end_s) * 0.5e9);
        while (next < events.count && events.events[next].end_ns < middle_ns + 9000000) next++;
        if (next == events.count) break;
        const struct trk_event *e = &events.events[next];
        if (e->type == TRK_BLINK || e->type == TRK_LOST) continue; /* the eye was hidden meanwhile */
        true_count++;
        if (e->type != TRK_SACCADE || e->start_ns > middle_ns + 12000000) continue;
        found++;
        start_s += (double)e->start_ns * 1e-9 - truth.onset_s;
        end_s += (double)e->end_ns * 1e-9 - truth.end_s;
        amplitude_error += fabs(trk_angle_deg(e[-1].direction, e->direction) - truth.amplitude_deg);
    }
    print_message("%zu of %zu saccades, off by %.2f degrees; %zu blinks of %zu; %zu "
                  "fixations, %zu losses, %zu pursuits\n",
                  found, true_count, amplitude_error / (double)found, events.counts[TRK_BLINK], blinks,
                  events.counts[TRK_FIXATION], events.counts[TRK_LOST], events.counts[TRK_PURSUIT]);
    print_message("starts %.1f ms and ends %.1f ms after the true one\n", start_s / (double)found * 1000,
                  end_s / (double)found * 1000);
    assert_true(fabs(start_s / (double)found) < 0.0085 && fabs(end_s / (double)found) < 0.006);
    assert_true(true_count > 2000);
    assert_true((double)found > 0.97 * (double)true_count);
    assert_true(amplitude_error / (double)found < 0.5);
    assert_true(fabs((double)events.counts[TRK_BLINK] - (double)blinks) <= 0.03 * (double)blinks);
    trk_events_finish(&events);
    trk_log_finish(&log);
}

/* Saccades of a real eye tracker against those that its own parser wrote into the log (of one degree and
 * more). Amplitudes may differ, because the parser knew the screen and the reader assumes a usual one. */
static void events_of_an_eyelink(void **state)
{
    (void)state;
    static const char path[] = SHARED_DATA "/gaze/eyelink-asc/mono250.asc";
    char error[TRK_ERROR_SIZE], line[512];
    struct trk_log log;
    struct trk_events events;
    FILE *file = fopen(path, "r");
    if (!file) {
        print_message("no ../shared/data\n");
        skip();
    }
    if (!trk_log_read(path, &log, error)) fail_msg("%s", error);
    assert_true(trk_events_find(&log, &events));
    double first_ms = NAN;
    size_t next = 0, matched = 0;
    while (fgets(line, sizeof line, file)) {
        double start_ms, end_ms, amplitude_deg;
        if (isnan(first_ms) && line[0] >= '0' && line[0] <= '9') first_ms = atof(line);
        if (sscanf(line, "ESACC %*s %lf %lf %*f %*f %*f %*f %*f %lf", &start_ms, &end_ms, &amplitude_deg) !=
                3 ||
            amplitude_deg < 1)
            continue;
        while (next < events.count && events.events[next].type != TRK_SACCADE) next++;
        assert_true(next < events.count);
        const struct trk_event *e = &events.events[next++];
        assert_true(fabs((double)e->start_ns * 1e-6 - (start_ms - first_ms)) <= 20);
        assert_true(fabs((double)e->end_ns * 1e-6 - (end_ms - first_ms)) <= 20);
        assert_true(fabs(trk_angle_deg(e[-1].direction, e->direction) - amplitude_deg) <
                    0.15 * amplitude_deg);
        matched++;
    }
    fclose(file);
    assert_int_equal(matched, 4);
    assert_int_equal(events.counts[TRK_SACCADE], matched);
    trk_events_finish(&events);
    trk_log_finish(&log);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(head_and_eye),           cmocka_unit_test(saccades_at_any_rate),
        cmocka_unit_test(slow_trackers),          cmocka_unit_test(onsets_of_the_observer),
        cmocka_unit_test(events_of_a_log),        cmocka_unit_test(lids_and_silence),
        cmocka_unit_test(seen_under_the_lid),     cmocka_unit_test(winks),
        cmocka_unit_test(jump_in_a_gap),          cmocka_unit_test(nothing_and_little),
        cmocka_unit_test(events_of_the_observer), cmocka_unit_test(events_of_an_eyelink),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
