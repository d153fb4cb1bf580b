/* Logs of HTC headsets: real recordings where they are present, and small logs made here for cases that no
 * recording has. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "tracker.h"
#include "tracker_samples.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#define RECORDINGS SHARED_DATA "/gaze/htc-vive-pro-eye/"

static void read_or_skip(const char *path, struct trk_log *out_log)
{
    char error[TRK_ERROR_SIZE] = "";
    if (access(path, R_OK) != 0) {
        print_message("no %s here\n", path);
        skip();
    }
    if (!trk_log_read(path, out_log, error)) fail_msg("%s", error);
    assert_string_equal(out_log->format, "HTC SRanipal");
}

static double yaw_deg(const float v[3])
{
    return atan2(v[0], -v[2]) * 180 / M_PI;
}

/* Over steps of 50 ms without a saccade: the slope of the eye's yaw in the head against the head's yaw, and
 * the median angle that gaze moves in the world. If the eye holds a target while the head turns, the slope is
 * -1 and the angle is small. */
static void measure_reflex(const struct trk_log *log, double *out_slope, double *out_world_deg)
{
    enum { STEP = 6, BINS = 1000 };
    double sum_hh = 0, sum_he = 0;
    int bins[BINS] = {0}, count = 0;
    for (size_t i = STEP; i < log->count; i++) {
        const struct trk_sample *a = sample_at(log, i - STEP), *b = sample_at(log, i);
        struct trk_sample ahead_a = *a, ahead_b = *b;
        float world_a[3], world_b[3], head_a[3], head_b[3];
        if (!trk_world_direction(a, world_a) || !trk_world_direction(b, world_b)) continue;
        memcpy(ahead_a.direction, (float[3]){0, 0, -1}, sizeof ahead_a.direction);
        memcpy(ahead_b.direction, (float[3]){0, 0, -1}, sizeof ahead_b.direction);
        trk_world_direction(&ahead_a, head_a);
        trk_world_direction(&ahead_b, head_b);
        double dot = world_a[0] * world_b[0] + world_a[1] * world_b[1] + world_a[2] * world_b[2];
        int bin = (int)(acos(fmin(1, dot)) * 180 / M_PI * 100);
        bins[bin < BINS ? bin : BINS - 1]++;
        count++;
        double head = remainder(yaw_deg(head_b) - yaw_deg(head_a), 360);
        double eye = yaw_deg(b->direction) - yaw_deg(a->direction);
        if (fabs(head) < 1 || fabs(eye) > 5) continue;
        sum_hh += head * head;
        sum_he += head * eye;
    }
    int median = 0;
    for (int below = bins[0]; below < count / 2;) below += bins[++median];
    *out_slope = sum_he / sum_hh;
    *out_world_deg = median / 100.0;
}

static void real_recording(const char *path, size_t rows, size_t valid, double seconds)
{
    struct trk_log log;
    read_or_skip(path, &log);
    assert_int_equal(log.count, rows);
    size_t directions = 0;
    for (size_t i = 0; i < log.count; i++) {
        const struct trk_sample *sample = sample_at(&log, i);
        directions += (sample->valid & TRK_DIRECTION) != 0;
        assert_true(sample->valid & TRK_HEAD);
        if (sample->valid & TRK_LEFT_ORIGIN) assert_true(sample->eye[0].origin[0] < -0.02f);
        if (sample->valid & TRK_RIGHT_ORIGIN) assert_true(sample->eye[1].origin[0] > 0.02f);
        if (sample->valid & TRK_DIRECTION) assert_true(sample->direction[2] < -0.5f);
    }
    assert_int_equal(directions, valid);
    const struct trk_sample *last = sample_at(&log, log.count - 1);
    assert_int_equal(sample_at(&log, 0)->device_ns, 0);
    assert_float_equal((double)last->device_ns / 1e9, seconds, 1e-9);
    assert_float_equal((double)last->arrival_ns / 1e9, seconds, 0.005);
    assert_float_equal((double)(log.count - 1) / seconds, 120, 0.1);
    double slope, world_deg;
    measure_reflex(&log, &slope, &world_deg);
    print_message("%s: eye against head %.2f, gaze moves %.2f degrees in 50 ms (median)\n", path, slope,
                  world_deg);
    assert_true(slope < -0.5);
    assert_true(world_deg < 0.6);
    trk_log_finish(&log);
}

static void first_recording(void **state)
{
    (void)state;
    real_recording(RECORDINGS "TESTNA01_360VR_Fist3.csv", 1665, 1633, 13.864);
}

/* In this recording one frame was fetched twice and another one lost. */
static void second_recording(void **state)
{
    (void)state;
    real_recording(RECORDINGS "TESTNA05_360VR_Spread7.csv", 1337, 1288, 11.131);
}

static void recording_without_rows(void **state)
{
    (void)state;
    const char *path = RECORDINGS "TESTVA03_2D_Spread9.csv";
    char error[TRK_ERROR_SIZE] = "";
    struct trk_log log;
    if (access(path, R_OK) != 0) {
        print_message("no %s here\n", path);
        skip();
    }
    assert_false(trk_log_read(path, &log, error));
    assert_non_null(strstr(error, "holds no samples"));
}

#define HEADER                                                                                               \
    "time(100ns);time_stamp(ms);frame;eye_valid_L;eye_valid_R;openness_L;openness_R;pupil_diameter_L(mm);"   \
    "pupil_diameter_R(mm);gaze_origin_L.x(mm);gaze_origin_L.y(mm);gaze_origin_L.z(mm);gaze_origin_R.x(mm);"  \
    "gaze_origin_R.y(mm);gaze_origin_R.z(mm);gaze_direct_L.x;gaze_direct_L.y;gaze_direct_L.z;"               \
    "gaze_direct_R.x;gaze_direct_R.y;gaze_direct_R.z;distance_valid_C;helmet_pos_x;helmet_pos_y;"            \
    "helmet_pos_z;helmet_rot_x;helmet_rot_y;helmet_rot_z\r\n"
#define EYES(l, r)     l ";" r ";1;0.5;3;4;30;1;-2;-34;3;-2;"
#define GAZE_AHEAD     "0;0;1;0;0;1;False;"
#define HEAD_AHEAD     "1;2;3;0;0;0\r\n"
#define ROW(t, ms, fr) t ";" ms ";" fr ";" EYES("31", "31") GAZE_AHEAD HEAD_AHEAD

static const char *path = "tracker_sranipal.csv";

static bool read_text(const char *text, struct trk_log *out_log, char error[TRK_ERROR_SIZE])
{
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    fputs(text, file);
    fclose(file);
    bool ok = trk_log_read(path, out_log, error);
    unlink(path);
    return ok;
}

static void accepted(const char *text, struct trk_log *out_log)
{
    char error[TRK_ERROR_SIZE] = "";
    if (!read_text(text, out_log, error)) fail_msg("%s", error);
}

static void refused(const char *text, const char *where, const char *why)
{
    char error[TRK_ERROR_SIZE] = "", start[64];
    struct trk_log log;
    assert_false(read_text(text, &log, error));
    assert_null(log.samples);
    snprintf(start, sizeof start, "%s%s", path, where);
    if (strncmp(error, start, strlen(start)) != 0 || !strstr(error, why) || !strstr(error, "expected"))
        fail_msg("'%s' should start with '%s', say '%s' and what was expected", error, start, why);
}

static void assert_vector(const float *v, double x, double y, double z)
{
    assert_float_equal(v[0], x, 1e-6);
    assert_float_equal(v[1], y, 1e-6);
    assert_float_equal(v[2], z, 1e-6);
}

/* In SRanipal's frame +X is left and +Z is forward; in ours +X is right and -Z is forward. */
static void frames_and_units(void **state)
{
    (void)state;
    struct trk_log log;
    float world[3];
    accepted(HEADER
             "7;1;1;" EYES("31", "31") "0.6;0;0.8;0.6;0;0.8;False;" HEAD_AHEAD
                                       "8;2;1;" EYES("31", "31") "0;0.6;0.8;0;0.6;0.8;False;1;2;3;0;90;0\r\n"
                                                                 "9;3;1;" EYES("31", "31") GAZE_AHEAD
             "1;2;3;30;0;0\r\n"
             "10;4;1;" EYES("31", "31") "0;0.6;0.8;0;0.6;0.8;False;1;2;3;0;0;90\r\n"
                                        "11;5;1;" EYES("31", "31") GAZE_AHEAD "1;2;3;30;90;45\r\n",
             &log);
    assert_vector(sample_at(&log, 0)->direction, -0.6, 0, -0.8);
    assert_vector(sample_at(&log, 0)->eye[0].origin, -0.030, 0.001, 0.002);
    assert_vector(sample_at(&log, 0)->eye[1].origin, 0.034, 0.003, 0.002);
    assert_vector(sample_at(&log, 0)->origin, 0.002, 0.002, 0.002);
    assert_vector(sample_at(&log, 0)->head, 1, 2, -3);
    assert_float_equal(sample_at(&log, 0)->eye[1].openness, 0.5, 0);
    assert_float_equal(sample_at(&log, 0)->eye[1].pupil_mm, 4, 0);
    assert_int_equal(sample_at(&log, 0)->valid, 0xff7);
    /* In Unity a positive angle about Y turns to the right, about X down, and about Z tilts the head to the
     * left. */
    assert_true(trk_world_direction(sample_at(&log, 1), world));
    assert_vector(world, 0.8, 0.6, 0);
    assert_true(trk_world_direction(sample_at(&log, 2), world));
    assert_vector(world, 0, -0.5, -cos(M_PI / 6));
    assert_true(trk_world_direction(sample_at(&log, 3), world));
    assert_vector(world, -0.6, 0, -0.8);
    /* Unity rolls first, which does not change a gaze straight ahead, then turns down, then to the right. */
    assert_true(trk_world_direction(sample_at(&log, 4), world));
    assert_vector(world, cos(M_PI / 6), -0.5, 0);
    trk_log_finish(&log);
}

static void validity(void **state)
{
    (void)state;
    struct trk_log log;
    accepted(
        HEADER "12;6;1;" EYES(
            "31",
            "25") "0.6;0;0.8;0;0;0;False;" HEAD_AHEAD /* one eye is enough */
                  "13;7;2;" EYES(
                      "8",
                      "0") "0;0;0;0;0;0;False;" HEAD_AHEAD /* a blink */
                           "14;8;3;" EYES(
                               "31",
                               "31") "0;0;0;0;0;0;False;" HEAD_AHEAD /* lost, whatever the mask says */
                                     "15;9;4;" EYES(
                                         "31",
                                         "29") "0;0;1;NaN;;x;False;" HEAD_AHEAD, /* not valid, not read */
        &log);
    assert_int_equal(sample_at(&log, 0)->valid & (TRK_DIRECTION | TRK_LEFT_DIRECTION | TRK_RIGHT_DIRECTION),
                     TRK_DIRECTION | TRK_LEFT_DIRECTION);
    assert_true(sample_at(&log, 0)->valid & TRK_RIGHT_OPENNESS);
    assert_false(sample_at(&log, 0)->valid & TRK_RIGHT_PUPIL);
    assert_vector(sample_at(&log, 0)->direction, -0.6, 0, -0.8);
    assert_int_equal(sample_at(&log, 1)->valid, TRK_HEAD | TRK_LEFT_OPENNESS);
    assert_false(sample_at(&log, 2)->valid & (TRK_DIRECTION | TRK_LEFT_DIRECTION | TRK_RIGHT_DIRECTION));
    assert_vector(sample_at(&log, 3)->direction, 0, 0, -1);
    trk_log_finish(&log);
}

static void clocks(void **state)
{
    (void)state;
    struct trk_log log;
    accepted(HEADER ROW("638342802882596202", "2147483640", "5") ROW("638342802882596302", "-2147483640", "6")
                 ROW("638342802882596302", "-2147483640", "6") ROW("638342802882597202", "-1", "9")
                     ROW("638342802882598202", "7", "1"),
             &log);
    static const uint64_t ms[] = {0, 16, 16, 2147483655, 2147483663},
                          ns[] = {0, 10000, 10000, 100000, 200000}, sequence[] = {1, 2, 3, 5, 6};
    for (int i = 0; i < 5; i++) {
        assert_int_equal(sample_at(&log, i)->device_ns, ms[i] * 1000000);
        assert_int_equal(sample_at(&log, i)->arrival_ns, ns[i]);
        assert_int_equal(sample_at(&log, i)->sequence, sequence[i]);
    }
    trk_log_finish(&log);
}

/* A missing number means that the field is lost, whatever the mask says. */
static void missing_numbers(void **state)
{
    (void)state;
    struct trk_log log;
    accepted(HEADER "7;1;1;" EYES("31", "31") "nan;0;1;0;0;1;False;" HEAD_AHEAD "8;2;2;" EYES("31", "#N/A")
                 GAZE_AHEAD HEAD_AHEAD "9;3;3;" EYES("31", "31") GAZE_AHEAD "1;2;3;0;-nan(ind);0\r\n",
             &log);
    assert_int_equal(sample_at(&log, 0)->valid & (TRK_LEFT_DIRECTION | TRK_RIGHT_DIRECTION),
                     TRK_RIGHT_DIRECTION);
    assert_int_equal(sample_at(&log, 1)->valid & (TRK_LEFT_DIRECTION | TRK_RIGHT_DIRECTION),
                     TRK_LEFT_DIRECTION);
    assert_int_equal(sample_at(&log, 2)->valid & (TRK_DIRECTION | TRK_HEAD), TRK_DIRECTION);
    trk_log_finish(&log);
}

/* A clock that stands still is not used. The other clock is used instead, and the log says so. */
static void clocks_that_stand(void **state)
{
    (void)state;
    struct trk_log log;
    accepted(HEADER ROW("638342802882596202", "50", "5") ROW("638342802882679535", "50", "6"), &log);
    assert_int_equal(sample_at(&log, 1)->device_ns, 8333300);
    assert_non_null(strstr(log.assumed, "time_stamp(ms) stands still: time is taken from time(100ns)"));
    trk_log_finish(&log);
    accepted(HEADER ROW("6.38343E+17", "50", "5") ROW("6.38343E+17", "58", "6"), &log);
    assert_int_equal(sample_at(&log, 1)->device_ns, 8000000);
    assert_int_equal(sample_at(&log, 1)->arrival_ns, 8000000);
    assert_non_null(strstr(log.assumed, "time(100ns) stands still: time is taken from time_stamp(ms)"));
    trk_log_finish(&log);
    refused(HEADER ROW("7", "50", "5") ROW("7", "50", "6"), ": ", "time_stamp(ms) stands still");
}

static void bad_input(void **state)
{
    (void)state;
    refused(HEADER, ": ", "holds no samples");
    refused("time(100ns);gaze_direct_L.x\r\n", ":1: ", "lacks a column, expected 'time_stamp(ms)'");
    refused(HEADER "1;2;3\r\n", ":2: ", "3 columns, expected 28");
    refused(HEADER ROW("7", "20", "1") ROW("8", "19", "2"), ":3: ", "goes back by 1 ms");
    refused(HEADER ROW("7", "20", "1") ROW("6", "21", "2"), ":3: ", "time(100ns) is 6");
    refused(HEADER ROW("-9223372036854775808", "20", "1") ROW("9223372036854775807", "21", "2"),
            ":2: ", "100ns");
    refused(HEADER ROW("7", "99999999999", "1"), ":2: ", "32-bit");
    refused(HEADER ROW("7", "1", "4294967296"), ":2: ", "frame is 4294967296");
    refused(HEADER ROW("7", "1.5", "1"), ":2: ", "whole number");
    refused(HEADER ROW("", "1", "1"), ":2: ", "time(100ns) is ''");
    refused(HEADER "7;1;1;" EYES("31", "31") "0;0;1;0;0;inf;False;" HEAD_AHEAD,
            ":2: ", "gaze_direct_R.z is 'inf'");
    refused(HEADER "7;1;1;" EYES("31", "31") "0;0;1;0;0;2;False;" HEAD_AHEAD, ":2: ", "unit length");
    refused(HEADER "7;1;1;" EYES("31", "31") "0,1,1;0;1;0;0;1;False;" HEAD_AHEAD, ":2: ", "0.1,1'");
    refused(HEADER "7;1;1;" EYES("31", "31") GAZE_AHEAD "1;2;3;0;x;0\r\n", ":2: ", "helmet_rot_y is 'x'");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(first_recording),
        cmocka_unit_test(second_recording),
        cmocka_unit_test(recording_without_rows),
        cmocka_unit_test(frames_and_units),
        cmocka_unit_test(validity),
        cmocka_unit_test(clocks),
        cmocka_unit_test(missing_numbers),
        cmocka_unit_test(clocks_that_stand),
        cmocka_unit_test(bad_input),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
