/* Every log format in the dialects that programs and spreadsheets write: the small logs of
 * tests/fuzz/corpus/log, each changed in one way, must hold the same samples. */
#include "tracker_corpus.h"

#include "tracker.h"
#include "tracker_samples.h"

#include <zlib.h>

enum { ROOM = 65536 };

enum {
    SHORT = 1, /* rows may lack their last fields */
    EXACT = 2, /* a short last row is an error, and not cut off */
    WHOLE = 4  /* numbers have no decimals */
};

/* separator: between the fields of a row; 0 if the file is not a table with a header. */
static const struct log {
    const char *file;
    char separator;
    unsigned traits;
} logs[] = {
    {"own.gaze", 0, EXACT},
    {"sranipal.csv", ';', 0},
    {"sranipal_comma.csv", ',', 0},
    {"sranipal_blanks.txt", 0, 0},
    {"salient360_static.csv", ',', 0},
    {"salient360_dynamic.csv", ',', 0},
    {"pupil_core.csv", ',', 0},
    {"pupil_core_2d.csv", ',', 0},
    {"pupil_cloud.csv", ',', WHOLE},
    {"tobii_lab.tsv", '\t', 0},
    {"tobii_lab_glasses.tsv", '\t', 0},
    {"glasses3.json", 0, 0},
    {"pico.tsv", '\t', 0},
    {"eyelink_bino.asc", 0, 0},
    {"eyelink_mono.asc", 0, 0},
    {"gazepoint.csv", ',', 0},
    {"open_gaze.xml", 0, 0},
    {"gazebase.csv", ',', 0},
    {"gazebase_vr.csv", ',', 0},
    {"pymovements.csv", ',', SHORT},
    {"360em.arff", 0, 0},
    {"bids_screen.txt", 0, 0},
    {"bids_world.txt", 0, 0},
};
enum { LOGS = sizeof logs / sizeof *logs };

/* The log's text, with every line ended by LF. */
static void take(const char *file, char out_text[ROOM])
{
    corpus(file, out_text, ROOM / 4);
    char *to = out_text;
    for (const char *c = out_text; *c; c++)
        if (*c != '\r') *to++ = *c;
    *to = '\0';
}

static void read_as(const char *file, const char *what, const char *text, size_t size,
                    struct trk_log *out_log)
{
    char error[TRK_ERROR_SIZE] = "";
    spill(path, text, size);
    if (!trk_log_read(path, out_log, error)) fail_msg("%s, %s: %s", file, what, error);
}

/* The changed text gives the same samples as the plain one, and the log's notes contain `says`. */
static void holds_the_same(const struct log *log, const char *what, const char *text, size_t size,
                           const char *says)
{
    char plain[ROOM];
    struct trk_log want, got;
    take(log->file, plain);
    read_as(log->file, "plain", plain, strlen(plain), &want);
    read_as(log->file, what, text, size, &got);
    if (!same_samples(&got, &want)) fail_msg("%s, %s: other samples", log->file, what);
    if (!strstr(got.assumed, says))
        fail_msg("%s, %s: '%s' should say '%s'", log->file, what, got.assumed, says);
    trk_log_finish(&got);
    trk_log_finish(&want);
}

/* Replace every `from` in the text by `to`. */
static size_t replace(const char *text, char from, const char *to, char out_text[ROOM])
{
    size_t length = 0;
    for (; *text; text++) {
        if (*text != from)
            out_text[length++] = *text;
        else
            length += (size_t)sprintf(out_text + length, "%s", to);
        assert_true(length < ROOM - 16);
    }
    out_text[length] = '\0';
    return length;
}

static void ends_of_lines(void **state)
{
    (void)state;
    static const char *const ends[] = {"\r\n", "\r\r\n", "\r", "\n\n", "\r\n \t\r\n"};
    char text[ROOM], changed[ROOM];
    for (int i = 0; i < LOGS; i++)
        for (size_t k = 0; k < sizeof ends / sizeof *ends; k++) {
            take(logs[i].file, text);
            size_t size = replace(text, '\n', ends[k], changed);
            holds_the_same(&logs[i], "ends of lines", changed, size, "");
        }
}

static void what_comes_first(void **state)
{
    (void)state;
    static const char *const firsts[] = {"\xef\xbb\xbf", "\n", " \t\r\n\n", "\xef\xbb\xbf\n"};
    char text[ROOM], changed[ROOM];
    for (int i = 0; i < LOGS; i++)
        for (size_t k = 0; k < sizeof firsts / sizeof *firsts; k++) {
            take(logs[i].file, text);
            size_t size = (size_t)snprintf(changed, ROOM, "%s%s", firsts[k], text);
            holds_the_same(&logs[i], "what comes first", changed, size, "");
        }
}

static void separators_that_are_named(void **state)
{
    (void)state;
    static const char *const lines[][2] = {{"sep=", "\n"}, {"\"sep=", "\"\r\n"}, {"\nSEP=", "\n\n"}};
    char text[ROOM], changed[ROOM];
    for (int i = 0; i < LOGS; i++)
        for (size_t k = 0; k < sizeof lines / sizeof *lines && logs[i].separator; k++) {
            take(logs[i].file, text);
            size_t size = (size_t)snprintf(changed, ROOM, "%s%c%s%s", lines[k][0], logs[i].separator,
                                           lines[k][1], text);
            holds_the_same(&logs[i], "a separator that is named", changed, size, "");
        }
}

/* Rows have another separator, and commas instead of decimal points. The header keeps its points, which are
 * part of names. */
static void decimal_commas(void **state)
{
    (void)state;
    static const char *const others[] = {";", "\t"};
    char text[ROOM], head[ROOM], rows[ROOM], changed[ROOM];
    for (int i = 0; i < LOGS; i++)
        for (int k = 0; k < 2 && logs[i].separator; k++) {
            take(logs[i].file, text);
            char *end = strchr(text, '\n');
            *end = '\0';
            replace(text, logs[i].separator, others[k], head);
            replace(end + 1, logs[i].separator, others[k], rows);
            for (char *c = rows; (c = strchr(c, '.'));) *c = ',';
            size_t size = (size_t)snprintf(changed, ROOM, "%s\n%s", head, rows);
            holds_the_same(&logs[i], "decimal commas", changed, size,
                           logs[i].traits & WHOLE ? "" : "commas in numbers are decimal");
        }
}

/* The same for formats that are not tables with a header. Their rows begin with a digit, or are XML elements.
 */
static void decimal_commas_elsewhere(void **state)
{
    (void)state;
    static const char *const files[] = {"eyelink_bino.asc", "eyelink_mono.asc", "open_gaze.xml",
                                        "bids_screen.txt",  "bids_world.txt",   "360em.arff"};
    char text[ROOM];
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        const struct log log = {files[i], 0, 0};
        bool is_row = false;
        take(log.file, text);
        for (char *c = text; *c; c++) {
            if (c == text || c[-1] == '\n') is_row = (*c >= '0' && *c <= '9') || strncmp(c, "<REC", 4) == 0;
            if (is_row && *c == ',') *c = ';';
            /* Only points between digits are decimal: `.` is a lost value, and `.....` are EyeLink's flags.
             */
            if (is_row && *c == '.' && c[-1] >= '0' && c[-1] <= '9' && c[1] >= '0' && c[1] <= '9') *c = ',';
        }
        holds_the_same(&log, "decimal commas", text, strlen(text), "commas in numbers are decimal");
    }
}

/* Every field is quoted; numbers contain a decimal comma, and the separator is a comma too. */
static void quotes(void **state)
{
    (void)state;
    char text[ROOM], changed[ROOM];
    for (int i = 0; i < LOGS; i++) {
        if (!logs[i].separator) continue;
        take(logs[i].file, text);
        size_t size = 0;
        bool is_header = true;
        for (char *at = text; *at;) {
            size_t length = strcspn(at, (char[]){logs[i].separator, '\n', '\0'});
            char end = at[length];
            size += (size_t)sprintf(changed + size, "\"%.*s\"%s", (int)length, at, end == '\n' ? "\n" : ", ");
            for (size_t k = size - length - 3; k < size && !is_header; k++)
                if (changed[k] == '.') changed[k] = ',';
            is_header &= end != '\n';
            at += length + (end != '\0');
        }
        changed[size] = '\0';
        holds_the_same(&logs[i], "quotes", changed, size,
                       logs[i].traits & WHOLE ? "" : "commas in numbers are decimal");
    }
}

/* The first half of the last row is appended once more, without a line end and with one. */
static void ends_that_are_cut_off(void **state)
{
    (void)state;
    char text[ROOM], changed[ROOM];
    for (int i = 0; i < LOGS; i++)
        for (int k = 0; k < 2; k++) {
            take(logs[i].file, text);
            size_t size = strlen(text), last = size - 1;
            while (last > 0 && text[last - 1] != '\n') last--;
            bool is_row = strncmp(&text[last], "END", 3) != 0 && strncmp(&text[last], "MSG", 3) != 0;
            if (k && ((logs[i].traits & (SHORT | EXACT)) || !is_row)) continue;
            size = (size_t)snprintf(changed, ROOM, "%s%.*s%s", text, (int)(size - last) / 2, &text[last],
                                    k ? "\n" : "");
            holds_the_same(&logs[i], "cut off", changed, size, "was cut off and is left out");
        }
}

/* The end of a file after a crash of the machine: it has its full length, but its last bytes are zeros. */
static void zeros_at_the_end(void **state)
{
    (void)state;
    static char text[3 * ROOM];
    for (int i = 0; i < LOGS; i++) {
        memset(text, 0, sizeof text);
        take(logs[i].file, text);
        const size_t size = strlen(text);
        memset(text + size, 0, ROOM - size);
        holds_the_same(&logs[i], "zeros", text, sizeof text, "ends in zero bytes");
        memcpy(text + size, "12", 2);
        holds_the_same(&logs[i], "zeros after a part of a row", text, sizeof text,
                       "was cut off and is left out");
    }
}

static void gzip_that_is_cut_off(void **state)
{
    (void)state;
    char text[ROOM];
    static unsigned char packed[ROOM];
    for (int i = 0; i < LOGS; i++) {
        take(logs[i].file, text);
        gzFile file = gzopen(path, "wb");
        assert_non_null(file);
        assert_true(gzwrite(file, text, (unsigned)strlen(text)) > 0);
        assert_int_equal(gzclose(file), Z_OK);
        FILE *in = fopen(path, "rb");
        size_t size = fread(packed, 1, sizeof packed, in);
        fclose(in);
        holds_the_same(&logs[i], "gzip", (char *)packed, size, "");
        holds_the_same(&logs[i], "gzip that is cut off", (char *)packed, size - 5, "gzip data is cut off");
    }
}

int main(void)
{
#define TEST(f) cmocka_unit_test_setup_teardown(f, enter, leave)
    const struct CMUnitTest tests[] = {
        TEST(ends_of_lines),         TEST(what_comes_first),         TEST(separators_that_are_named),
        TEST(decimal_commas),        TEST(decimal_commas_elsewhere), TEST(quotes),
        TEST(ends_that_are_cut_off), TEST(zeros_at_the_end),         TEST(gzip_that_is_cut_off),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
