/* Lines of a file, and the numbers in their fields. */
#include "log/lines.h"

#include "error.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

bool trk_lines_fail(const struct trk_lines *lines, char out_error[TRK_ERROR_SIZE], const char *format, ...)
{
    char prefix[TRK_ERROR_SIZE];
    /* Cut off the start of a long path, so that there is room for the reason. */
    size_t length = strlen(lines->path), room = TRK_ERROR_SIZE / 2;
    const char *tail = length > room ? lines->path + length - room : lines->path;
    snprintf(prefix, sizeof prefix, "%s%s:%zu: ", tail == lines->path ? "" : "...", tail, lines->number);
    va_list arguments;
    va_start(arguments, format);
    trk_vfail(out_error, prefix, format, arguments);
    va_end(arguments);
    return false;
}

/* Unpack the next part of the file into the buffer. False at the end of the file, and on failure; a failure
 * also sets *out_failed and gives a message. */
static bool fill(struct trk_lines *lines, bool *out_failed, char out_error[TRK_ERROR_SIZE])
{
    int count = gzread(lines->file, lines->buffer, sizeof lines->buffer), code;
    const char *reason = gzerror(lines->file, &code);
    lines->taken = 0;
    lines->filled = count > 0 ? (size_t)count : 0;
    lines->bytes += lines->filled;
    lines->is_gzip_cut |= code == Z_BUF_ERROR;
    *out_failed = count < 0 && code != Z_BUF_ERROR;
    if (*out_failed && code == Z_ERRNO)
        trk_lines_fail(lines, out_error, "%s", strerror(errno));
    else if (*out_failed)
        trk_lines_fail(lines, out_error, "damaged gzip data (%s), expected a whole file", reason);
    else if (lines->bytes > TRK_MAX_UNPACKED && !gzdirect(lines->file))
        *out_failed = !trk_lines_fail(lines, out_error, "unpacks to more than %d GiB, expected less",
                                      (int)(TRK_MAX_UNPACKED >> 30));
    return !*out_failed && lines->filled > 0;
}

/* Are all bytes from `at` to the end of the file zero, as after a crash of the machine? The search uses up
 * the buffer. */
static bool is_zero_to_end(struct trk_lines *lines, size_t at, char out_error[TRK_ERROR_SIZE])
{
    bool failed;
    do {
        for (; at < lines->filled; at++)
            if (lines->buffer[at]) return false;
        at = 0;
    } while (fill(lines, &failed, out_error));
    return !failed;
}

/* This uses memchr() and not getline(), because a file without line ends must not decide how much memory is
 * allocated. */
enum trk_line trk_lines_next(struct trk_lines *lines, char out_error[TRK_ERROR_SIZE])
{
    size_t length = 0;
    bool failed = false;
    lines->number++;
    lines->has_end = false;
    while (!lines->has_end && (lines->taken < lines->filled || fill(lines, &failed, out_error))) {
        const char *from = lines->buffer + lines->taken;
        size_t left = lines->filled - lines->taken;
        const char *end = memchr(from, lines->end, left);
        size_t part = end ? (size_t)(end - from) : left;
        const char *zero = memchr(from, '\0', part);
        if (zero) part = (size_t)(zero - from);
        if (length + part > TRK_LINE_SIZE - 1) {
            trk_lines_fail(lines, out_error, "is longer than %d bytes, expected one sample a line",
                           TRK_LINE_SIZE - 1);
            return TRK_LINE_FAILED;
        }
        memcpy(lines->text + length, from, part);
        length += part;
        if (zero) {
            if (lines->number == 1 || !is_zero_to_end(lines, lines->taken + part, out_error)) {
                trk_lines_fail(lines, out_error, "holds a NUL byte (is it UTF-16?), expected text in UTF-8");
                return TRK_LINE_FAILED;
            }
            lines->ends_in_zeros = true;
            break;
        }
        lines->taken += part + (end ? 1 : 0);
        lines->has_end = end != NULL;
    }
    if (failed) return TRK_LINE_FAILED;
    if (!lines->has_end && length == 0) return TRK_LINE_END;
    while (length > 0 && lines->text[length - 1] == '\r') length--;
    lines->text[length] = '\0';
    if (lines->number == 1 && strncmp(lines->text, "\xef\xbb\xbf", 3) == 0)
        memmove(lines->text, lines->text + 3, length - 2);
    return TRK_LINE;
}

void trk_lines_rewind(struct trk_lines *lines)
{
    gzrewind(lines->file);
    lines->bytes = lines->number = lines->taken = lines->filled = 0;
}

/* --- numbers --- */

/* strtof() and strtoll() skip white space before a number, but here a field must begin with the number. */
static bool starts_number(const char *field)
{
    return *field != '\0' && !strchr(" \t\v\f\r\n", *field);
}

/* Read a number of up to 15 digits, with an optional minus and an optional point, and nothing else. It is an
 * integer divided by a power of ten. A double holds both exactly, so the quotient is the double nearest to
 * the number (Clinger 1990). False for anything else. */
static bool parse_plain(const char *field, double *out_value)
{
    static const double powers[] = {1,   1e1, 1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                    1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15};
    enum { MOST_DIGITS = 15 };
    const bool negative = *field == '-';
    int64_t number = 0;
    int digits = 0, before_point = -1;
    const char *at = field + negative;
    for (;; at++) {
        if (*at >= '0' && *at <= '9' && digits < MOST_DIGITS) {
            number = 10 * number + (*at - '0');
            digits++;
        } else if (*at == '.' && before_point < 0) {
            before_point = digits;
        } else {
            break;
        }
    }
    if (*at || digits == 0) return false;
    const double value = (double)number / powers[before_point < 0 ? 0 : digits - before_point];
    *out_value = negative ? -value : value;
    return true;
}

bool trk_parse_float(const char *field, float *out_value)
{
    char *end;
    double value;
    uint64_t bits;
    /* Rounding the nearest double to float gives the nearest float, except if the double lies exactly halfway
     * between two floats. */
    if (parse_plain(field, &value)) {
        memcpy(&bits, &value, sizeof bits);
        *out_value = (float)value;
        if ((bits & 0x1fffffff) != 0x10000000) return true;
    }
    if (!starts_number(field)) return false;
    *out_value = strtof(field, &end);
    return end != field && *end == '\0';
}

bool trk_parse_double(const char *field, double *out_value)
{
    char *end;
    if (parse_plain(field, out_value)) return true;
    if (!starts_number(field)) return false;
    *out_value = strtod(field, &end);
    return end != field && *end == '\0';
}

bool trk_parse_int64(const char *field, int64_t *out_value)
{
    char *end;
    if (!starts_number(field)) return false;
    errno = 0;
    *out_value = strtoll(field, &end, 10);
    return end != field && *end == '\0' && errno == 0;
}

bool trk_parse_time(const char *field, double unit_ns, int64_t *out_ns)
{
    char *end;
    if (!starts_number(field)) return false;
    long double ns = strtold(field, &end) * (long double)unit_ns;
    /* This comparison also refuses NaN. The limit is half the range of an int64_t, so that differences of
     * times fit too. */
    if (end == field || *end != '\0' || !(fabsl(ns) < 0x1p62L)) return false;
    *out_ns = llroundl(ns);
    return true;
}

bool trk_is_unit(const float *v, int n)
{
    double sum = 0;
    for (int i = 0; i < n; i++) sum += (double)v[i] * v[i];
    return fabs(sqrt(sum) - 1) <= TRK_UNIT_TOLERANCE;
}
