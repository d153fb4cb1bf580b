/* Reading and writing the project's own gaze logs; both use the same table of columns. own.h describes the
 * format. */
#include "log/own.h"

#include "error.h"
#include "log/formats.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MAGIC     "fovead-gaze "
#define VERSION   "1"
#define SEPARATOR ' '

/* The columns before those of the table: whole numbers, present in every log. */
enum { SEQUENCE, DEVICE, ARRIVAL, VALID, WHOLE };
static const char *const whole_names[WHOLE] = {"sequence", "device[ns]", "arrival[ns]", "valid[bits]"};

static const struct column {
    const char *name;
    size_t offset; /* of a float in struct trk_sample */
    uint32_t bit;  /* of trk_sample.valid: the value is valid */
} columns[] = {
#define COLUMN(name, member, bit)                                                                            \
    {                                                                                                        \
        name, offsetof(struct trk_sample, member), bit                                                       \
    }
#define VECTOR(name, unit, member, bit)                                                                      \
    COLUMN(name "_x[" unit "]", member[0], bit), COLUMN(name "_y[" unit "]", member[1], bit),                \
        COLUMN(name "_z[" unit "]", member[2], bit)
#define EYE(name, index, SIDE)                                                                               \
    VECTOR(name "_direction", "head", eye[index].direction, TRK_##SIDE##_DIRECTION),                         \
        VECTOR(name "_origin", "head,m", eye[index].origin, TRK_##SIDE##_ORIGIN),                            \
        COLUMN(name "_openness[0..1]", eye[index].openness, TRK_##SIDE##_OPENNESS),                          \
        COLUMN(name "_pupil[mm]", eye[index].pupil_mm, TRK_##SIDE##_PUPIL)
    VECTOR("direction", "head", direction, TRK_DIRECTION),
    VECTOR("origin", "head,m", origin, TRK_ORIGIN),
    EYE("left", 0, LEFT),
    EYE("right", 1, RIGHT),
    VECTOR("head", "world,m", head, TRK_HEAD),
    COLUMN("head_qx[head-to-world]", head[3], TRK_HEAD),
    COLUMN("head_qy[head-to-world]", head[4], TRK_HEAD),
    COLUMN("head_qz[head-to-world]", head[5], TRK_HEAD),
    COLUMN("head_qw[head-to-world]", head[6], TRK_HEAD),
    COLUMN("screen_x[0..1]", screen[0], TRK_SCREEN),
    COLUMN("screen_y[0..1]", screen[1], TRK_SCREEN),
};
/* Only logs of trackers with a screen have the last two columns. */
enum {
    COLUMNS = sizeof columns / sizeof *columns,
    PLAIN = WHOLE + COLUMNS - 2,
    WITH_SCREEN = WHOLE + COLUMNS
};

/* The vectors that must have unit length if their bit is set. */
static const struct unit {
    uint32_t bit;
    const char *name;
    size_t offset;
    int size;
} units[] = {
    {TRK_DIRECTION, "direction", offsetof(struct trk_sample, direction), 3},
    {TRK_LEFT_DIRECTION, "left_direction", offsetof(struct trk_sample, eye[0].direction), 3},
    {TRK_RIGHT_DIRECTION, "right_direction", offsetof(struct trk_sample, eye[1].direction), 3},
    {TRK_HEAD, "head_q", offsetof(struct trk_sample, head[3]), 4},
};

static const uint32_t all_bits =
    TRK_DIRECTION | TRK_ORIGIN | TRK_HEAD | TRK_SCREEN | 0xff0; /* the eyes: bits 4 to 11 */

static const char *column_name(size_t index)
{
    return index < WHOLE ? whole_names[index] : columns[index - WHOLE].name;
}

/* --- reading --- */

static bool detect(const struct trk_reading *reading)
{
    return strncmp(reading->lines.text, MAGIC, strlen(MAGIC)) == 0;
}

static bool read_header(struct trk_reading *reading, size_t *out_columns, char out_error[TRK_ERROR_SIZE])
{
    struct trk_lines *lines = &reading->lines;
    if (strcmp(lines->text, MAGIC VERSION) != 0)
        return trk_lines_fail(lines, out_error, "'%.40s', expected '" MAGIC VERSION "'", lines->text);
    enum trk_line line;
    do {
        line = trk_next_row(reading, out_error);
    } while (line == TRK_LINE && lines->text[0] == '#');
    if (line == TRK_LINE_FAILED) return false;
    if (line == TRK_LINE_END) lines->text[0] = '\0';

    char *fields[TRK_MAX_FIELDS];
    size_t count = trk_split(lines->text, SEPARATOR, fields);
    *out_columns = count >= WITH_SCREEN ? WITH_SCREEN : PLAIN;
    for (size_t i = 0; i < *out_columns; i++)
        if (i >= count || strcmp(fields[i], column_name(i)) != 0)
            return trk_lines_fail(lines, out_error, "header has '%.40s' as column %zu, expected '%s'",
                                  i < count ? fields[i] : "", i + 1, column_name(i));
    if (count > *out_columns)
        return trk_lines_fail(lines, out_error, "header has %zu columns, expected %zu", count, *out_columns);
    return true;
}

static bool read_row(struct trk_lines *lines, size_t expected, struct trk_sample *out_sample,
                     char out_error[TRK_ERROR_SIZE])
{
    char *fields[TRK_MAX_FIELDS];
    size_t count = trk_split(lines->text, SEPARATOR, fields);
    if (count != expected)
        return trk_lines_fail(lines, out_error, "%zu columns, expected %zu", count, expected);

    int64_t whole[WHOLE];
    for (int i = 0; i < WHOLE; i++)
        if (!trk_parse_int64(fields[i], &whole[i]) || whole[i] < 0)
            return trk_lines_fail(lines, out_error, "%s is '%.40s', expected a whole number from 0",
                                  whole_names[i], fields[i]);
    if ((uint64_t)whole[VALID] & ~(uint64_t)all_bits)
        return trk_lines_fail(lines, out_error, "valid[bits] is %s, expected only bits of %" PRIu32,
                              fields[VALID], all_bits);
    *out_sample = (struct trk_sample){
        .sequence = (uint64_t)whole[SEQUENCE],
        .device_ns = (uint64_t)whole[DEVICE],
        .arrival_ns = (uint64_t)whole[ARRIVAL],
        .valid = (uint32_t)whole[VALID],
    };
    for (size_t i = 0; i < expected - WHOLE; i++) {
        float value;
        if (!trk_parse_float(fields[WHOLE + i], &value) || !isfinite(value))
            return trk_lines_fail(lines, out_error, "%s is '%.40s', expected a finite number",
                                  columns[i].name, fields[WHOLE + i]);
        if (out_sample->valid & columns[i].bit)
            memcpy((char *)out_sample + columns[i].offset, &value, sizeof value);
    }
    for (size_t i = 0; i < sizeof units / sizeof *units; i++) {
        const float *v = (const float *)((const char *)out_sample + units[i].offset);
        if ((out_sample->valid & units[i].bit) && !trk_is_unit(v, units[i].size))
            return trk_lines_fail(lines, out_error, "%s is not of unit length, expected a length of 1",
                                  units[i].name);
    }
    return true;
}

static bool read_own(struct trk_reading *reading, char out_error[TRK_ERROR_SIZE])
{
    struct trk_lines *lines = &reading->lines;
    size_t columns_here;
    if (!read_header(reading, &columns_here, out_error)) return false;
    reading->clock_names[0] = whole_names[DEVICE];
    reading->clock_names[1] = whole_names[ARRIVAL];
    for (;;) {
        enum trk_line line = trk_next_row(reading, out_error);
        if (line == TRK_LINE_END) return true;
        if (line == TRK_LINE_FAILED) return false;
        if (lines->text[0] == '#') continue;
        struct trk_sample sample;
        if (!read_row(lines, columns_here, &sample, out_error)) return false;
        if (!trk_log_append(reading, &sample, out_error)) return false;
    }
}

const struct trk_log_format trk_log_own = {
    .id = "fovead",
    .name = "fovead",
    .detect = detect,
    .read = read_own,
};

/* --- writing --- */

/* Write an integer with a point before its last `decimals` digits. Returns the length. */
static size_t print_number(char *out, uint64_t number, int decimals)
{
    int length = 0;
    char reversed[24];
    for (; number > 0 || length <= decimals; number /= 10) {
        reversed[length++] = (char)('0' + number % 10);
        if (length == decimals) reversed[length++] = '.';
    }
    if (reversed[length - 1] == '.') reversed[length++] = '0';
    for (int i = 0; i < length; i++) out[i] = reversed[length - 1 - i];
    out[length] = '\0';
    return (size_t)length;
}

/* Write value, which is above 0, as printf("%.*g", digits, value) would, and return the length. Returns 0 if
 * the text would have an exponent, or if rounding in double leaves its last digit in doubt. *out_read becomes
 * the float that strtof() would read from the text; if it is not value, nothing is written and 1 is returned.
 */
static size_t print_plain(char *out, double value, int digits, float *out_read)
{
    static const double powers[] = {1e-4, 1e-3, 1e-2, 1e-1, 1, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6};
    static const double scales[] = {1, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12};
    int exponent = -4;
    if (!(value >= powers[0] && value < powers[10])) return 0;
    while (value >= powers[exponent + 5]) exponent++;
    int decimals = digits - 1 - exponent;
    double scaled = value * scales[decimals], whole = rint(scaled);
    if (fabs(fabs(scaled - whole) - 0.5) < 1e-5 || whole >= scales[digits]) return 0;
    /* `read` is the double nearest to the written number. Rounding it to float gives the float nearest to the
     * written number, except if `read` lies exactly halfway between two floats. */
    double read = whole / scales[decimals];
    uint64_t bits;
    memcpy(&bits, &read, sizeof bits);
    if ((bits & 0x1fffffff) == 0x10000000) return 0;
    *out_read = (float)read;
    if (*out_read != (float)value) return 1;
    uint64_t number = (uint64_t)whole;
    for (; decimals > 0 && number % 10 == 0; decimals--) number /= 10;
    return print_number(out, number, decimals);
}

/* Write a separator, and the value with as few digits as read back as the same float; nine always suffice.
 * Zeros do not go through printf(), because most fields of most logs are 0 and printf() is slow. */
static size_t print_float(char *out, size_t size, float value)
{
    const bool negative = signbit(value);
    char *number = out + 1 + negative;
    size_t length = 0;
    *out = SEPARATOR;
    out[1] = '-';
    if (value == 0 && !negative) {
        memcpy(out + 1, "0", 2);
        return 2;
    }
    for (int digits = 6; digits <= 9; digits++) {
        float read;
        length = print_plain(number, fabs((double)value), digits, &read);
        if (length && read == fabsf(value)) return length + 1 + negative;
        if (length && digits < 9) continue;
        length = 1 + (size_t)snprintf(out + 1, size - 1, "%.*g", digits, (double)value);
        if (strtof(out + 1, NULL) == value) break;
    }
    return length;
}

size_t trk_own_header(bool with_screen, char out_text[TRK_OWN_SIZE])
{
    const size_t count = with_screen ? WITH_SCREEN : PLAIN;
    size_t length = (size_t)snprintf(out_text, TRK_OWN_SIZE, MAGIC VERSION "\n");
    for (size_t i = 0; i < count; i++)
        length += (size_t)snprintf(out_text + length, TRK_OWN_SIZE - length, "%s%c", column_name(i),
                                   i < count - 1 ? SEPARATOR : '\n');
    return length;
}

bool trk_own_accepts(const struct trk_sample *sample)
{
    if (sample->sequence > INT64_MAX || sample->arrival_ns > INT64_MAX) return false;
    for (int i = 0; i < COLUMNS; i++) {
        float value;
        memcpy(&value, (const char *)sample + columns[i].offset, sizeof value);
        if ((sample->valid & columns[i].bit) && !isfinite(value)) return false;
    }
    for (size_t i = 0; i < sizeof units / sizeof *units; i++)
        if ((sample->valid & units[i].bit) &&
            !trk_is_unit((const float *)((const char *)sample + units[i].offset), units[i].size))
            return false;
    return true;
}

size_t trk_own_row(const struct trk_sample *sample, bool with_screen, char out_text[TRK_OWN_SIZE])
{
    const uint32_t bits = sample->valid & (with_screen ? all_bits : all_bits & ~(uint32_t)TRK_SCREEN);
    const uint64_t whole[WHOLE] = {sample->sequence, sample->device_ns, sample->arrival_ns, bits};
    size_t length = 0;
    for (int i = 0; i < WHOLE; i++) {
        if (i > 0) out_text[length++] = SEPARATOR;
        length += print_number(out_text + length, whole[i], 0);
    }
    for (size_t i = 0; i < (with_screen ? WITH_SCREEN : PLAIN) - WHOLE; i++) {
        float value = 0;
        if (bits & columns[i].bit) memcpy(&value, (const char *)sample + columns[i].offset, sizeof value);
        length += print_float(out_text + length, TRK_OWN_SIZE - length, value);
    }
    out_text[length++] = '\n'; /* fits: at most 80 digits and 31 floats of 16 bytes, in 4096 bytes */
    out_text[length] = '\0';
    return length;
}

void trk_log_print(const struct trk_log *log, FILE *file)
{
    char text[TRK_OWN_SIZE];
    const bool with_screen = trk_log_seen(log) & TRK_SCREEN;
    fwrite(text, 1, trk_own_header(with_screen, text), file);
    for (size_t i = 0; i < log->count; i++) {
        struct trk_sample sample;
        trk_log_sample(log, i, &sample);
        fwrite(text, 1, trk_own_row(&sample, with_screen, text), file);
    }
}
