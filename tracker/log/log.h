/* What every log format is made with: lines of a file, numbers, rows, and messages that name file and line.
 *
 * Only tracker/log/ includes this. A format is one file with a `const struct trk_log_format`, and one line in
 * the table in log.c. Formats are told by their first line and never by the file's name.
 */
#ifndef FOVEAD_TRACKER_LOG_H
#define FOVEAD_TRACKER_LOG_H

#include "tracker.h"

#include <stdio.h>

enum {
    TRK_LINE_SIZE = 4096,            /* bytes of a line with its end: no known format comes near */
    TRK_MAX_FIELDS = 128,            /* columns of a line */
    TRK_MAX_ROWS = 64 * 1024 * 1024, /* 6 days at 120 Hz */
};

/* The longest span of device time, 104 days in ns: beyond 2^53 a double no longer counts nanoseconds, and a
 * speed factor could not be applied exactly. */
#define TRK_MAX_DEVICE_NS (UINT64_C(1) << 53)

/* How far a recorded unit vector or quaternion may be from length 1: a decimal log of three digits passes, a
 * vector in other units does not. */
#define TRK_UNIT_TOLERANCE 1e-3

/* A file, line by line. */
struct trk_lines {
    const char *path; /* borrowed */
    FILE *file;
    size_t number;            /* of the line in text, from 1 */
    bool has_newline;         /* the line was ended, not cut off by the end of the file */
    char text[TRK_LINE_SIZE]; /* without its end, LF or CRLF; holds no NUL byte but the last */
};

enum trk_line { TRK_LINE, TRK_LINE_END, TRK_LINE_FAILED };

/* Take the next line into lines->text. TRK_LINE_FAILED, with the reason in out_error: a read error, a line
 * that is too long, a NUL byte (the file is no text). */
enum trk_line trk_lines_next(struct trk_lines *lines, char out_error[TRK_ERROR_SIZE]);

/* Write "PATH:LINE: <message>" for the line that was read last; returns false. */
bool trk_lines_fail(const struct trk_lines *lines, char out_error[TRK_ERROR_SIZE], const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* Cut text in place at every separator; fields that are adjacent to nothing are empty. Returns their number,
 * and fills the first TRK_MAX_FIELDS of out_fields, which point into text. */
size_t trk_split(char *text, char separator, char *out_fields[TRK_MAX_FIELDS]);

/* Whole-field numbers: false if the field is empty, has anything before or after the number, or is out of
 * range. Decimal point only: no program of the project calls setlocale(), so strtof() and strtoll() read in
 * the C locale. A float may be read as infinite or NaN: the caller judges. */
bool trk_parse_float(const char *field, float *out_value);
bool trk_parse_int64(const char *field, int64_t *out_value);

/* True if v, of n numbers, has a length within TRK_UNIT_TOLERANCE of 1 (NaN never has). */
bool trk_is_unit(const float *v, int n);

/* Append a sample. Checks what every format must hold: sequence and the times never go back, the device clock
 * stays within TRK_MAX_DEVICE_NS, rows within TRK_MAX_ROWS. capacity starts at 0 and is the caller's to keep.
 */
bool trk_log_append(struct trk_log *log, size_t *capacity, const struct trk_sample *sample,
                    const struct trk_lines *lines, char out_error[TRK_ERROR_SIZE]);

struct trk_log_format {
    const char *name;    /* goes to trk_log.format */
    const char *expects; /* its first line, for the message about an unknown one */
    bool (*detect)(const char *first_line);
    /* Read the rest of the file; lines->text holds the first line. On failure the caller frees what out_log
     * has. */
    bool (*read)(struct trk_lines *lines, struct trk_log *out_log, char out_error[TRK_ERROR_SIZE]);
};

#endif
