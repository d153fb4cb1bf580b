/* lines: reads a log file line by line, unpacks gzip on the way, and parses the numbers in the fields. */
#ifndef FOVEAD_TRACKER_LOG_LINES_H
#define FOVEAD_TRACKER_LOG_LINES_H

#include "tracker.h"

#include <zlib.h>

enum {
    TRK_LINE_SIZE = 1 << 20, /* bytes of a line with its end; Tobii writes a column per area */
    TRK_BUFFER_SIZE = 65536,
};

/* The most bytes that a compressed log may unpack to. gzip can expand one byte to a thousand, and nobody
 * wants to wait for that many. */
#define TRK_MAX_UNPACKED (UINT64_C(2) << 30)

/* How far the length of a recorded unit vector or quaternion may be from 1. A log with three decimals passes;
 * a vector in other units does not. */
#define TRK_UNIT_TOLERANCE 1e-3

struct trk_lines {
    const char *path; /* borrowed */
    gzFile file;
    uint64_t bytes;           /* unpacked so far */
    size_t number;            /* of the line in text, counted from 1 */
    char end;                 /* the line end: LF, or CR if the file has no LF */
    bool has_end;             /* the line had an end, and was not cut off by the end of the file */
    bool is_gzip_cut;         /* the gzip data, and so the lines, ended too soon */
    bool ends_in_zeros;       /* after the last line, the file holds only zero bytes */
    size_t taken, filled;     /* bytes of buffer */
    char text[TRK_LINE_SIZE]; /* without the line end (LF, CR, CR LF, CR CR LF) and the UTF-8 mark; the only
                                 NUL byte ends it */
    char buffer[TRK_BUFFER_SIZE];
};

enum trk_line { TRK_LINE, TRK_LINE_END, TRK_LINE_FAILED };

/* Take the next line into lines->text. TRK_LINE_FAILED with the reason in out_error: a read error, a line
 * that is too long, a NUL byte that is not part of the zeros at the end of the file (the file is not text),
 * damaged or oversized gzip. */
enum trk_line trk_lines_next(struct trk_lines *lines, char out_error[TRK_ERROR_SIZE]);

/* Go back to the start of the file. */
void trk_lines_rewind(struct trk_lines *lines);

/* Write "PATH:LINE: <message>" for the line that was read last. Returns false. */
bool trk_lines_fail(const struct trk_lines *lines, char out_error[TRK_ERROR_SIZE], const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* Parse a number that fills a whole field. False if the field is empty or has anything before or after the
 * number, or if an integer is out of range. Only the decimal point is accepted: no program of the project
 * calls setlocale(), so strtof() and strtoll() use the C locale. A float or double may be infinite or NaN;
 * the caller decides what to do with it. */
bool trk_parse_float(const char *field, float *out_value);
bool trk_parse_double(const char *field, double *out_value);
bool trk_parse_int64(const char *field, int64_t *out_value);

/* Parse a time in ticks of unit_ns, with or without a fraction, and round it to whole nanoseconds. False if
 * it is not a finite number or does not fit. The result is exact for today's date in nanoseconds if long
 * double has 64 bits of mantissa. */
bool trk_parse_time(const char *field, double unit_ns, int64_t *out_ns);

/* True if v, which has n numbers, has a length within TRK_UNIT_TOLERANCE of 1. False if it holds NaN. */
bool trk_is_unit(const float *v, int n);

#endif
