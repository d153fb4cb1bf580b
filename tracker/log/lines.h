/* lines: a log file line by line, unpacked from gzip on the way, and the numbers in its fields. */
#ifndef FOVEAD_TRACKER_LOG_LINES_H
#define FOVEAD_TRACKER_LOG_LINES_H

#include "tracker.h"

#include <zlib.h>

enum {
    TRK_LINE_SIZE = 1 << 20, /* bytes of a line with its end: Tobii names a column for every area */
    TRK_BUFFER_SIZE = 65536,
};

/* The most bytes that a compressed log may unpack to. gzip can make a thousand bytes of one, and nobody waits
 * for that many. */
#define TRK_MAX_UNPACKED (UINT64_C(2) << 30)

/* How far the length of a recorded unit vector or quaternion may be from 1: a decimal log of three digits
 * passes, a vector in other units does not. */
#define TRK_UNIT_TOLERANCE 1e-3

struct trk_lines {
    const char *path; /* borrowed */
    gzFile file;
    uint64_t bytes;           /* unpacked so far */
    size_t number;            /* of the line in text, from 1 */
    char end;                 /* of lines: LF, or CR in a file that has no LF */
    bool has_end;             /* the line was ended, not cut off by the end of the file */
    bool is_gzip_cut;         /* the gzip data ended too soon: so did the lines */
    bool ends_in_zeros;       /* zero bytes alone follow the last line, up to the end of the file */
    size_t taken, filled;     /* bytes of buffer */
    char text[TRK_LINE_SIZE]; /* without its end (LF, CR, CR LF, CR CR LF) and mark of UTF-8; holds no NUL
                                 byte but the last */
    char buffer[TRK_BUFFER_SIZE];
};

enum trk_line { TRK_LINE, TRK_LINE_END, TRK_LINE_FAILED };

/* Take the next line into lines->text. TRK_LINE_FAILED with the reason in out_error: a read error, a line
 * that is too long, a NUL byte that is not part of the file's end (the file is no text), damaged or oversized
 * gzip. */
enum trk_line trk_lines_next(struct trk_lines *lines, char out_error[TRK_ERROR_SIZE]);

/* Go back to before the first line. */
void trk_lines_rewind(struct trk_lines *lines);

/* Write "PATH:LINE: <message>" for the line that was read last; returns false. */
bool trk_lines_fail(const struct trk_lines *lines, char out_error[TRK_ERROR_SIZE], const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* Numbers that fill a whole field: false if the field is empty, has anything before or after the number, or
 * is out of range. Decimal point only: no program of the project calls setlocale(), so strtof() and strtoll()
 * read in the C locale. A float may be infinite or NaN: the caller decides what to do with it. */
bool trk_parse_float(const char *field, float *out_value);
bool trk_parse_double(const char *field, double *out_value);
bool trk_parse_int64(const char *field, int64_t *out_value);

/* A time in ticks of unit_ns, with or without a fraction, to whole nanoseconds. False if it is no finite
 * number or does not fit. Exact for the nanoseconds of today where long double has 64 bits of mantissa. */
bool trk_parse_time(const char *field, double unit_ns, int64_t *out_ns);

/* True if v, of n numbers, has a length within TRK_UNIT_TOLERANCE of 1 (NaN never has). */
bool trk_is_unit(const float *v, int n);

#endif
