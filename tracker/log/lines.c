/* Lines of a file, and the numbers in them. */
#include "log/log.h"

#include "error.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

bool trk_lines_fail(const struct trk_lines *lines, char out_error[TRK_ERROR_SIZE], const char *format, ...)
{
    char prefix[TRK_ERROR_SIZE];
    /* A long path is cut at its start, so that the reason keeps its room. */
    size_t length = strlen(lines->path), room = TRK_ERROR_SIZE / 2;
    const char *tail = length > room ? lines->path + length - room : lines->path;
    snprintf(prefix, sizeof prefix, "%s%s:%zu: ", tail == lines->path ? "" : "...", tail, lines->number);
    va_list arguments;
    va_start(arguments, format);
    trk_vfail(out_error, prefix, format, arguments);
    va_end(arguments);
    return false;
}

static enum trk_line fail_to_read(struct trk_lines *lines, char out_error[TRK_ERROR_SIZE])
{
    int code;
    const char *reason = gzerror(lines->file, &code);
    if (code == Z_ERRNO)
        trk_lines_fail(lines, out_error, "%s", strerror(errno));
    else if (code == Z_BUF_ERROR)
        trk_lines_fail(lines, out_error, "the gzip data is cut off, expected its end");
    else
        trk_lines_fail(lines, out_error, "damaged gzip data (%s), expected a whole file", reason);
    return TRK_LINE_FAILED;
}

/* Byte by byte and not getline(): a file without a newline must not decide how much memory is taken. */
enum trk_line trk_lines_next(struct trk_lines *lines, char out_error[TRK_ERROR_SIZE])
{
    size_t length = 0;
    int c, code;
    lines->number++;
    while ((c = gzgetc(lines->file)) != -1 && c != '\n') {
        if (c == '\0') {
            trk_lines_fail(lines, out_error, "holds a NUL byte (is it UTF-16?), expected text in UTF-8");
            return TRK_LINE_FAILED;
        }
        if (length == TRK_LINE_SIZE - 1) {
            trk_lines_fail(lines, out_error, "is longer than %d bytes, expected one sample a line",
                           TRK_LINE_SIZE - 1);
            return TRK_LINE_FAILED;
        }
        lines->text[length++] = (char)c;
    }
    lines->has_newline = c == '\n';
    lines->bytes += length + 1;
    gzerror(lines->file, &code);
    if (c == -1 && code != Z_OK && code != Z_STREAM_END) return fail_to_read(lines, out_error);
    if (lines->bytes > TRK_MAX_UNPACKED && !gzdirect(lines->file)) {
        trk_lines_fail(lines, out_error, "unpacks to more than %d GiB, expected less",
                       (int)(TRK_MAX_UNPACKED >> 30));
        return TRK_LINE_FAILED;
    }
    if (c == -1 && length == 0) return TRK_LINE_END;
    if (length > 0 && lines->text[length - 1] == '\r') length--;
    lines->text[length] = '\0';
    if (lines->number == 1 && strncmp(lines->text, "\xef\xbb\xbf", 3) == 0)
        memmove(lines->text, lines->text + 3, length - 2);
    return TRK_LINE;
}

/* --- fields --------------------------------------------------------------------------------------------- */

static size_t split_runs(char *text, char *out_fields[TRK_MAX_FIELDS])
{
    size_t count = 0;
    for (char *at = text + strspn(text, " \t"); *at; at += strspn(at, " \t")) {
        if (count < TRK_MAX_FIELDS) out_fields[count] = at;
        count++;
        at += strcspn(at, " \t");
        if (*at) *at++ = '\0';
    }
    return count;
}

size_t trk_split(char *text, char separator, char *out_fields[TRK_MAX_FIELDS])
{
    size_t count = 0;
    if (separator == TRK_BLANKS) return split_runs(text, out_fields);
    for (;;) {
        if (count < TRK_MAX_FIELDS) out_fields[count] = text;
        count++;
        text = strchr(text, separator);
        if (!text) return count;
        *text++ = '\0';
    }
}

/* strtof() and strtoll() skip white space before a number; a field must start with it. */
static bool starts_number(const char *field)
{
    return *field != '\0' && !strchr(" \t\v\f\r\n", *field);
}

bool trk_parse_float(const char *field, float *out_value)
{
    char *end;
    if (!starts_number(field)) return false;
    *out_value = strtof(field, &end);
    return end != field && *end == '\0';
}

bool trk_parse_double(const char *field, double *out_value)
{
    char *end;
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
    /* NaN fails the comparison. Half the range, so that differences fit too. */
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
