/* The project's own gaze log: what is written reads back exactly, and bad input is refused with one clear
 * line. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "log/lines.h"
#include "log/own.h"
#include "log/samples.h"
#include "tracker.h"
#include "tracker_samples.h"
#include "tracker_write.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static char dir[64], path[96];

static int enter(void **state)
{
    (void)state;
    snprintf(dir, sizeof dir, "tracker_log.XXXXXX");
    if (!mkdtemp(dir)) return -1;
    snprintf(path, sizeof path, "%s/x.gaze", dir);
    return 0;
}

static int leave(void **state)
{
    (void)state;
    unlink(path);
    return rmdir(dir);
}

static char *slurp(size_t *out_size)
{
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    char *text = calloc(1, 1 << 20);
    assert_non_null(text);
    *out_size = fread(text, 1, (1 << 20) - 1, file);
    fclose(file);
    return text;
}

static void spill(const void *bytes, size_t size)
{
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

/* The file is refused with one line that names it and contains `where` (":3:" or "") and `why`. */
static void refused(const char *where, const char *why)
{
    char error[TRK_ERROR_SIZE] = "", start[160];
    struct trk_log log;
    assert_false(trk_log_read(path, &log, error));
    assert_null(log.samples);
    assert_int_equal(log.count, 0);
    snprintf(start, sizeof start, "%s%s", path, where);
    if (strncmp(error, start, strlen(start)) != 0 || !strstr(error, why) || strchr(error, '\n') ||
        !strstr(error, "expected"))
        fail_msg("'%s' should start with '%s', say '%s' and what was expected, on one line", error, start,
                 why);
}

/* A small log of n samples. */
static void make(struct trk_log *out_log, size_t n)
{
    assert_true(trk_synthesise(7, (double)n / 120, out_log));
    assert_int_equal(out_log->count, n);
}

/* Write a log of five samples in which `from` in this line (counted from 1) is replaced by `to`. A `from` of
 * NULL stands for the whole line. */
static void write_with(int line, const char *from, const char *to)
{
    struct trk_log log;
    size_t size;
    make(&log, 5);
    assert_true(written(&log, path));
    trk_log_finish(&log);
    char *text = slurp(&size), *start = text;
    for (int i = 1; i < line; i++) start = strchr(start, '\n') + 1;
    char *end = strchr(start, '\n');
    char *at = from ? strstr(start, from) : start;
    assert_true(at && at < end);
    char *rest = from ? at + strlen(from) : end;
    char *changed = NULL;
    int length = asprintf(&changed, "%.*s%s%s", (int)(at - text), text, to, rest);
    assert_true(length > 0);
    spill(changed, (size_t)length);
    free(changed);
    free(text);
}

static void reads_back_exactly(void **state)
{
    (void)state;
    char error[TRK_ERROR_SIZE] = "";
    struct trk_log log, back;
    make(&log, 1200);
    /* Values that need all nine digits, the smallest float, and a sample without any field. */
    struct trk_sample odd = *sample_at(&log, 10), last = *sample_at(&log, 1199);
    odd.head[0] = 16777217.f / 3;
    odd.head[1] = 1e-45f;
    odd.head[2] = -0x1.fffffep127f;
    odd.eye[0].pupil_mm = nextafterf(3.1f, 4);
    assert_true(trk_samples_put(&log, 10, &odd));
    odd = (struct trk_sample){.sequence = 12, .device_ns = 91666666, .arrival_ns = 91666666};
    assert_true(trk_samples_put(&log, 11, &odd));
    last.arrival_ns = INT64_MAX;
    assert_true(trk_samples_put(&log, 1199, &last));
    assert_true(written(&log, path));
    if (!trk_log_read(path, &back, error)) fail_msg("%s", error);
    assert_string_equal(back.format, "fovead");
    assert_true(same_samples(&back, &log));
    trk_log_finish(&back);
    trk_log_finish(&log);
}

static void unset_fields_are_not_written(void **state)
{
    (void)state;
    struct trk_sample sample = {
        .sequence = 1, .direction = {NAN, 1, 2}, .valid = TRK_SCREEN, .screen = {3, 4}};
    char text[TRK_OWN_SIZE], expected[TRK_OWN_SIZE] = "1 0 0 8";
    trk_own_row(&sample, true, text);
    for (int i = 0; i < 29; i++) strcat(expected, " 0");
    assert_string_equal(text, strcat(expected, " 3 4\n"));
    trk_own_row(&sample, false, text);
    strcpy(expected, "1 0 0 0");
    for (int i = 0; i < 29; i++) strcat(expected, " 0");
    assert_string_equal(text, strcat(expected, "\n"));
}

static void comments_and_crlf_pass(void **state)
{
    (void)state;
    char error[TRK_ERROR_SIZE] = "";
    struct trk_log log, back;
    write_with(1, NULL, "fovead-gaze 1\n# who looked");
    size_t size;
    char *text = slurp(&size), *crlf = calloc(2, size);
    size_t length = 0;
    for (size_t i = 0; i < size; i++) {
        if (text[i] == '\n') crlf[length++] = '\r';
        crlf[length++] = text[i];
    }
    spill(crlf, length);
    free(crlf);
    free(text);
    if (!trk_log_read(path, &back, error)) fail_msg("%s", error);
    make(&log, 5);
    assert_true(same_samples(&back, &log));
    trk_log_finish(&back);
    trk_log_finish(&log);
}

static void shipped_recording_is_what_it_says(void **state)
{
    (void)state;
    char error[TRK_ERROR_SIZE] = "";
    struct trk_log log;
    if (!trk_log_read(FIXTURES "/hall.gaze", &log, error)) fail_msg("%s", error);
    assert_int_equal(log.count, 2400);
    float first[3];
    double left = 0, right = 0, down = 0, up = 0, head = 0;
    int blinks = 0;
    bool was_closed = false;
    assert_true(trk_world_direction(sample_at(&log, 0), first));
    assert_true(first[2] < -0.999f);
    for (size_t i = 0; i < log.count; i++) {
        const struct trk_sample *sample = sample_at(&log, i);
        assert_true(sample->valid & TRK_HEAD);
        head = fmax(head, 2 * acos(fmin(1, fabs(sample->head[6]))) * 180 / M_PI);
        bool closed = (sample->valid & TRK_LEFT_OPENNESS) && sample->eye[0].openness == 0;
        blinks += closed && !was_closed;
        was_closed = closed;
        float d[3];
        if (!trk_world_direction(sample, d)) continue;
        double yaw = atan2(d[0], -d[2]) * 180 / M_PI, elevation = asin(d[1]) * 180 / M_PI;
        left = fmin(left, yaw), right = fmax(right, yaw);
        down = fmin(down, elevation), up = fmax(up, elevation);
    }
    assert_true(right - left > 120);
    assert_true(down < -15 && up > 15);
    assert_true(head > 45);
    assert_true(blinks >= 3);
    trk_log_finish(&log);
}

static void missing_and_odd_files(void **state)
{
    (void)state;
    char error[TRK_ERROR_SIZE] = "";
    struct trk_log log;
    refused(": ", "No such file");
    assert_int_equal(mkfifo(path, 0600), 0); /* nobody writes to it: reading must not wait */
    refused(": ", "not a regular file");
    unlink(path);
    assert_false(trk_log_read(".", &log, error));
    assert_non_null(strstr(error, ".: not a regular file"));
    assert_false(trk_log_read("new\nline", &log, error));
    assert_null(strchr(error, '\n'));
    spill("", 0);
    refused(": ", "is empty");
    spill("\n", 1);
    refused(": ", "is empty");
    spill("x,y,z\n1,2,3\n", 12);
    refused(":1: ", "unknown header 'x,y,z', expected 'fovead-gaze 1' or");
}

static void garbage(void **state)
{
    (void)state;
    uint32_t x = 1;
    unsigned char bytes[32768];
    for (size_t i = 0; i < sizeof bytes; i++)
        bytes[i] = (unsigned char)((x = x * 1664525 + 1013904223) >> 24);
    spill(bytes, sizeof bytes);
    refused(":", "");
    bytes[0] = 0;
    spill(bytes, sizeof bytes);
    refused(":1: ", "NUL byte");
    char *line = malloc(2 << 20);
    assert_non_null(line);
    memset(line, 'a', 2 << 20);
    spill(line, 2 << 20);
    free(line);
    refused(":1: ", "longer than");
    write_with(4, NULL, "7 8 9 \x01\xff\xfe");
    refused(":4: ", "4 columns, expected 33");
}

static void bad_headers(void **state)
{
    (void)state;
    write_with(1, "1", "2");
    refused(":1: ", "'fovead-gaze 2', expected 'fovead-gaze 1'");
    write_with(2, "device[ns]", "device[ms]");
    refused(":2: ", "'device[ms]' as column 2, expected 'device[ns]'");
    write_with(2, " head_qw[head-to-world]", "");
    refused(":2: ", "column 33, expected 'head_qw[head-to-world]'");
    write_with(2, "head_qw[head-to-world]", "head_qw[head-to-world] more");
    refused(":2: ", "34 columns, expected 33");
    spill("fovead-gaze 1\n", 14);
    refused(":2: ", "expected 'sequence'");
}

static void bad_rows(void **state)
{
    (void)state;
    write_with(5, NULL, "1 2 3");
    refused(":5: ", "3 columns, expected 33");
    write_with(5, "4087", "zero");
    refused(":5: ", "valid[bits] is 'zero'");
    write_with(5, "4087", "8191");
    refused(":5: ", "8191");
    write_with(5, "4087", "-1");
    refused(":5: ", "'-1'");
    write_with(5, "3 16666666", "3 1666666");
    refused(":5: ", "device time goes back");
    write_with(5, "16666666 4087", "1666666 4087");
    refused(":5: ", "arrival time goes back");
    write_with(5, "3 ", "2 ");
    refused(":5: ", "sequence 2, expected more than 2");
    write_with(5, "16666666", "99999999999999999999");
    refused(":5: ", "device[ns]");
    write_with(5, "16666666", "9999999999999999");
    refused(":5: ", "days");
    write_with(5, " 3.", " 3.x");
    refused(":5: ", "left_pupil[mm]");
    write_with(5, " 3.", "  3.");
    refused(":5: ", "34 columns");
}

/* Line 6 is the fourth sample. Its direction is in fields 5 to 7. */
static void bad_gaze(void **state)
{
    (void)state;
    static const char *const directions[] = {"nan 0 -1", "0 inf -1", "0 0 -1e999",
                                             "0 0 0",    "0 0 -0.9", "0 1 -1"};
    for (size_t i = 0; i < sizeof directions / sizeof *directions; i++) {
        char row[512];
        snprintf(row, sizeof row, "4 25000000 25000000 1 %s%s", directions[i],
                 " 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0");
        write_with(6, NULL, row);
        refused(":6: ", i < 3 ? "expected a finite number" : "direction is not of unit length");
    }
    write_with(6, NULL, "4 25000000 25000000 4 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0");
    refused(":6: ", "head_q is not of unit length");
}

static void no_rows(void **state)
{
    (void)state;
    write_with(3, NULL, "#");
    size_t size;
    char *text = slurp(&size);
    spill(text, (size_t)(strchr(text, '#') - text));
    free(text);
    refused(": ", "holds no samples");
}

/* A log that is cut anywhere after its first row is read up to its last whole row. */
static void cut_off(void **state)
{
    (void)state;
    char error[TRK_ERROR_SIZE];
    size_t size, header = 0;
    write_with(1, "1", "1");
    char *text = slurp(&size);
    for (int line = 0; line < 3; header++) line += text[header] == '\n';
    for (size_t n = 0, rows = 0; n <= size; n++) {
        struct trk_log log;
        spill(text, n);
        if (n > header) rows += text[n - 1] == '\n';
        if (n == header) rows = 1;
        bool ok = trk_log_read(path, &log, error);
        assert_int_equal(ok, n >= header);
        assert_int_equal(log.count, rows);
        trk_log_finish(&log);
    }
    free(text);
}

static void full_disk(void **state)
{
    (void)state;
    struct trk_log log;
    make(&log, 2);
    assert_false(written(&log, "/dev/full"));
    trk_log_finish(&log);
}

/* Every number is written as printf() writes it with the fewest digits, six or more, that read back as the
 * same float. */
static void fewest_digits(void **state)
{
    (void)state;
    static const float edges[] = {0,         -0.f, 1,    -1,     0.1f,    9.9999997e-5f, 1e-4f, 9.9999996f,
                                  999999.9f, 1e6f, 1e5f, 1e-45f, 3.4e38f, 123456.7f,     0.5f,  -2.5e-3f};
    enum { EDGES = sizeof edges / sizeof *edges, COUNT = 60000 };
    static char text[16384];
    uint64_t noise = 1;
    for (size_t i = 0; i < EDGES + COUNT; i++) {
        noise = noise * 6364136223846793005u + 1442695040888963407u;
        const int32_t drawn = (int32_t)(noise >> 32);
        float value = i < EDGES ? edges[i]
                      : i % 2   ? (float)drawn * 0x1p-31f
                                : (float)(drawn % 2000000) * 1e-3f;
        if (i % 7 == 6) memcpy(&value, &drawn, sizeof value);
        if (!isfinite(value)) continue;
        struct trk_sample sample = {.sequence = 1, .valid = TRK_SCREEN, .screen = {0.25f, value}};
        char expected[32];
        for (int digits = 6; digits <= 9; digits++) {
            snprintf(expected, sizeof expected, " %.*g\n", digits, (double)value);
            if (strtof(expected, NULL) == value) break;
        }
        assert_in_range(trk_own_row(&sample, true, text), 1, sizeof text - 1);
        assert_string_equal(strrchr(text, ' '), expected);
    }
}

/* Our functions read the text as strtod() and strtof() do. */
static void reads_as_the_library(const char *text)
{
    double value = NAN;
    float small = NAN;
    char *end;
    const double expected = strtod(text, &end);
    const float expected_small = strtof(text, NULL);
    const bool is_number = end != text && !*end;
    if (trk_parse_double(text, &value) != is_number || trk_parse_float(text, &small) != is_number)
        fail_msg("'%s': expected %s", text, is_number ? "a number" : "no number");
    if (!is_number) return;
    if (memcmp(&value, &expected, sizeof value) != 0 || memcmp(&small, &expected_small, sizeof small) != 0)
        fail_msg("'%s' is %.17g and %.9g, expected %.17g and %.9g", text, value, (double)small, expected,
                 (double)expected_small);
}

static void numbers_of_all_lengths(void **state)
{
    (void)state;
    static const char *const odd[] = {
        "0",        "-0",       "-0.0",  "00.50",  "5.",   ".5",  "-.5",   ".",    "-",          "",   "--1",
        "1.2.3",    "1x",       "1e3",   "1.5e-7", "+1",   "1,5", "0x1p3", "inf",  "nan",        "-.", "1 ",
        "16777217", "16777219", "1e999", "1e-999", "9.5-", "1-",  "1.",    "1.e2", "33554435.0", "0.1"};
    char text[80];
    uint64_t noise = 1;
    for (size_t i = 0; i < sizeof odd / sizeof *odd; i++) reads_as_the_library(odd[i]);
    for (int i = 0; i < 200000; i++) {
        noise = noise * 6364136223846793005u + 1442695040888963407u;
        const int digits = 1 + i % 20, point = i / 20 % 21;
        char number[24];
        snprintf(number, sizeof number, "%020llu", (unsigned long long)(noise | UINT64_C(1) << 63));
        snprintf(text, sizeof text, "%s%.*s.%.*s", i % 3 ? "" : "-", point < digits ? point : digits, number,
                 point < digits ? digits - point : 0, number + point);
        reads_as_the_library(text);
    }
    /* Numbers beside the middle of two floats: some of them round to the middle as a double, and would then
     * round to the wrong float. */
    for (int i = 0; i < 20000; i++) {
        noise = noise * 6364136223846793005u + 1442695040888963407u;
        const float value = (float)(noise >> 40) * 0x1p-21f + 0.1f;
        snprintf(text, sizeof text, "%.15g", ((double)value + (double)nextafterf(value, 9)) / 2);
        reads_as_the_library(text);
    }
}

int main(void)
{
#define TEST(f) cmocka_unit_test_setup_teardown(f, enter, leave)
    const struct CMUnitTest tests[] = {
        TEST(fewest_digits),
        TEST(numbers_of_all_lengths),
        TEST(reads_back_exactly),
        TEST(unset_fields_are_not_written),
        TEST(comments_and_crlf_pass),
        TEST(shipped_recording_is_what_it_says),
        TEST(missing_and_odd_files),
        TEST(garbage),
        TEST(bad_headers),
        TEST(bad_rows),
        TEST(bad_gaze),
        TEST(no_rows),
        TEST(cut_off),
        TEST(full_disk),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
