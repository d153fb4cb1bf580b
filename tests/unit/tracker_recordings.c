/* Every log in the shared data is read, with the known number of samples, span and rate, and gaze points to
 * the right and up when the eye looked to the right and up. Skipped where that data is absent. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "tracker.h"
#include "tracker_samples.h"

#include <cglm/cglm.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define GAZE SHARED_DATA "/gaze/"

static void present_or_skip(const char *path)
{
    if (access(path, R_OK) == 0) return;
    print_message("no %s here\n", path);
    skip();
}

static void read_or_skip(const char *path, struct trk_log *out_log)
{
    char error[TRK_ERROR_SIZE] = "";
    present_or_skip(path);
    if (!trk_log_read(path, out_log, error)) fail_msg("%s", error);
}

static double yaw_deg(const float v[3])
{
    return atan2(v[0], -v[2]) * 180 / M_PI;
}

static double pitch_deg(const float v[3])
{
    return asin(fmin(fmax(v[1], -1), 1)) * 180 / M_PI;
}

static int by_size(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* --- figures --- */

/* How the figures are known: rows are counted in the file; lost samples are those with a flag, dots or empty
 * fields; the span is from the first time to the last; step_ms is the median step. */
static const struct figures {
    const char *path, *format;
    size_t rows, lost, left, right, heads;
    double span_s, step_ms;
    const char *assumed;
} recordings[] = {
    {"htc-vive-pro-eye/TESTNA01_360VR_Fist3.csv", "HTC SRanipal", 1665, 32, 1633, 1632, 1665, 13.864, 8, ""},
    {"htc-vive-pro-eye/TESTNA05_360VR_Spread7.csv", "HTC SRanipal", 1337, 49, 1285, 1282, 1337, 11.131, 8,
     ""},
    {"pupil-invisible/trampoline_02_gaze.csv", "Pupil Cloud", 5338, 2103, 0, 0, 0, 26.751992, 4.022,
     "in blinks, counted as lost: 2103"},
    {"salient360/rawDataStatic1.csv", "Salient360 static", 1412, 0, 1412, 1406, 1412, 11.755599, 8.321,
     "mean of the eyes"},
    {"salient360/rawDataDyn1_first1499.csv", "Salient360 dynamic", 1499, 65, 1427, 1430, 1499, 5.987995935,
     3.9991, "comma was put back: 1499"},
    {"eyelink-asc/bino1000.asc", "EyeLink ASC", 3467, 0, 3467, 3467, 0, 9.081, 1, "35.2 px per degree"},
    {"eyelink-asc/mono2000.asc", "EyeLink ASC", 8976, 0, 0, 8976, 0, 10.3255, 0.5, "at 2000 Hz: 4488"},
    {"eyelink-asc/mono250.asc", "EyeLink ASC", 914, 0, 914, 0, 0, 10.168, 4, "35.2 px per degree"},
    {"eyelink-asc/monoRemote250.asc", "EyeLink ASC", 5129, 0, 5129, 0, 0, 25.004, 4, "37.2 px per degree"},
    {"pymovements/eyelink_binocular_example.asc", "EyeLink ASC", 368, 80, 271, 288, 0, 0.367, 1,
     "47.8 px per degree"},
    {"pymovements/eyelink_monocular_2khz_example.asc", "EyeLink ASC", 16, 0, 16, 0, 0, 184.7345, 3.5,
     "37.2 px"},
    {"pymovements/eyelink_monocular_example.asc", "EyeLink ASC", 16, 0, 16, 0, 0, 184.735, 3, "37.2 px"},
    {"pymovements/eyelink_monocular_no_dummy_example.asc", "EyeLink ASC", 297, 69, 228, 0, 0, 8.09, 2,
     "screen 43.6 degrees"},
    {"pymovements/gazebase_example.csv", "GazeBase", 10, 0, 0, 0, 0, 0.009, 1, ""},
    {"pymovements/gazebase_vr_example.csv", "GazeBaseVR", 10, 0, 10, 10, 0, 0.035943, 3.9894, ""},
    {"pymovements/missing_values_example.csv", "pymovements", 103, 101, 0, 0, 0, 0.101, 1, "time is in ms"},
};

static double middle_step_ms(const struct trk_log *log)
{
    double *steps = malloc(log->count * sizeof *steps), middle;
    assert_non_null(steps);
    for (size_t i = 1; i < log->count; i++)
        steps[i - 1] = (double)(sample_at(log, i)->device_ns - sample_at(log, i - 1)->device_ns) / 1e6;
    qsort(steps, log->count - 1, sizeof *steps, by_size);
    middle = steps[(log->count - 1) / 2];
    free(steps);
    return middle;
}

static size_t count(const struct trk_log *log, uint32_t bit)
{
    size_t n = 0;
    for (size_t i = 0; i < log->count; i++) n += (sample_at(log, i)->valid & bit) != 0;
    return n;
}

static void figures_are_those_of_the_files(void **state)
{
    (void)state;
    present_or_skip(GAZE);
    for (size_t i = 0; i < sizeof recordings / sizeof *recordings; i++) {
        const struct figures *want = &recordings[i];
        char path[512];
        struct trk_log log;
        snprintf(path, sizeof path, GAZE "%s", want->path);
        read_or_skip(path, &log);
        double span_s = (double)sample_at(&log, log.count - 1)->device_ns / 1e9,
               step_ms = middle_step_ms(&log);
        print_message("%s: %zu rows, %zu lost, %.3f s, steps of %.4g ms\n", want->path, log.count,
                      log.count - count(&log, TRK_DIRECTION), span_s, step_ms);
        assert_string_equal(log.format, want->format);
        assert_int_equal(log.count, want->rows);
        assert_int_equal(count(&log, TRK_DIRECTION), want->rows - want->lost);
        assert_int_equal(count(&log, TRK_LEFT_DIRECTION), want->left);
        assert_int_equal(count(&log, TRK_RIGHT_DIRECTION), want->right);
        assert_int_equal(count(&log, TRK_HEAD), want->heads);
        assert_float_equal(span_s, want->span_s, 1e-6);
        assert_float_equal(step_ms, want->step_ms, 1e-3);
        assert_non_null(strstr(log.assumed, want->assumed));
        trk_log_finish(&log);
    }
}

static void others_are_refused_by_name(void **state)
{
    (void)state;
    static const struct {
        const char *path, *says;
    } files[] = {
        {GAZE "htc-vive-pro-eye/TESTVA03_2D_Spread9.csv", "holds no samples"},
        {GAZE "pupil-invisible/trampoline_02_blinks.csv", "is Pupil Cloud's blinks, expected its gaze.csv"},
        {GAZE "pupil-invisible/trampoline_02_imu.csv", "is Pupil Cloud's IMU, expected its gaze.csv"},
    };
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        char error[TRK_ERROR_SIZE] = "";
        struct trk_log log;
        present_or_skip(files[i].path);
        assert_false(trk_log_read(files[i].path, &log, error));
        assert_non_null(strstr(error, files[i].says));
    }
}

/* --- signs --- */

/* What the vestibulo-ocular reflex, which holds the eye on its target, shows in steps of 50 ms without a
 * saccade. */
struct reflex {
    double yaw, pitch;  /* slope of eye against head movement: -1 is perfect */
    double world[2][2]; /* median movement of gaze in the world, with x and y as read or mirrored */
};

static double world_step_deg(const struct trk_sample *a, const struct trk_sample *b, bool turn_x, bool turn_y)
{
    struct trk_sample pair[2] = {*a, *b};
    float world[2][3];
    for (int i = 0; i < 2; i++) {
        pair[i].direction[0] *= turn_x ? -1 : 1;
        pair[i].direction[1] *= turn_y ? -1 : 1;
        assert_true(trk_world_direction(&pair[i], world[i]));
    }
    return acos(fmin(1, (double)glm_vec3_dot(world[0], world[1]))) * 180 / M_PI;
}

/* How far the head turns from a to b, in its own frame: degrees to the right and up. */
static void head_step_deg(const struct trk_sample *a, const struct trk_sample *b, double *out_yaw,
                          double *out_pitch)
{
    versor from, to, step;
    memcpy(from, &a->head[3], sizeof from);
    memcpy(to, &b->head[3], sizeof to);
    glm_quat_inv(from, from);
    glm_quat_mul(from, to, step);
    double sign = step[3] < 0 ? -2 : 2;
    *out_yaw = -sign * step[1] * 180 / M_PI;
    *out_pitch = sign * step[0] * 180 / M_PI;
}

static void measure_reflex(const struct trk_log *log, struct reflex *out_reflex)
{
    double hh[2] = {0}, he[2] = {0}, *steps[4];
    size_t n = 0;
    for (int k = 0; k < 4; k++) assert_non_null(steps[k] = malloc(log->count * sizeof(double)));
    for (size_t from = 0, to = 1; to < log->count; to++) {
        while (sample_at(log, to)->device_ns - sample_at(log, from)->device_ns > 50000000) from++;
        const struct trk_sample *a = sample_at(log, from), *b = sample_at(log, to);
        float gaze[3];
        if (!trk_gaze_direction(a, gaze, NULL) || !trk_gaze_direction(b, gaze, NULL)) continue;
        if (!(a->valid & b->valid & TRK_DIRECTION) || b->device_ns - a->device_ns < 40000000) continue;
        double head[2], eye[2] = {yaw_deg(b->direction) - yaw_deg(a->direction),
                                  pitch_deg(b->direction) - pitch_deg(a->direction)};
        if (fabs(eye[0]) > 3 || fabs(eye[1]) > 3) continue;
        head_step_deg(a, b, &head[0], &head[1]);
        for (int k = 0; k < 2; k++) {
            if (fabs(head[k]) < 0.5) continue;
            hh[k] += head[k] * head[k];
            he[k] += head[k] * eye[k];
        }
        for (int k = 0; k < 4; k++) steps[k][n] = world_step_deg(a, b, k & 1, k & 2);
        n++;
    }
    assert_true(n > 500);
    *out_reflex = (struct reflex){.yaw = he[0] / hh[0], .pitch = he[1] / hh[1]};
    for (int k = 0; k < 4; k++) {
        qsort(steps[k], n, sizeof(double), by_size);
        out_reflex->world[k & 1][k >> 1] = steps[k][n / 2];
        free(steps[k]);
    }
}

static void eyes_hold_while_the_head_turns(void **state)
{
    (void)state;
    static const char *const paths[] = {
        GAZE "salient360/rawDataStatic1.csv",
        GAZE "salient360/rawDataDyn1_first1499.csv",
        GAZE "htc-vive-pro-eye/TESTNA01_360VR_Fist3.csv",
        GAZE "htc-vive-pro-eye/TESTNA05_360VR_Spread7.csv",
    };
    for (size_t i = 0; i < sizeof paths / sizeof *paths; i++) {
        struct trk_log log;
        struct reflex reflex;
        read_or_skip(paths[i], &log);
        measure_reflex(&log, &reflex);
        print_message("%s: eye against head %.2f in yaw, %.2f in pitch; gaze moves %.2f degrees in 50 ms, "
                      "with x turned "
                      "round %.2f, with y %.2f\n",
                      paths[i], reflex.yaw, reflex.pitch, reflex.world[0][0], reflex.world[1][0],
                      reflex.world[0][1]);
        assert_true(reflex.yaw < -0.35 && reflex.pitch < -0.35);
        assert_true(reflex.world[0][0] * 1.5 < reflex.world[1][0]);
        assert_true(reflex.world[0][0] * 1.05 < reflex.world[0][1]);
        trk_log_finish(&log);
    }
}

/* The file's own mean columns are not used, because they stay still while the eyes move: the combined gaze is
 * the mean of the eyes. */
static void static_mean_is_the_eyes(void **state)
{
    (void)state;
    struct trk_log log;
    read_or_skip(GAZE "salient360/rawDataStatic1.csv", &log);
    for (size_t i = 0; i < log.count; i++) {
        assert_true(sample_at(&log, i)->direction[2] < -0.7f);
        assert_true(sample_at(&log, i)->eye[0].origin[0] < -0.02f);
    }
    trk_log_finish(&log);
}

/* While a lid closes, the eye rolls down and towards the nose. */
static void blink_rolls_down_and_inwards(void **state)
{
    (void)state;
    struct trk_log log;
    read_or_skip(GAZE "pymovements/eyelink_binocular_example.asc", &log);
    for (int eye = 0; eye < 2; eye++) {
        uint32_t bit = TRK_LEFT_DIRECTION << 4 * eye;
        size_t lost = 0;
        while (sample_at(&log, lost)->valid & bit) lost++;
        const float *before = sample_at(&log, lost - 20)->eye[eye].direction;
        const float *last = sample_at(&log, lost - 1)->eye[eye].direction;
        print_message("eye %d: the blink moves it %.2f degrees to the right and %.2f up\n", eye,
                      yaw_deg(last) - yaw_deg(before), pitch_deg(last) - pitch_deg(before));
        assert_true(pitch_deg(last) < pitch_deg(before) - 0.5);
        assert_true((yaw_deg(last) - yaw_deg(before)) * (eye ? -1 : 1) > 0.15);
        assert_true(sample_at(&log, lost + 10)->valid & TRK_LEFT_OPENNESS << 4 * eye);
        assert_true(sample_at(&log, lost + 10)->eye[eye].openness == 0);
    }
    trk_log_finish(&log);
}

/* The target is 0.44 m ahead, so both eyes turn inwards. */
static void eyes_converge(void **state)
{
    (void)state;
    struct trk_log log;
    read_or_skip(GAZE "pymovements/gazebase_vr_example.csv", &log);
    for (size_t i = 0; i < log.count; i++) {
        const struct trk_eye *eye = sample_at(&log, i)->eye;
        assert_true(eye[0].origin[0] < -0.03f && eye[1].origin[0] > 0.03f);
        assert_true(yaw_deg(eye[0].direction) > 3 && yaw_deg(eye[1].direction) < -2);
    }
    trk_log_finish(&log);
}

/* A column of a comma-separated line as a number; NaN if it is empty. */
static double field(const char *line, int column)
{
    for (; column > 0 && line; column--) line = strchr(line, ',') ? strchr(line, ',') + 1 : NULL;
    return line && *line != ',' ? strtod(line, NULL) : NAN;
}

/* The gyroscope's rate about the axis that points down, so that a turn of the head to the right is positive:
 * where the wearer stands, the accelerometer reads -0.9 g along that axis. Mean over 40 ms around time_ns. */
static double gyro_deg_s(FILE *file, double time_ns)
{
    static char line[1024];
    static double sum, count;
    sum = count = 0;
    rewind(file);
    while (fgets(line, sizeof line, file)) {
        double at_ns = field(line, 2);
        if (!(fabs(at_ns - time_ns) < 20e6)) continue;
        sum += field(line, 4);
        count++;
    }
    return count > 0 ? sum / count : NAN;
}

static void glasses_lag_behind_the_gyroscope(void **state)
{
    (void)state;
    const double first_ns = 1629390345036471431.0;
    struct trk_log log;
    double hh = 0, he = 0, ee = 0;
    read_or_skip(GAZE "pupil-invisible/trampoline_02_gaze.csv", &log);
    present_or_skip(GAZE "pupil-invisible/trampoline_02_imu.csv");
    FILE *imu = fopen(GAZE "pupil-invisible/trampoline_02_imu.csv", "r");
    assert_non_null(imu);
    for (size_t i = 5; i + 5 < log.count; i += 5) {
        const struct trk_sample *a = sample_at(&log, i - 5), *b = sample_at(&log, i + 5);
        if (!(a->valid & b->valid & sample_at(&log, i)->valid & TRK_DIRECTION)) continue;
        double seconds = (double)(b->device_ns - a->device_ns) / 1e9;
        double eye = (yaw_deg(b->direction) - yaw_deg(a->direction)) / seconds;
        if (seconds > 0.06 || fabs(eye) > 120) continue;
        double head = gyro_deg_s(imu, first_ns + (double)sample_at(&log, i)->device_ns);
        if (!(fabs(head) > 10 && fabs(head) < 80)) continue;
        hh += head * head;
        he += head * eye;
        ee += eye * eye;
    }
    fclose(imu);
    print_message("azimuth against the gyroscope: slope %.2f, correlation %.2f\n", he / hh,
                  he / sqrt(hh * ee));
    assert_true(he / sqrt(hh * ee) < -0.15);
    trk_log_finish(&log);
}

/* In the glasses' picture, x and y count from the top left corner. */
static void glasses_agree_with_their_picture(void **state)
{
    (void)state;
    struct trk_log log;
    read_or_skip(GAZE "pupil-invisible/trampoline_02_gaze.csv", &log);
    FILE *file = fopen(GAZE "pupil-invisible/trampoline_02_gaze.csv", "r");
    char line[1024];
    assert_non_null(file);
    assert_non_null(fgets(line, sizeof line, file));
    for (size_t i = 0; i < log.count; i++) {
        assert_non_null(fgets(line, sizeof line, file));
        if (!(sample_at(&log, i)->valid & TRK_DIRECTION)) continue;
        double x = field(line, 3) - 544, y = field(line, 4) - 544;
        if (fabs(x) > 100) assert_true(x * yaw_deg(sample_at(&log, i)->direction) > 0);
        if (fabs(y) > 100) assert_true(y * pitch_deg(sample_at(&log, i)->direction) < 0);
    }
    fclose(file);
    trk_log_finish(&log);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(figures_are_those_of_the_files),
        cmocka_unit_test(others_are_refused_by_name),
        cmocka_unit_test(eyes_hold_while_the_head_turns),
        cmocka_unit_test(static_mean_is_the_eyes),
        cmocka_unit_test(blink_rolls_down_and_inwards),
        cmocka_unit_test(eyes_converge),
        cmocka_unit_test(glasses_lag_behind_the_gyroscope),
        cmocka_unit_test(glasses_agree_with_their_picture),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
