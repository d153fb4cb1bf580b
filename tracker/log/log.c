/* Logs: the table of formats, and what all formats share. What a format looks like is in its own file. */
#include "log/log.h"

#include "error.h"
#include "log/own.h"
#include "log/sranipal.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static const struct trk_log_format *const formats[] = {
    &trk_log_own,
    &trk_log_sranipal,
};
enum { FORMATS = sizeof formats / sizeof *formats };

/* --- lines ---------------------------------------------------------------------------------------------- */

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

/* Byte by byte and not getline(): a file without a newline must not decide how much memory is taken. */
enum trk_line trk_lines_next(struct trk_lines *lines, char out_error[TRK_ERROR_SIZE])
{
    size_t length = 0;
    int c;
    lines->number++;
    while ((c = getc_unlocked(lines->file)) != EOF && c != '\n') {
        if (c == '\0') {
            trk_lines_fail(lines, out_error, "holds a NUL byte, expected text");
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
    if (c == EOF && ferror(lines->file)) {
        trk_lines_fail(lines, out_error, "%s", strerror(errno));
        return TRK_LINE_FAILED;
    }
    if (c == EOF && length == 0) return TRK_LINE_END;
    if (length > 0 && lines->text[length - 1] == '\r') length--;
    lines->text[length] = '\0';
    return TRK_LINE;
}

size_t trk_split(char *text, char separator, char *out_fields[TRK_MAX_FIELDS])
{
    size_t count = 0;
    for (;;) {
        if (count < TRK_MAX_FIELDS) out_fields[count] = text;
        count++;
        text = strchr(text, separator);
        if (!text) return count;
        *text++ = '\0';
    }
}

/* --- numbers -------------------------------------------------------------------------------------------- */

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

bool trk_parse_int64(const char *field, int64_t *out_value)
{
    char *end;
    if (!starts_number(field)) return false;
    errno = 0;
    *out_value = strtoll(field, &end, 10);
    return end != field && *end == '\0' && errno == 0;
}

bool trk_is_unit(const float *v, int n)
{
    double sum = 0;
    for (int i = 0; i < n; i++) sum += (double)v[i] * v[i];
    return fabs(sqrt(sum) - 1) <= TRK_UNIT_TOLERANCE;
}

/* --- logs ----------------------------------------------------------------------------------------------- */

bool trk_log_append(struct trk_log *log, size_t *capacity, const struct trk_sample *sample,
                    const struct trk_lines *lines, char out_error[TRK_ERROR_SIZE])
{
    const struct trk_sample *last = log->count ? &log->samples[log->count - 1] : NULL;
    if (last && sample->device_ns < last->device_ns)
        return trk_lines_fail(lines, out_error, "device time goes back by %llu ns, expected it never to",
                              (unsigned long long)(last->device_ns - sample->device_ns));
    if (last && sample->arrival_ns < last->arrival_ns)
        return trk_lines_fail(lines, out_error, "arrival time goes back by %llu ns, expected it never to",
                              (unsigned long long)(last->arrival_ns - sample->arrival_ns));
    if (sample->sequence <= (last ? last->sequence : 0))
        return trk_lines_fail(lines, out_error, "sequence %llu, expected more than %llu",
                              (unsigned long long)sample->sequence,
                              (unsigned long long)(last ? last->sequence : 0));
    if (sample->device_ns > TRK_MAX_DEVICE_NS)
        return trk_lines_fail(lines, out_error, "device time is %.0f days, expected at most %.0f",
                              (double)sample->device_ns / 86400e9, (double)TRK_MAX_DEVICE_NS / 86400e9);
    if (log->count == TRK_MAX_ROWS)
        return trk_lines_fail(lines, out_error, "is one row too many, expected at most %d", TRK_MAX_ROWS);
    if (log->count == *capacity) {
        size_t grown = *capacity ? *capacity * 2 : 1024;
        struct trk_sample *samples = realloc(log->samples, grown * sizeof *samples);
        if (!samples) return trk_lines_fail(lines, out_error, "no memory for %zu samples", grown);
        log->samples = samples;
        *capacity = grown;
    }
    log->samples[log->count++] = *sample;
    return true;
}

/* A regular file, and nothing that could block or never end. */
static FILE *open_file(const char *path, char out_error[TRK_ERROR_SIZE])
{
    int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
    if (fd < 0) {
        trk_fail(out_error, "%s: %s, expected a gaze log", path, strerror(errno));
        return NULL;
    }
    struct stat status;
    if (fstat(fd, &status) != 0 || !S_ISREG(status.st_mode)) {
        trk_fail(out_error, "%s: not a regular file, expected a gaze log", path);
        close(fd);
        return NULL;
    }
    FILE *file = fdopen(fd, "r");
    if (!file) {
        trk_fail(out_error, "%s: %s", path, strerror(errno));
        close(fd);
    }
    return file;
}

static bool read_lines(struct trk_lines *lines, struct trk_log *log, char out_error[TRK_ERROR_SIZE])
{
    switch (trk_lines_next(lines, out_error)) {
    case TRK_LINE_FAILED:
        return false;
    case TRK_LINE_END:
        return trk_fail(out_error, "%s: is empty, expected a gaze log", lines->path);
    case TRK_LINE:
        break;
    }
    for (int i = 0; i < FORMATS; i++) {
        if (!formats[i]->detect(lines->text)) continue;
        log->format = formats[i]->name;
        if (!formats[i]->read(lines, log, out_error)) return false;
        if (log->count > 0) return true;
        return trk_fail(out_error, "%s: holds no samples, expected at least one row after the header",
                        lines->path);
    }
    char expected[256] = "";
    for (int i = 0; i < FORMATS; i++) {
        size_t length = strlen(expected);
        snprintf(expected + length, sizeof expected - length, "%s%s", i ? " or " : "", formats[i]->expects);
    }
    return trk_lines_fail(lines, out_error, "unknown header '%.40s', expected %s", lines->text, expected);
}

bool trk_log_read(const char *path, struct trk_log *out_log, char out_error[TRK_ERROR_SIZE])
{
    *out_log = (struct trk_log){0};
    struct trk_lines *lines = calloc(1, sizeof *lines);
    if (!lines) return trk_fail(out_error, "%s: no memory", path);
    lines->path = path;
    lines->file = open_file(path, out_error);
    bool ok = lines->file && read_lines(lines, out_log, out_error);
    if (lines->file) fclose(lines->file);
    free(lines);
    if (!ok) trk_log_finish(out_log);
    return ok;
}

void trk_log_finish(struct trk_log *log)
{
    free(log->samples);
    *log = (struct trk_log){0};
}
