/* Logs whose headers leave something open, or whose rows hold less than their headers promise, as exports of
 * the field do: what each reader makes of them, and what it says that it took for granted. The rows are made.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "tracker.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static char dir[32], path[96], other[2][128];
static struct trk_log log_read; /* the log of the test */

static int enter(void **state)
{
    (void)state;
    snprintf(dir, sizeof dir, "tracker_variants.XXXXXX");
    if (!mkdtemp(dir)) return -1;
    snprintf(path, sizeof path, "%s/sub-01_task-x_recording-eye1_physio.tsv", dir);
    snprintf(other[0], sizeof other[0], "%s/sub-01_task-x_recording-eye1_physio.json", dir);
    snprintf(other[1], sizeof other[1], "%s/sub-01_task-x_events.json", dir);
    return 0;
}

static int leave(void **state)
{
    (void)state;
    trk_log_finish(&log_read);
    unlink(path);
    unlink(other[0]);
    unlink(other[1]);
    return rmdir(dir);
}

static void spill(const char *to, const char *text)
{
    FILE *file = fopen(to, "wb");
    assert_non_null(file);
    assert_true(fputs(text, file) >= 0);
    assert_int_equal(fclose(file), 0);
}

/* Read it, with the frame told if there is one; the reader must say so. */
static void reads(const char *text, const char *frame, const char *says)
{
    char error[TRK_ERROR_SIZE] = "";
    trk_log_finish(&log_read);
    spill(path, text);
    if (!trk_log_read_with(path, &(struct trk_log_options){.frame = frame}, &log_read, error))
        fail_msg("%s", error);
    if (!strstr(log_read.assumed, says)) fail_msg("'%s' should say '%s'", log_read.assumed, says);
}

static void refused(const char *text, const char *why)
{
    char error[TRK_ERROR_SIZE] = "";
    struct trk_log log;
    spill(path, text);
    assert_false(trk_log_read(path, &log, error));
    if (!strstr(error, why) || !strstr(error, "expected")) fail_msg("'%s' should say '%s'", error, why);
}

/* A sample: when, and where the gaze is in the world. */
static void is(size_t i, double ms, double yaw, double pitch)
{
    float d[3];
    assert_true(i < log_read.count);
    assert_float_equal((double)log_read.samples[i].device_ns / 1e6, ms, 1e-6);
    assert_true(trk_world_direction(&log_read.samples[i], d));
    assert_float_equal(atan2(d[0], -d[2]) * 180 / M_PI, yaw, 0.06);
    assert_float_equal(asin(d[1]) * 180 / M_PI, pitch, 0.06);
}

static void lost(size_t i, double ms)
{
    assert_true(i < log_read.count);
    assert_float_equal((double)log_read.samples[i].device_ns / 1e6, ms, 1e-6);
    assert_false(log_read.samples[i].valid & TRK_DIRECTION);
}

/* --- Tobii Pro Lab -------------------------------------------------------------------------------------- */

#define GLASSES                                                                                              \
    "Recording timestamp\tSensor\tEyetracker timestamp\tGaze point X\tGaze point Y\tGaze point 3D X\tGaze "  \
    "direction "                                                                                             \
    "left X\tGaze direction left Y\tGaze direction left Z\tPupil position left X\tPupil position left "      \
    "Y\tPupil "                                                                                              \
    "position left Z\n"

/* Names without units, times that are microseconds as their steps show, a gyroscope's rows between, no
 * validity and an empty clock of the tracker: as older exports of glasses come. */
static void tobii_glasses_without_units(void **state)
{
    (void)state;
    reads(GLASSES "1051981650\tGyroscope\t\t\t\t\t\t\t\t\t\t\n"
                  "1051989821\tGyroscope\t\t\t\t\t\t\t\t\t\t\n"
                  "1051996474\tEye Tracker\t\t962\t647\t1\t-0.173648\t0\t0.984808\t28\t-10\t-34\n"
                  "1051997992\tGyroscope\t\t\t\t\t\t\t\t\t\t\n"
                  "1052016474\tEye Tracker\t\t962\t647\t1\t0\t0.173648\t0.984808\t28\t-10\t-34\n"
                  "1052036474\tEye Tracker\t\t\t\t\t\t\t\t\t\t\n",
          NULL, "Recording timestamp is in us");
    assert_int_equal(log_read.count, 3);
    is(0, 0, 10, 0);
    is(1, 20, 0, 10);
    lost(2, 40);
    assert_float_equal(log_read.samples[0].eye[0].origin[0], -0.028, 1e-6);
    assert_non_null(strstr(log_read.assumed, "other sensors, skipped: 3"));
}

/* A display's export may hold directions too, of the display's frame: they go before points on a screen whose
 * place would have to be assumed. Only one eye's here. */
static void tobii_screen_without_units(void **state)
{
    (void)state;
    reads("Recording timestamp\tGaze point left X\tGaze point left Y\tGaze direction left X\tGaze direction "
          "left "
          "Y\tGaze direction left Z\tValidity left\n"
          "100\t1200\t540\t0.173648\t0\t-0.984808\tValid\n"
          "117\t960\t300\t0\t-0.173648\t-0.984808\tValid\n"
          "133\t960\t540\t0\t0\t-1\tInvalid\n",
          NULL, "Recording timestamp is in ms");
    assert_non_null(strstr(log_read.assumed, "eyes' directions from the display (DACS)"));
    assert_null(strstr(log_read.assumed, "screen"));
    is(0, 0, 10, 0);
    is(1, 17, 0, 10);
    lost(2, 33);
    refused("Recording timestamp\tGaze point X\tGaze point Y\n0\t1\t1\n100\t1\t1\n", "steps of 100");
    refused("Recording timestamp\tFixation point X\tEye movement type\n0\t1\tFixation\n", "unknown header");
}

/* --- Tobii Pro Glasses 3 -------------------------------------------------------------------------------- */

static void glasses3_with_a_point_alone(void **state)
{
    (void)state;
    reads(
        "{\"type\":\"gaze\",\"timestamp\":0.5,\"data\":{\"gaze3d\":[-138.9184,0,787.8464],\"eyeleft\":{}}}\n"
        "{\"type\":\"gaze\",\"timestamp\":0.52,\"data\":{\"gaze2d\":[0.5,0.5]}}\n",
        NULL, "");
    is(0, 0, 10, 0);
    lost(1, 20);
}

/* --- Gazepoint ------------------------------------------------------------------------------------------ */

#define GAZEPOINT                                                                                            \
    "\"CNT\",\"TIME(2026/02/20 "                                                                             \
    "00:53:57.275)\",\"TIMETICK(f=10000000)\",FPOGX,FPOGY,FPOGV,BPOGX,BPOGY,BPOGV,\"\"\n"

/* TIME begins anew with each medium, and with it CNT; the ticks go on. */
static void gazepoint_joins_its_media(void **state)
{
    (void)state;
    reads(GAZEPOINT "0,\"0.00000\",3e+10,0.5,0.5,1,0.5,0.5,1,\"\"\n"
                    "1,\"0.50000\",30005000000,0.5,0.5,1,0.720409,0.5,1,\"\"\n"
                    "0,\"0.00000\",30005200000,0.5,0.5,1,0.5,0.108162,1,\"\"\n"
                    "2,\"0.03333\",30005533300,0.5,0.5,1,0.5,0.108162,0,\"\"\n"
                    "0,\"-0.00001\",30005733300,0.5,0.5,1,0.5,0.5,1,\"\"\n",
          NULL, "TIME begins anew 1 times, joined by the ticks");
    is(0, 0, 0, 0);
    is(1, 500, 10, 0);
    is(2, 520, 0, 10);
    lost(3, 553.33);
    is(4, 553.33, 0, 0); /* a little back is no beginning */
    assert_int_equal(log_read.samples[2].sequence, 3);
    assert_int_equal(log_read.samples[3].sequence, 5); /* one was lost */
    assert_true(log_read.samples[4].arrival_ns == 573330000);
    /* Without ticks nobody knows how long it was; nor when they go back with it. */
    refused("CNT,TIME,FPOGX,FPOGY,FPOGV\n0,5,0.5,0.5,1\n1,0,0.5,0.5,1\n", "time goes back by 5 s");
    refused(GAZEPOINT "0,5,50,0,0,0,0,0,0,\"\"\n1,0,40,0,0,0,0,0,0,\"\"\n", "time goes back by 5 s");
}

/* --- Pupil Core ----------------------------------------------------------------------------------------- */

#define CORE                                                                                                 \
    "gaze_timestamp,world_index,confidence,norm_pos_x,norm_pos_y,base_data,gaze_point_3d_x,gaze_point_3d_y," \
    "gaze_point_3d_z,eye_center0_3d_x,eye_center0_3d_y,eye_center0_3d_z,gaze_normal0_x,gaze_normal0_y,"      \
    "gaze_normal0_z,eye_center1_3d_x,eye_center1_3d_y,eye_center1_3d_z,gaze_normal1_x,gaze_normal1_y,"       \
    "gaze_normal1_z\n"

/* The header is the same whether gaze was mapped in 3-D or in 2-D. */
static void pupil_core_mapped_in_2d(void **state)
{
    (void)state;
    reads(CORE "5.00,0,1.0,0.609432,0.5,b,,,,,,,,,,,,,,,\n"
               "5.01,0,1.0,0.5,0.694547,b,,,,,,,,,,,,,,,\n"
               "5.02,0,0.1,0.5,0.5,b,,,,,,,,,,,,,,,\n"
               "5.03,0,1.0,,,b,,,,,,,,,,,,,,,\n",
          NULL, "no 3-D gaze: norm_pos through a scene camera 77.7 degrees wide");
    is(0, 0, 10, 0);
    is(1, 10, 0, 10);
    lost(2, 20);
    lost(3, 30);
}

/* --- 360_em --------------------------------------------------------------------------------------------- */

/* A head that lies on its left side sees what is to the right in the world below. */
static void roll_of_360_em(void **state)
{
    (void)state;
    reads("@RELATION gaze_360\n%@METADATA width_px 1920\n%@METADATA height_px 1080\n@ATTRIBUTE time INTEGER\n"
          "@ATTRIBUTE x NUMERIC\n@ATTRIBUTE y NUMERIC\n@ATTRIBUTE confidence NUMERIC\n@ATTRIBUTE x_head "
          "NUMERIC\n"
          "@ATTRIBUTE y_head NUMERIC\n@ATTRIBUTE angle_deg_head NUMERIC\n@DATA\n"
          "0,1013.333,540,1,960,540,90\n",
          NULL, "the head's tilt to the left");
    is(0, 0, 10, 0);
    assert_float_equal(log_read.samples[0].direction[0], 0, 1e-3);
    assert_float_equal(log_read.samples[0].direction[1], -sin(10 * M_PI / 180), 1e-3);
}

/* --- BIDS ----------------------------------------------------------------------------------------------- */

#define PHYSIO                                                                                               \
    "{\"PhysioType\": \"eyetrack\", \"RecordedEye\": \"right\", \"SampleCoordinateSystem\": "                \
    "\"gaze-on-screen\", \"Columns\": [\"timestamp\", \"x_coordinate\", \"y_coordinate\", \"pupil_size\"], " \
    "\"timestamp\": {\"Units\": \"ms\", \"Origin\": \"System startup\"}, \"x_coordinate\": {\"Units\": "     \
    "\"pixel\"}, \"y_coordinate\": {\"Units\": \"pixel\"}, \"pupil_size\": {\"Units\": \"arbitrary\"}}"
#define EVENTS(origin)                                                                                       \
    "{\"TaskName\": \"x\", \"StimulusPresentation\": {\"ScreenDistance\": 0.6, \"ScreenOrigin\": " origin    \
    ", \"ScreenResolution\": [1000, 500], \"ScreenSize\": [0.4, 0.2]}}"

/* The screen is described in the file of the task's events. */
static void bids_screens_are_in_the_events(void **state)
{
    (void)state;
    static const char rows[] = "7186799\t764.490\t250\t4612.0\n7186800\t500\t514.490\t4623.0\n";
    spill(other[0], PHYSIO);
    reads(rows, NULL, "pixels count from the screen's top left corner");
    spill(other[1], EVENTS("[\"top\", \"left\"]"));
    reads(rows, NULL, "the screen is 36.9 degrees wide");
    is(0, 0, 10, 0);
    is(1, 1, 0, -10);
    assert_null(strstr(log_read.assumed, "corner"));
    assert_true(log_read.samples[0].valid & TRK_RIGHT_DIRECTION);
    spill(other[1], EVENTS("[\"bottom\", \"right\"]"));
    reads(rows, NULL, "");
    is(0, 0, -10, 0);
    is(1, 1, 0, 10);
    reads(rows, "RDF", ""); /* what is told goes before */
    is(1, 1, 0, -10);
    spill(other[1], EVENTS("[\"center\"]"));
    refused(rows, "ScreenOrigin is no corner");
    spill(other[1], "{\"StimulusPresentation\": ");
    refused(rows, "events.json:1: ");
    spill(other[1], EVENTS("\"top-left\""));
    refused(rows, "ScreenOrigin is no corner");
}

int main(void)
{
#define TEST(f) cmocka_unit_test_setup_teardown(f, enter, leave)
    const struct CMUnitTest tests[] = {
        TEST(tobii_glasses_without_units),    TEST(tobii_screen_without_units),
        TEST(glasses3_with_a_point_alone),    TEST(gazepoint_joins_its_media),
        TEST(pupil_core_mapped_in_2d),        TEST(roll_of_360_em),
        TEST(bids_screens_are_in_the_events),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
