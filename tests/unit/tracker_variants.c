/* Logs whose header leaves something open, or whose rows hold less than the header promises, as in real
 * exports: what each reader makes of them, and what it says that it assumed. The rows are made up. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "tracker.h"
#include "tracker_samples.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
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

/* Read the log, with this frame unless it is NULL. The reader's notes must contain `says`. */
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

/* Sample i has this time, and this gaze in the world. */
static void is(size_t i, double ms, double yaw, double pitch)
{
    float d[3];
    assert_true(i < log_read.count);
    assert_float_equal((double)sample_at(&log_read, i)->device_ns / 1e6, ms, 1e-6);
    assert_true(trk_world_direction(sample_at(&log_read, i), d));
    assert_float_equal(atan2(d[0], -d[2]) * 180 / M_PI, yaw, 0.06);
    assert_float_equal(asin(d[1]) * 180 / M_PI, pitch, 0.06);
}

static void lost(size_t i, double ms)
{
    assert_true(i < log_read.count);
    assert_float_equal((double)sample_at(&log_read, i)->device_ns / 1e6, ms, 1e-6);
    assert_false(sample_at(&log_read, i)->valid & TRK_DIRECTION);
}

/* --- Tobii Pro Lab --- */

#define GLASSES                                                                                              \
    "Recording timestamp\tSensor\tEyetracker timestamp\tGaze point X\tGaze point Y\tGaze point 3D X\tGaze "  \
    "direction "                                                                                             \
    "left X\tGaze direction left Y\tGaze direction left Z\tPupil position left X\tPupil position left "      \
    "Y\tPupil "                                                                                              \
    "position left Z\n"

/* Older exports of glasses: names of columns have no units, the steps show that times are in microseconds,
 * rows of a gyroscope lie between, there is no validity, and the tracker's clock is empty. */
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
    assert_float_equal(sample_at(&log_read, 0)->eye[0].origin[0], -0.028, 1e-6);
    assert_non_null(strstr(log_read.assumed, "other sensors, skipped: 3"));
}

/* An export of a display may also hold directions, in the display's frame. They are preferred to points on a
 * screen whose distance would have to be assumed. Here only one eye has them. */
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
    assert_non_null(strstr(log_read.assumed, "eyes' directions in the display's frame (DACS)"));
    assert_null(strstr(log_read.assumed, "screen"));
    is(0, 0, 10, 0);
    is(1, 17, 0, 10);
    lost(2, 33);
    refused("Recording timestamp\tGaze point X\tGaze point Y\n0\t1\t1\n100\t1\t1\n", "steps of 100");
    refused("Recording timestamp\tFixation point X\tEye movement type\n0\t1\tFixation\n", "unknown header");
}

/* --- Tobii Pro Glasses 3 --- */

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

/* --- Gazepoint --- */

#define GAZEPOINT                                                                                            \
    "\"CNT\",\"TIME(2026/02/20 "                                                                             \
    "00:53:57.275)\",\"TIMETICK(f=10000000)\",FPOGX,FPOGY,FPOGV,BPOGX,BPOGY,BPOGV,\"\"\n"

/* TIME and CNT start anew with each medium. The ticks go on. */
static void gazepoint_joins_its_media(void **state)
{
    (void)state;
    reads(GAZEPOINT "0,\"0.00000\",3e+10,0.5,0.5,1,0.5,0.5,1,\"\"\n"
                    "1,\"0.50000\",30005000000,0.5,0.5,1,0.720409,0.5,1,\"\"\n"
                    "0,\"0.00000\",30005200000,0.5,0.5,1,0.5,0.108162,1,\"\"\n"
                    "2,\"0.03333\",30005533300,0.5,0.5,1,0.5,0.108162,0,\"\"\n"
                    "0,\"-0.00001\",30005733300,0.5,0.5,1,0.5,0.5,1,\"\"\n",
          NULL, "restarts of TIME, joined by the ticks: 1");
    is(0, 0, 0, 0);
    is(1, 500, 10, 0);
    is(2, 520, 0, 10);
    lost(3, 553.33);
    is(4, 553.33, 0, 0); /* a small step back is not a new start */
    assert_int_equal(sample_at(&log_read, 2)->sequence, 3);
    assert_int_equal(sample_at(&log_read, 3)->sequence, 5); /* one was lost */
    assert_true(sample_at(&log_read, 4)->arrival_ns == 573330000);
    /* Without ticks, or when the ticks go back too, nobody knows how much time has passed. */
    refused("CNT,TIME,FPOGX,FPOGY,FPOGV\n0,5,0.5,0.5,1\n1,0,0.5,0.5,1\n", "time goes back by 5 s");
    refused(GAZEPOINT "0,5,50,0,0,0,0,0,0,\"\"\n1,0,40,0,0,0,0,0,0,\"\"\n", "time goes back by 5 s");
}

/* --- Pupil Core --- */

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

/* --- 360_em --- */

/* When the head lies on its left side, what is to the right in the world is below in the head frame. */
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
    assert_float_equal(sample_at(&log_read, 0)->direction[0], 0, 1e-3);
    assert_float_equal(sample_at(&log_read, 0)->direction[1], -sin(10 * M_PI / 180), 1e-3);
}

/* --- BIDS --- */

#define PHYSIO                                                                                               \
    "{\"PhysioType\": \"eyetrack\", \"RecordedEye\": \"right\", \"SampleCoordinateSystem\": "                \
    "\"gaze-on-screen\", \"Columns\": [\"timestamp\", \"x_coordinate\", \"y_coordinate\", \"pupil_size\"], " \
    "\"timestamp\": {\"Units\": \"ms\", \"Origin\": \"System startup\"}, \"x_coordinate\": {\"Units\": "     \
    "\"pixel\"}, \"y_coordinate\": {\"Units\": \"pixel\"}, \"pupil_size\": {\"Units\": \"arbitrary\"}}"
#define EVENTS(origin)                                                                                       \
    "{\"TaskName\": \"x\", \"StimulusPresentation\": {\"ScreenDistance\": 0.6, \"ScreenOrigin\": " origin    \
    ", \"ScreenResolution\": [1000, 500], \"ScreenSize\": [0.4, 0.2]}}"

/* The screen is described in the metadata of the task's events. */
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
    assert_true(sample_at(&log_read, 0)->valid & TRK_RIGHT_DIRECTION);
    spill(other[1], EVENTS("[\"bottom\", \"right\"]"));
    reads(rows, NULL, "");
    is(0, 0, -10, 0);
    is(1, 1, 0, 10);
    reads(rows, "RDF", ""); /* the option takes precedence */
    is(1, 1, 0, -10);
    spill(other[1], EVENTS("[\"center\"]"));
    refused(rows, "ScreenOrigin is not a corner");
    spill(other[1], "{\"StimulusPresentation\": ");
    refused(rows, "events.json:1: ");
    spill(other[1], EVENTS("\"top-left\""));
    refused(rows, "ScreenOrigin is not a corner");
}

/* --- further variants --- */

#define DISPLAY                                                                                              \
    "Recording timestamp [ms]\tEvent\tMouse position X\tGaze direction right X [DACS norm]\tGaze direction " \
    "right Y [DACS norm]\tGaze direction right Z [DACS norm]\tEye position right X [DACS mm]\tEye position " \
    "right Y [DACS mm]\tEye position right Z [DACS mm]\tGaze point right X [DACS mm]\tGaze point right Y "   \
    "[DACS "                                                                                                 \
    "mm]\tGaze point X [DACS px]\tGaze point Y [DACS px]\n"

/* The tracker's own directions are preferred to points in millimetres, and those to pixels, unless options
 * tell the screen. */
static void tobii_display(void **state)
{
    (void)state;
    static const char first[] = "0\tStart\t\t\t\t\t\t\t\t\t\t\t\n1\t\t7\t\t\t\t\t\t\t\t\t\t\n";
    char text[2048];
    snprintf(text, sizeof text,
             DISPLAY "%s10\t\t\t0.173648\t0\t-0.984808\t300\t100\t600\t300\t100\t960\t540\n"
                     "20\t\t\t\t\t\t\t\t\t\t\t\t\n",
             first);
    reads(text, NULL, "other sensors, skipped: 2");
    is(0, 0, 10, 0);
    lost(1, 10);
    assert_null(strstr(log_read.assumed, "degrees wide"));
    snprintf(text, sizeof text, DISPLAY "%s10\t\t\t\t\t\t300\t100\t600\t300\t-5.796\t960\t540\n", first);
    reads(text, NULL, "in mm");
    is(0, 0, 0, 10);
    snprintf(text, sizeof text, DISPLAY "10\t\t\t\t\t\t300\t100\t600\t\t\t960\t540\n");
    reads(text, NULL, "screen 43.6 degrees wide");
    is(0, 0, 0, 0);
}

/* If the header names no frame, a positive Z means glasses: their Z points forward. */
static void tobii_directions_without_a_frame(void **state)
{
    (void)state;
    reads("Recording timestamp [ms]\tGaze direction left X\tGaze direction left Y\tGaze direction left Z\n"
          "0\t-0.173648\t0\t0.984808\n10\t0\t0.173648\t0.984808\n",
          NULL, "of glasses (HUCS)");
    is(0, 0, 10, 0);
    is(1, 10, 0, 10);
}

/* Rows with both 2-D and 3-D gaze show that the camera has a longer lens, and that its axis is not in the
 * middle of the picture. */
static void pupil_core_2d_among_3d(void **state)
{
    (void)state;
    char text[4096] = CORE;
    size_t length = strlen(text);
    for (int i = 0; i < 12; i++) {
        double x = tan((i % 4 * 6 - 9) * M_PI / 180), y = tan((i % 3 * 5 - 5) * M_PI / 180);
        length += (size_t)snprintf(text + length, sizeof text - length,
                                   "%.2f,0,1.0,%.6f,%.6f,1-0 1-1,%.4f,%.4f,1000,,,,,,,,,,,,\n", 5 + i / 100.0,
                                   0.48 + 0.9 * x, 0.53 - 1.2 * y, 1000 * x, 1000 * y);
    }
    snprintf(text + length, sizeof text - length, "5.12,0,1.0,%.6f,0.53,1-0,,,,,,,,,,,,,,,\n",
             0.48 + 0.9 * tan(10 * M_PI / 180));
    reads(text, NULL, "through a scene camera 58.1 degrees wide, fitted to the other rows");
    assert_int_equal(log_read.count, 13);
    is(12, 120, 10, 0);
    assert_int_equal(sample_at(&log_read, 12)->valid & (TRK_LEFT_DIRECTION | TRK_RIGHT_DIRECTION),
                     TRK_RIGHT_DIRECTION);
}

#define ASC(time, x, res)                                                                                    \
    "START\t" time "0 \tLEFT\nSAMPLES\tGAZE\tLEFT\tRATE\t250\n" time "0\t960\t540\t1\t.\n" time "4\t" x      \
    "\t540\t1\t.\nEND\t" time "8 \tRES\t" res "\t" res "\n"

/* A person comes nearer: the pixels per degree change, and each block has its own. */
static void eyelink_blocks_have_their_own_resolution(void **state)
{
    (void)state;
    reads("MSG\t1 GAZE_COORDS 0 0 1919 1079\n" ASC("100", "1363.574", "40") ASC("200", "1161.737", "20"),
          NULL, "");
    is(1, 4, 10, 0);
    is(3, 1004, 10, 0);
    assert_int_equal(log_read.count, 4);
}

/* JSON knows no NaN, but Python writes it. */
static void glasses3_with_nan(void **state)
{
    (void)state;
    reads("{\"type\":\"gaze\",\"timestamp\":0.5,\"data\":{\"eyeleft\":{\"gazedirection\":[NaN, -NaN,NaN]},"
          "\"eyeright\":{\"gazedirection\":[0,0,1],\"pupildiameter\": NaN}}}\n"
          "{\"type\":\"gaze\",\"timestamp\":0.52,\"data\":{\"eyeright\":{\"gazedirection\":[NaN,NaN,NaN]}}}",
          NULL, "");
    is(0, 0, 0, 0);
    lost(1, 20); /* a last line without a line end is whole if it ends with a brace */
    refused("{\"type\":\"gaze\",\"timestamp\":0.5,\"data\":{}}\n{\"type\":\n{\"type\":\"gaze\"}\n", ":2: ");
}

/* Clocks that do not run, in other formats. */
static void clocks_that_do_not_run(void **state)
{
    (void)state;
    static const char *const refusals[][2] = {
        {CORE "2E+3,0,1,0.5,0.5,b,,,,,,,,,,,,,,,\n2E+3,0,1,0.5,0.5,b,,,,,,,,,,,,,,,\n",
         "gaze_timestamp stands still: all its times are the same (2E+3: a spreadsheet"},
        {"n,x,y,val,dP,lab\n5,1,1,0,1,1\n5,1,1,0,1,1\n", "n stands still"},
        {"n,x,y,val,dP,lab\n1.00E+09,1,1,0,1,1\n1.01E+09,1,1,0,1,1\n1.02E+09,1,1,0,1,1\n",
         "n moves in steps of many samples: its times are rounded (1.00E+09: a spreadsheet"},
        {"time,position_x,position_y,pixel_x\n7,1,1,1\n7,1,1,1\n", "time stands still"},
        {"{\"type\":\"gaze\",\"timestamp\":7,\"data\":{}}\n{\"type\":\"gaze\",\"timestamp\":7,\"data\":{}}\n",
         "timestamp stands still"},
        /* Times in whole seconds: several samples share one. */
        {"Timeline\tCombine Eye Gaze Vector. x\tCombine Eye Gaze Vector. y\tCombine Eye Gaze Vector. z\tHead "
         "Rotation. x\tHead Rotation. y\tHead Rotation. "
         "z\n1\t0\t0\t1\t0\t0\t0\n1\t0\t0\t1\t0\t0\t0\n1\t0\t0\t1\t0\t0\t0\n"
         "2\t0\t0\t1\t0\t0\t0\n2\t0\t0\t1\t0\t0\t0\n2\t0\t0\t1\t0\t0\t0\n",
         "Timeline moves in steps of many samples"},
    };
    for (size_t i = 0; i < sizeof refusals / sizeof *refusals; i++) refused(refusals[i][0], refusals[i][1]);
    reads(GAZEPOINT "0,7,30000000000,0.5,0.5,1,0.5,0.5,1,\"\"\n1,7,30000166667,0.5,0.5,1,0.5,0.5,1,\"\"\n",
          NULL, "TIME stands still: time is taken from TIME_TICK");
    is(1, 16.6667, 0, 0);
    reads("time,position_x,position_y,pixel_x\n1.00E+03,1,1,1\n1.01E+03,1,1,1\n1.02E+03,1,1,1\n", NULL,
          "a spreadsheet has rounded the times to 10 ms (1.00E+03)");
}

/* If two participants have recordings of the same name, the participant must be named too. */
static void recordings_of_the_same_name(void **state)
{
    (void)state;
    static const char text[] = "n,x,y,val,dP,lab,Participant,Recording\n0,1,0,0,1,1,A,R1\n0,2,0,0,1,1,B,R1\n"
                               "4,1,0,0,1,1,A,R1\n0,3,0,0,1,1,B,R2\n";
    char error[TRK_ERROR_SIZE] = "";
    struct trk_log log;
    refused(text, "(A/R1, B/R1, R2)");
    assert_false(trk_log_read_with(path, &(struct trk_log_options){.recording = "R1"}, &log, error));
    assert_non_null(strstr(error, "(A/R1, B/R1)"));
    assert_false(trk_log_read_with(path, &(struct trk_log_options){.recording = "b"}, &log, error));
    assert_true(trk_log_read_with(path, &(struct trk_log_options){.recording = "A"}, &log_read, error));
    assert_int_equal(log_read.count, 2);
    trk_log_finish(&log_read);
    assert_true(trk_log_read_with(path, &(struct trk_log_options){.recording = "B/R2"}, &log_read, error));
    is(0, 0, 3, 0);
    refused("section id,gaze detected on surface,gaze position on surface x\n", "mapped picture");
    refused("id,start_timestamp,duration,dispersion,confidence,norm_pos_x,norm_pos_y,base_data\n",
            "fixations");
}

/* Names that look like missing numbers are names. An empty column says nothing. There may be many names. */
static void recordings_of_any_name(void **state)
{
    (void)state;
    char error[TRK_ERROR_SIZE] = "", many[4096] = "n,x,y,val,dP,lab,Recording\n", name[16];
    struct trk_log log;
    refused("n,x,y,val,dP,lab,Participant\n0,1,0,0,1,1,#1\n0,2,0,0,1,1,None\n", "(#1, None)");
    refused("n,x,y,val,dP,lab,Participant,Recording\n0,1,0,0,1,1,,R1\n0,2,0,0,1,1,n/a,R2\n", "(R1, R2)");
    assert_true(trk_log_read_with(path, &(struct trk_log_options){.recording = "R2"}, &log_read, error));
    is(0, 0, 2, 0);
    for (int i = 0; i < 40; i++) {
        const size_t used = strlen(many);
        snprintf(many + used, sizeof many - used, "0,%d,0,0,1,1,N%d\n", i, i);
    }
    spill(path, many);
    for (int i = 0; i < 40; i += 39) {
        snprintf(name, sizeof name, "N%d", i);
        trk_log_finish(&log_read);
        assert_true(trk_log_read_with(path, &(struct trk_log_options){.recording = name}, &log_read, error));
        is(0, 0, i, 0);
    }
    assert_false(trk_log_read_with(path, &(struct trk_log_options){.recording = "N40"}, &log, error));
    assert_non_null(strstr(error, "has no recording 'N40'"));
}

/* BIDS may state one unit for all coordinates. */
static void bids_units_of_all(void **state)
{
    (void)state;
    spill(other[0], "{\"Columns\": [\"timestamp\", \"x_coordinate\", \"y_coordinate\"], \"RecordedEye\": "
                    "\"left\", \"SampleCoordinateSystem\": \"eye-in-head\", \"SampleCoordinateUnits\": "
                    "\"deg\", \"timestamp\": {\"Units\": \"ms\"}}");
    reads("0\t5\t0\n4\t10\t5\n", NULL, "");
    is(1, 4, 10, 5);
}

/* Metadata in several folders: the deepest file that has a key counts, and within a folder the one with the
 * most entities. */
static void bids_inherits(void **state)
{
    (void)state;
    char folder[96], file[3][192], table[192], error[TRK_ERROR_SIZE] = "";
    snprintf(folder, sizeof folder, "%s/sub-01", dir);
    snprintf(file[0], sizeof file[0], "%s/physio.json", dir);
    snprintf(file[1], sizeof file[1], "%s/task-x_physio.json", dir);
    snprintf(file[2], sizeof file[2], "%s/sub-01_physio.json", folder);
    snprintf(table, sizeof table, "%s/sub-01_task-x_run-2_physio.tsv", folder);
    assert_int_equal(mkdir(folder, 0700), 0);
    spill(table, "0\t5\t0\n4\t10\t5\n");
    spill(
        file[0],
        "{\"SampleCoordinateSystem\": \"eye-in-head\", \"RecordedEye\": \"left\", \"timestamp\": {\"Units\": "
        "\"s\"}, \"x_coordinate\": {\"Units\": \"rad\"}}");
    spill(file[1],
          "{\"Columns\": [\"timestamp\", \"x_coordinate\", \"y_coordinate\"], \"timestamp\": {\"Units\": "
          "\"ms\"}}");
    spill(file[2], "{\"RecordedEye\": \"right\", \"x_coordinate\": {\"Units\": \"deg\"}}");
    if (!trk_log_read(table, &log_read, error)) fail_msg("%s", error);
    is(1, 4, 10, 5);
    assert_int_equal(sample_at(&log_read, 0)->valid & (TRK_LEFT_DIRECTION | TRK_RIGHT_DIRECTION),
                     TRK_RIGHT_DIRECTION);
    assert_true(trk_log_is_from(&log_read, file[0]) && trk_log_is_from(&log_read, file[2]));
    assert_true(trk_log_is_from(&log_read, file[1]));
    for (int i = 0; i < 3; i++) unlink(file[i]);
    unlink(table);
    rmdir(folder);
}

int main(void)
{
#define TEST(f) cmocka_unit_test_setup_teardown(f, enter, leave)
    const struct CMUnitTest tests[] = {
        TEST(tobii_glasses_without_units),
        TEST(tobii_screen_without_units),
        TEST(glasses3_with_a_point_alone),
        TEST(gazepoint_joins_its_media),
        TEST(pupil_core_mapped_in_2d),
        TEST(roll_of_360_em),
        TEST(bids_screens_are_in_the_events),
        TEST(tobii_display),
        TEST(tobii_directions_without_a_frame),
        TEST(pupil_core_2d_among_3d),
        TEST(eyelink_blocks_have_their_own_resolution),
        TEST(glasses3_with_nan),
        TEST(clocks_that_do_not_run),
        TEST(recordings_of_the_same_name),
        TEST(recordings_of_any_name),
        TEST(bids_units_of_all),
        TEST(bids_inherits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
