/* Captures of devices, named by vendor and product, are compared with the samples in the file beside them. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "hid_report.h"
#include "psvr2_packet.h"

#include <ctype.h>
#include <glob.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define GOLDEN FIXTURES "/../tests/device/golden/"

enum { LINE = 16384, VALUES = 25 };

struct capture {
    FILE *reports, *samples;
    struct trk_screen screen;
    struct trk_hid_layout layout;
    bool is_hid;
};

static size_t take_hex(const char *text, uint8_t *out)
{
    size_t count = 0;
    unsigned byte;
    while (isxdigit((unsigned char)text[0]) && sscanf(text, "%2x", &byte) == 1) {
        out[count++] = (uint8_t)byte;
        text += 2;
    }
    return count;
}

/* The next line that is not a comment. */
static bool next_line(FILE *file, char line[LINE])
{
    while (fgets(line, LINE, file))
        if (line[0] != '#') return true;
    return false;
}

/* The numbers of a sample in the order of the golden files. Invalid ones are NAN. */
static void list(const struct trk_sample *sample, double out[VALUES])
{
    int n = 0;
    const struct {
        uint32_t bit;
        const float *value;
        int count;
    } fields[] = {
        {TRK_DIRECTION, sample->direction, 3},
        {TRK_ORIGIN, sample->origin, 3},
        {TRK_LEFT_DIRECTION, sample->eye[0].direction, 3},
        {TRK_LEFT_ORIGIN, sample->eye[0].origin, 3},
        {TRK_LEFT_OPENNESS, &sample->eye[0].openness, 1},
        {TRK_LEFT_PUPIL, &sample->eye[0].pupil_mm, 1},
        {TRK_RIGHT_DIRECTION, sample->eye[1].direction, 3},
        {TRK_RIGHT_ORIGIN, sample->eye[1].origin, 3},
        {TRK_RIGHT_OPENNESS, &sample->eye[1].openness, 1},
        {TRK_RIGHT_PUPIL, &sample->eye[1].pupil_mm, 1},
        {TRK_SCREEN, sample->screen, 2},
    };
    for (size_t i = 0; i < sizeof fields / sizeof *fields; i++)
        for (int k = 0; k < fields[i].count; k++)
            out[n++] = sample->valid & fields[i].bit ? (double)fields[i].value[k] : NAN;
    assert_int_equal(n, VALUES - 1);
}

static void compare(const char *path, int row, const struct trk_sample *sample, uint64_t ticks,
                    char *expected)
{
    double values[VALUES];
    list(sample, values);
    char *word = strtok(expected, " \n");
    assert_non_null(word);
    if (strtoull(word, NULL, 10) != ticks)
        fail_msg("%s, report %d: ticks %llu", path, row, (unsigned long long)ticks);
    for (int i = 0; i < VALUES - 1; i++) {
        assert_non_null(word = strtok(NULL, " \n"));
        bool none = strcmp(word, "-") == 0;
        if (none != (bool)isnan(values[i]) || (!none && fabs(atof(word) - values[i]) > 2e-6))
            fail_msg("%s, report %d, value %d: %g, expected %s", path, row, i, values[i], word);
    }
    assert_null(strtok(NULL, " \n"));
}

static int compare_all(struct capture *capture, const char *path)
{
    static char line[LINE], expected[LINE];
    static uint8_t bytes[LINE];
    char error[TRK_ERROR_SIZE];
    int rows = 0;
    while (next_line(capture->reports, line)) {
        struct trk_sample sample = {0};
        struct trk_hid_values values;
        uint32_t clock = 0;
        if (strncmp(line, "screen ", 7) == 0) {
            assert_int_equal(sscanf(line + 7, "%f %f %f", &capture->screen.width_m, &capture->screen.height_m,
                                    &capture->screen.distance_m),
                             3);
        } else if (strncmp(line, "descriptor ", 11) == 0) {
            capture->is_hid = trk_hid_parse(bytes, take_hex(line + 11, bytes), &capture->layout, error);
            assert_true(capture->is_hid);
        } else if (strncmp(line, "report ", 7) == 0) {
            size_t size = take_hex(line + 7, bytes);
            bool ok = capture->is_hid ? trk_hid_decode(&capture->layout, TRK_HID_INPUT, bytes, size, &values)
                                      : trk_packet_parse(&trk_psvr2_layout, bytes, size, &sample, &clock);
            assert_true(ok);
            if (capture->is_hid) trk_hid_sample(&values, &capture->screen, &sample);
            assert_true(next_line(capture->samples, expected));
            compare(path, ++rows, &sample, capture->is_hid ? values.ticks : clock, expected);
        }
    }
    assert_false(next_line(capture->samples, expected));
    return rows;
}

static void captures_decode_to_their_samples(void **state)
{
    (void)state;
    glob_t found;
    assert_int_equal(glob(GOLDEN "*.capture", 0, NULL, &found), 0);
    assert_true(found.gl_pathc >= 3);
    for (size_t i = 0; i < found.gl_pathc; i++) {
        static struct capture capture;
        char samples[4096];
        memset(&capture, 0, sizeof capture);
        snprintf(samples, sizeof samples, "%.*s.samples",
                 (int)(strlen(found.gl_pathv[i]) - strlen(".capture")), found.gl_pathv[i]);
        assert_non_null(capture.reports = fopen(found.gl_pathv[i], "r"));
        assert_non_null(capture.samples = fopen(samples, "r"));
        assert_true(compare_all(&capture, found.gl_pathv[i]) >= 5);
        fclose(capture.reports);
        fclose(capture.samples);
    }
    globfree(&found);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(captures_decode_to_their_samples)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
