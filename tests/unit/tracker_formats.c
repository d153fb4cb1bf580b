/* All log formats tell the same story. The small logs in tests/fuzz/corpus/log were made for this project,
 * each after the documentation of its format or after real rows. They hold five samples, 10 ms apart (0.5 ms
 * in the log of 2000 Hz). A person looks ahead, 10 degrees to the right, 10 up, blinks, and then looks 10 to
 * the left and 5 down with the left eye alone. Where the format has a head pose, the head is turned 20
 * degrees to the right throughout. Further tests: options that override a log, and how bad input is refused.
 */
#include "tracker_corpus.h"

#include "tracker.h"
#include "tracker_samples.h"

#include <math.h>
#include <zlib.h>

enum {
    EYES = 1,
    HEAD = 2,
    BLINK = 4,
    PUPILS = 8,
    GAP = 16,
    SCREEN = 32
}; /* what a format holds besides gaze */

static const struct format {
    const char *file, *id, *name;
    unsigned has;
    const char *assumed;
} logs[] = {
    {"own.gaze", "fovead", "fovead", EYES | HEAD | PUPILS, ""},
    {"sranipal.csv", "sranipal", "HTC SRanipal", EYES | HEAD | PUPILS, ""},
    {"sranipal_comma.csv", "sranipal", "HTC SRanipal", EYES | HEAD | PUPILS, ""},
    {"sranipal_blanks.txt", "sranipal", "HTC SRanipal", EYES | PUPILS, "no head pose"},
    {"salient360_static.csv", "salient360-static", "Salient360 static", EYES | HEAD, "mean of the eyes"},
    {"salient360_dynamic.csv", "salient360-dynamic", "Salient360 dynamic", EYES | HEAD,
     "comma was put back: 5"},
    {"pupil_core.csv", "pupil-core", "Pupil Core", EYES, "out of order, sorted by time: 1"},
    {"pupil_core_2d.csv", "pupil-core", "Pupil Core", 0, "a scene camera 77.7 degrees wide"},
    {"pupil_cloud.csv", "pupil-cloud", "Pupil Cloud", BLINK, "in blinks, counted as lost: 1"},
    {"tobii_lab.tsv", "tobii-lab", "Tobii Pro Lab", EYES | PUPILS | SCREEN,
     "other sensors, skipped: 1; commas"},
    {"tobii_lab_glasses.tsv", "tobii-lab", "Tobii Pro Lab", EYES, ""},
    {"glasses3.json", "glasses3", "Tobii Pro Glasses 3", EYES | PUPILS, ""},
    {"glasses3.gz", "glasses3", "Tobii Pro Glasses 3", EYES | PUPILS, ""},
    {"pico.tsv", "pico", "Pico", HEAD | BLINK, "gaze is in Unity's frame (RUF)"},
    {"eyelink_bino.asc", "eyelink", "EyeLink ASC", EYES | BLINK | SCREEN,
     "40.0 px per degree the screen is 45.5 degrees wide"},
    {"eyelink_mono.asc", "eyelink", "EyeLink ASC", SCREEN, "40.0 px per degree"},
    {"eyelink_2000.asc", "eyelink", "EyeLink ASC", SCREEN, "spread evenly at 2000 Hz: 2"},
    {"gazepoint.csv", "gazepoint", "Gazepoint", EYES | BLINK | PUPILS | GAP | SCREEN,
     "screen of 16:9 43.6 degrees wide"},
    {"open_gaze.xml", "open-gaze", "Open Gaze API", EYES | BLINK | GAP | SCREEN,
     "screen of 16:9 43.6 degrees wide"},
    {"gazebase.csv", "gazebase", "GazeBase", SCREEN, ""},
    {"gazebase_vr.csv", "gazebase-vr", "GazeBaseVR", EYES, ""},
    {"pymovements.csv", "pymovements", "pymovements", SCREEN, "time is in ms (steps of 10)"},
    {"360em.arff", "360em", "360_em ARFF", HEAD, "roll"},
    {"bids_screen.txt", "bids", "BIDS eye tracking", SCREEN,
     "by the sidecar the screen is 43.6 degrees wide"},
    {"bids_world.txt", "bids", "BIDS eye tracking", 0, "time"},
};
enum { LOGS = sizeof logs / sizeof *logs };

/* Copy a small log to path, and return its text, which the caller frees. */
static char *copy(const char *file, size_t *out_size)
{
    char *text = calloc(1, 8192);
    assert_non_null(text);
    *out_size = corpus(file, text, 8192);
    spill(path, text, *out_size);
    return text;
}

static bool open_log(const char *file, const struct trk_log_options *options, struct trk_log *out_log,
                     char error[TRK_ERROR_SIZE])
{
    size_t size;
    free(copy(file, &size));
    bool ok = trk_log_read_with(path, options, out_log, error);
    unlink(path);
    unlink(sidecar);
    return ok;
}

static void check_gaze(const float direction[3], double yaw, double pitch)
{
    assert_float_equal(atan2(direction[0], -direction[2]) * 180 / M_PI, yaw, 0.06);
    assert_float_equal(asin(direction[1]) * 180 / M_PI, pitch, 0.06);
}

/* The point on the screen, from its top left corner: 10 degrees are a fifth of the screens' width and two
 * fifths of their height. */
static void check_point(const struct format *format, const struct trk_sample *sample, int i)
{
    static const double x[] = {0, 0.211, 0, 0, -0.211}, y[] = {0, 0, -0.37, 0, 0.185};
    assert_int_equal((sample->valid & TRK_SCREEN) != 0, (format->has & SCREEN) && i != 3);
    if (!(sample->valid & TRK_SCREEN)) return;
    assert_float_equal(sample->screen[0], 0.5 + x[i], fabs(x[i]) * 0.05 + 1e-5);
    assert_float_equal(sample->screen[1], 0.5 + y[i], fabs(y[i]) * 0.16 + 1e-5);
}

static void check_sample(const struct format *format, const struct trk_sample *sample, int i)
{
    static const double gaze_deg[5][2] = {{0, 0}, {10, 0}, {0, 10}, {0, 0}, {-10, -5}};
    const uint64_t step_ns = strstr(format->file, "2000") ? 500000 : 10000000;
    const uint32_t eyes = sample->valid & (TRK_LEFT_DIRECTION | TRK_RIGHT_DIRECTION);
    float world[3];
    assert_int_equal(sample->device_ns, (uint64_t)i * step_ns);
    assert_int_equal(sample->arrival_ns, (uint64_t)i * step_ns);
    assert_int_equal(sample->sequence, (format->has & GAP) && i == 4 ? 6 : i + 1);
    assert_int_equal((sample->valid & TRK_HEAD) != 0, (format->has & HEAD) != 0);
    assert_int_equal(trk_world_direction(sample, world), i != 3);
    if (i != 3) check_gaze(world, gaze_deg[i][0], gaze_deg[i][1]);
    check_point(format, sample, i);
    if (format->has & EYES)
        assert_int_equal(eyes, i == 3   ? 0
                               : i == 4 ? TRK_LEFT_DIRECTION
                                        : TRK_LEFT_DIRECTION | TRK_RIGHT_DIRECTION);
    if (eyes & TRK_LEFT_DIRECTION)
        for (int k = 0; k < 3; k++)
            assert_float_equal(sample->eye[0].direction[k], sample->direction[k], 1e-5);
    if (sample->valid & TRK_LEFT_ORIGIN)
        assert_true(sample->eye[0].origin[0] < -0.02f && sample->eye[0].origin[0] > -0.05f);
    if (sample->valid & TRK_RIGHT_ORIGIN)
        assert_true(sample->eye[1].origin[0] > 0.01f && sample->eye[1].origin[0] < 0.05f);
    if ((format->has & BLINK) && i == 3) {
        assert_true(sample->valid & TRK_LEFT_OPENNESS);
        assert_true(sample->eye[0].openness == 0);
    }
    if ((format->has & PUPILS) && i == 0)
        assert_true(sample->eye[0].pupil_mm >= 3 && sample->eye[0].pupil_mm < 5);
    if (i == 3) assert_false(sample->valid & TRK_LEFT_PUPIL);
}

static void every_format_says_the_same(void **state)
{
    (void)state;
    for (int k = 0; k < LOGS; k++) {
        char error[TRK_ERROR_SIZE] = "";
        struct trk_log log;
        if (!open_log(logs[k].file, &(struct trk_log_options){0}, &log, error))
            fail_msg("%s: %s", logs[k].file, error);
        print_message("%s: %s; %s\n", logs[k].file, log.format, log.assumed);
        assert_string_equal(log.format, logs[k].name);
        assert_int_equal(log.count, 5);
        for (int i = 0; i < 5; i++) check_sample(&logs[k], sample_at(&log, i), i);
        if (!strstr(log.assumed, logs[k].assumed))
            fail_msg("'%s' should say '%s'", log.assumed, logs[k].assumed);
        trk_log_finish(&log);
    }
}

static void formats_can_be_told(void **state)
{
    (void)state;
    char error[TRK_ERROR_SIZE] = "";
    struct trk_log log;
    for (int k = 0; k < LOGS; k++) {
        if (!open_log(logs[k].file, &(struct trk_log_options){.format = logs[k].id}, &log, error))
            fail_msg("%s: %s", logs[k].file, error);
        assert_int_equal(log.count, 5);
        trk_log_finish(&log);
        const char *other = strcmp(logs[k].id, "sranipal") == 0 ? "gazebase" : "sranipal";
        assert_false(open_log(logs[k].file, &(struct trk_log_options){.format = other}, &log, error));
        assert_null(log.samples);
        assert_non_null(strstr(error, "header lacks a column"));
    }
    assert_false(trk_log_read_with("x", &(struct trk_log_options){.format = "x"}, &log, error));
}

static void refused_options(const char *file, struct trk_log_options options, const char *why)
{
    char error[TRK_ERROR_SIZE] = "";
    struct trk_log log;
    assert_false(open_log(file, &options, &log, error));
    assert_null(log.samples);
    if (!strstr(error, why) || !strstr(error, "expected")) fail_msg("'%s' should say '%s'", error, why);
}

static void impossible_options_are_refused(void **state)
{
    (void)state;
    refused_options("own.gaze", (struct trk_log_options){.format = "x"},
                    "unknown log format 'x', expected one of fovead");
    refused_options("own.gaze", (struct trk_log_options){.time_unit = "h"}, "time unit 'h'");
    refused_options("own.gaze", (struct trk_log_options){.time_unit = "ms"}, "has a fixed time unit");
    refused_options("own.gaze", (struct trk_log_options){.frame = "RUF"}, "has a fixed frame");
    refused_options("pico.tsv", (struct trk_log_options){.screen_fov_deg = 40}, "geometry without a screen");
    refused_options("pico.tsv", (struct trk_log_options){.frame = "RUR"}, "frame 'RUR'");
    refused_options("pico.tsv", (struct trk_log_options){.frame = "RU"}, "frame 'RU'");
    refused_options("gazebase.csv", (struct trk_log_options){.frame = "URF"}, "does not go with two numbers");
    refused_options("eyelink_mono.asc", (struct trk_log_options){.screen_fov_deg = 180}, "field of view");
    refused_options("eyelink_mono.asc", (struct trk_log_options){.screen_fov_deg = NAN}, "field of view");
    refused_options("eyelink_mono.asc", (struct trk_log_options){.screen_width_m = 1},
                    "screen 1 m wide and 0 m away");
    refused_options(
        "eyelink_mono.asc",
        (struct trk_log_options){.screen_width_m = 1, .screen_distance_m = 1, .screen_fov_deg = 1},
        "expected one of them");
}

static void told(const char *file, struct trk_log_options options, int sample, double yaw, double pitch,
                 uint64_t last_ns)
{
    char error[TRK_ERROR_SIZE] = "";
    struct trk_log log;
    float world[3];
    if (!open_log(file, &options, &log, error)) fail_msg("%s: %s", file, error);
    assert_true(trk_world_direction(sample_at(&log, sample), world));
    check_gaze(world, yaw, pitch);
    assert_int_equal(sample_at(&log, 4)->device_ns, last_ns);
    trk_log_finish(&log);
}

static void options_are_followed(void **state)
{
    (void)state;
    /* The head is turned 20 to the right, and the eye 10 to the left in it. With x mirrored, the eye looks 10
     * further to the right. */
    told("sranipal.csv", (struct trk_log_options){.frame = "RUF"}, 1, 30, 0, 40000000);
    told("glasses3.gz", (struct trk_log_options){.frame = "ruf"}, 1, -10, 0, 40000000);
    told("gazebase.csv", (struct trk_log_options){.frame = "LDF"}, 4, 10, 5, 40000000);
    told("gazepoint.csv", (struct trk_log_options){.frame = "RUF"}, 2, 0, -10, 40000000);
    told("glasses3.gz", (struct trk_log_options){.time_unit = "ms"}, 1, 10, 0, 40000);
    told("pymovements.csv", (struct trk_log_options){.time_unit = "s"}, 1, 10, 0, 40000000000);
    double half = tan(43.6028 / 2 * M_PI / 180), near = atan(tan(10 * M_PI / 180) / half) * 180 / M_PI;
    told("gazepoint.csv", (struct trk_log_options){.screen_fov_deg = 90}, 1, near, 0, 40000000);
    told("tobii_lab.tsv", (struct trk_log_options){.screen_width_m = 2, .screen_distance_m = 1}, 1, near, 0,
         40000000);
    told("eyelink_mono.asc", (struct trk_log_options){.screen_fov_deg = 45.47}, 1, 10, 0, 40000000);
}

/* Where on the screen the eye looks is what the log says, however large the screen is thought to be. */
static void points_on_screens(void **state)
{
    (void)state;
    static const struct {
        const char *file;
        float x, y; /* of the second sample */
    } points[] = {{"gazepoint.csv", 0.720409f, 0.5f},
                  {"open_gaze.xml", 0.720409f, 0.5f},
                  {"tobii_lab.tsv", 1383.185f / 1920, 0.5f}};
    static const double fov_deg[] = {0, 90, 20};
    for (size_t k = 0; k < sizeof points / sizeof *points; k++)
        for (int i = 0; i < 3; i++) {
            const struct trk_log_options options = {.screen_fov_deg = fov_deg[i]};
            char error[TRK_ERROR_SIZE];
            struct trk_log log;
            if (!open_log(points[k].file, &options, &log, error)) fail_msg("%s: %s", points[k].file, error);
            assert_float_equal(sample_at(&log, 1)->screen[0], points[k].x, 1e-5);
            assert_float_equal(sample_at(&log, 1)->screen[1], points[k].y, 1e-5);
            trk_log_finish(&log);
        }
}

/* --- bad input --- */

/* The log with the first `from` replaced by `to` is refused, with this line number and reason. */
static void spoiled(const char *file, const char *from, const char *to, int line, const char *why)
{
    char error[TRK_ERROR_SIZE] = "", start[128];
    size_t size;
    struct trk_log log;
    char *text = copy(file, &size), *at = strstr(text, from), *changed = NULL;
    if (!at) fail_msg("%s holds no '%s'", file, from);
    int length = asprintf(&changed, "%.*s%s%s", (int)(at - text), text, to, at + strlen(from));
    assert_true(length > 0);
    spill(path, changed, (size_t)length);
    bool ok = trk_log_read(path, &log, error);
    snprintf(start, sizeof start, "%s:%d: ", path, line);
    if (ok || strncmp(error, start, strlen(start)) != 0 || !strstr(error, why) ||
        !strstr(error, "expected") || strchr(error, '\n'))
        fail_msg("%s: '%s' should start with '%s', say '%s' and what was expected", file, error, start, why);
    assert_null(log.samples);
    free(changed);
    free(text);
    unlink(path);
    unlink(sidecar);
}

static void bad_rows_are_refused(void **state)
{
    (void)state;
    spoiled("sranipal_comma.csv", "638342802882796202,", "638342802882796202", 4, "26 columns, expected 27");
    spoiled("sranipal_blanks.txt", "638342802882796202\t-1511527576\t", "", 4, "columns, expected 21");
    spoiled("salient360_static.csv", "19861638208", "19861438208", 3, "time goes back by 0.19 s");
    spoiled("salient360_static.csv", "63709682685828", "637096826858280000", 3,
            "UnityTimeStamp is far from the first");
    spoiled("salient360_static.csv", "True,True", "True,yes", 2, "valR is 'yes', expected True or False");
    spoiled("salient360_static.csv", ",NaN,NaN,NaN,", ",NaN,inf,NaN,", 5, "leftEyeDirection.y is 'inf'");
    spoiled("salient360_dynamic.csv", "657538133153,", "657538133153", 3, "columns, expected 26");
    spoiled("pupil_core.csv", "342005.9800000", "341999", 4, "s before the first row");
    spoiled("pupil_core.csv", "342005.9800000", "342009", 5, "device time goes back by");
    spoiled("pupil_core.csv", "0.98", "x", 2, "confidence is 'x'");
    spoiled("pupil_cloud.csv", "1629390345056471431", "", 4, "timestamp [ns] is '', expected a time");
    spoiled("pupil_cloud.csv", "azimuth [deg],elevation [deg]",
            "gaze detected on surface,gaze position on surface x [normalized]", 1,
            "gaze on a mapped picture");
    spoiled("tobii_lab.tsv", "\tValid\tValid", "\tValid", 2, "16 columns, expected 17");
    spoiled("tobii_lab_plain.tsv",
            "Gaze point X\tGaze point Y\tGaze point 3D X\tGaze direction left X\tGaze direction left Y\tGaze "
            "direction left Z",
            "a\tb\tc\tValidity left\td\te", 1, "has neither");
    spoiled("glasses3.json", "\"gaze\",\"timestamp\":0.02", "\"imu\",\"timestamp\":0.02", 2, "type is 'imu'");
    spoiled("glasses3.json", "\"timestamp\":0.02", "\"timestamp\":\"0.02\"", 2, "has no timestamp");
    spoiled("glasses3.json", "{\"type\":\"gaze\",\"timestamp\":0.02", "{\"type\"\"gaze\",\"timestamp\":0.02",
            2, "':' expected");
    spoiled("pico.tsv", "3.2700", "3.27s", 4, "Timeline is '3.27s'");
    spoiled("pico.tsv", "3.2700", "3.1", 4, "time goes back by 0.16 s");
    spoiled("eyelink_bino.asc", "SAMPLES\tGAZE", "SAMPLES\tHREF", 11, "expected GAZE");
    spoiled("eyelink_bino.asc", "SAMPLES\tGAZE", "XAMPLES\tGAZE", 12, "sample of unknown eyes");
    spoiled("eyelink_bino.asc", "1022", "1022x", 14, "time is '1022x'");
    spoiled("eyelink_mono.asc", "540.00", "5x", 12, "gaze is '5x'");
    spoiled("eyelink_mono.asc", " 540.00\t  288.0\t.....", "", 12, "2 columns, expected at least 4");
    spoiled("gazepoint.csv", ",0.50000,", ",,", 2, "TIME is ''");
    spoiled("gazepoint.csv", "TIME(2020/01/31 10:00:00.000)", "T", 1, "expected 'TIME'");
    spoiled("gazepoint.csv", ",0.5", ",half", 2, "TIME is 'half0000'");
    spoiled("open_gaze.xml", "BPOGX=\"0.500000\"", "BPOGX=0.5", 3, "expected NAME=\"VALUE\" or />");
    spoiled("open_gaze.xml", "BPOGX=\"0.500000\"", "BPOGX=\"inf\"", 3, "BPOGX is 'inf'");
    spoiled("gazebase.csv", "20,", "2O,", 4, "n is '2O', expected a time");
    spoiled("gazebase_vr.csv", "0.0,0.0,0.4433,", "0.0,0.4433,", 2, "15 columns, expected 16");
    spoiled("pymovements.csv", "10,", "10000,", 4, "time goes back");
    spoiled("360em.arff", "width_px 1920", "width_px 0", 18, "no size of the panorama");
    spoiled("360em.arff", "gaze_360", "gaze_fov", 2, "expected @RELATION gaze_360");
    spoiled("360em.arff", "@ATTRIBUTE x NUMERIC", "@ATTRIBUTE", 9, "expected @ATTRIBUTE and a name");
    spoiled("360em.arff", "@ATTRIBUTE y NUMERIC", "", 18, "lacks a column, expected 'y'");
    spoiled("360em.arff", "@DATA", "", 24, "no @DATA");
    spoiled("bids_screen.txt", "1010", "late", 2, "timestamp is 'late'");
    spoiled("bids_screen.txt", "\t7\n", "\n", 1, "4 columns, expected 5");
}

static void bad_sidecar(const char *from, const char *to, const char *why)
{
    size_t size;
    char error[TRK_ERROR_SIZE] = "", json[4096] = "", changed[4608];
    struct trk_log log;
    free(copy("bids_screen.txt", &size));
    FILE *file = fopen(sidecar, "rb");
    assert_non_null(file);
    assert_true(fread(json, 1, sizeof json - 1, file) > 0);
    fclose(file);
    char *at = strstr(json, from);
    if (!at) fail_msg("no '%s'", from);
    snprintf(changed, sizeof changed, "%.*s%s%s", (int)(at - json), json, to, at + strlen(from));
    spill(sidecar, changed, strlen(changed));
    assert_false(trk_log_read(path, &log, error));
    if (!strstr(error, why) || !strstr(error, "expected")) fail_msg("'%s' should say '%s'", error, why);
}

static void bad_sidecars_are_refused(void **state)
{
    (void)state;
    char error[TRK_ERROR_SIZE] = "";
    struct trk_log log;
    bad_sidecar("{", "[", "x.json:1: ");
    bad_sidecar("gaze-on-screen", "gaze", "SampleCoordinateSystem is 'gaze'");
    bad_sidecar("\"x_coordinate\": {\"Units\": \"pixel\"}", "\"x_coordinate\": {\"Units\": \"mm\"}",
                "x_coordinate's Units are 'mm'");
    bad_sidecar("\"timestamp\", \"x_coordinate\"", "\"timestamp\", \"x\"",
                "lacks a column, expected 'x_coordinate'");
    bad_sidecar("\"timestamp\", \"x_coordinate\"", "7, \"x_coordinate\"",
                "entry 1 of the sidecar's Columns is not a name");
    bad_sidecar(", \"other\"", "", "5 columns, expected 4");
    unlink(sidecar);
    assert_false(trk_log_read(path, &log, error));
    assert_non_null(strstr(error, "no BIDS sidecar has Columns"));
}

/* A header that fits two formats is refused, unless an option names the format. */
static void ambiguity_is_refused(void **state)
{
    (void)state;
    static const char text[] =
        "n,x,y,val,dP,lab,lx,ly,rx,ry,clx,cly,clz,crx,cry,crz\n0,1,2,0,7,1,1,2,1,2,0,0,0,0,0,0\n";
    char error[TRK_ERROR_SIZE] = "";
    struct trk_log log;
    spill(path, text, strlen(text));
    assert_false(trk_log_read(path, &log, error));
    assert_non_null(
        strstr(error, ":1: may be any of gazebase, gazebase-vr: expected an option that names the format"));
    assert_true(trk_log_read_with(path, &(struct trk_log_options){.format = "gazebase-vr"}, &log, error));
    assert_true(sample_at(&log, 0)->valid & TRK_LEFT_DIRECTION);
    trk_log_finish(&log);
}

static void units_of_time_are_guessed_or_refused(void **state)
{
    (void)state;
    static const struct {
        double step;
        const char *says;
    } times[] = {{0.004, "in s "}, {4, "in ms"}, {4000, "in us"}, {4e6, "in ns"}};
    char error[TRK_ERROR_SIZE] = "", text[256];
    struct trk_log log;
    for (size_t i = 0; i < sizeof times / sizeof *times; i++) {
        snprintf(text, sizeof text, "time,pixel_x,pixel_y,position_x,position_y\n%f,1,1,1,1\n%f,1,1,1,1\n",
                 times[i].step, 2 * times[i].step);
        spill(path, text, strlen(text));
        if (!trk_log_read(path, &log, error)) fail_msg("%s", error);
        assert_int_equal(sample_at(&log, 1)->device_ns, 4000000);
        assert_non_null(strstr(log.assumed, times[i].says));
        trk_log_finish(&log);
    }
    static const char text_of_none[] = "time,pixel_x,pixel_y,position_x,position_y\n0,1,1,1,1\n100,1,1,1,1\n";
    spill(path, text_of_none, strlen(text_of_none));
    assert_false(trk_log_read(path, &log, error));
    assert_non_null(strstr(error, "steps of 100, which is not a rate of an eye tracker"));
}

/* --- gzip --- */

/* Damaged gzip is refused. If the damage ends the data too soon, the log is read like one that was cut off.
 */
static void damaged_gzip_is_refused(void **state)
{
    (void)state;
    char error[TRK_ERROR_SIZE] = "";
    struct trk_log log;
    size_t size, refusals = 0;
    char *bytes = copy("glasses3.gz", &size);
    for (size_t i = 10; i < size - 8; i++) {
        bytes[i] ^= 0x55;
        spill(path, bytes, size);
        if (trk_log_read(path, &log, error)) {
            assert_non_null(strstr(log.assumed, "gzip data is cut off"));
            trk_log_finish(&log);
        } else {
            assert_non_null(strstr(error, "expected"));
            refusals++;
        }
        bytes[i] ^= 0x55;
    }
    assert_true(refusals > (size - 18) * 9 / 10);
    free(bytes);
}

/* A gzip log cut at any byte gives the rows that are whole, and a note that it was cut off. */
static void cut_gzip_is_read(void **state)
{
    (void)state;
    char error[TRK_ERROR_SIZE] = "";
    struct trk_log log;
    size_t size, last = 0;
    char *bytes = copy("glasses3.gz", &size);
    for (size_t n = 20; n < size; n++) {
        spill(path, bytes, n);
        if (!trk_log_read(path, &log, error)) {
            assert_int_equal(last, 0);
            continue;
        }
        assert_non_null(strstr(log.assumed, "gzip data is cut off"));
        assert_true(log.count >= last);
        last = log.count;
        trk_log_finish(&log);
    }
    assert_int_equal(last, 5);
    free(bytes);
}

int main(void)
{
#define TEST(f) cmocka_unit_test_setup_teardown(f, enter, leave)
    const struct CMUnitTest tests[] = {
        TEST(every_format_says_the_same),
        TEST(formats_can_be_told),
        TEST(impossible_options_are_refused),
        TEST(options_are_followed),
        TEST(points_on_screens),
        TEST(bad_rows_are_refused),
        TEST(bad_sidecars_are_refused),
        TEST(ambiguity_is_refused),
        TEST(units_of_time_are_guessed_or_refused),
        TEST(damaged_gzip_is_refused),
        TEST(cut_gzip_is_read),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
