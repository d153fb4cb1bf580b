/* dialect: how programs and spreadsheets vary in writing the same rows: ends of lines, empty lines, quotes,
 * separators, decimal commas, words for missing values, an end that was cut off. It is the same for every
 * format. */
#ifndef FOVEAD_TRACKER_LOG_DIALECT_H
#define FOVEAD_TRACKER_LOG_DIALECT_H

#include "log/reading.h"

/* A separator that is any run of spaces and tabs. Blanks at the ends of a line separate nothing. */
enum { TRK_BLANKS = 1 };

/* Cut text in place at every separator; two separators in a row enclose an empty field. Returns the number of
 * fields, and fills the first TRK_MAX_FIELDS of out_fields, which point into text. Where the separator is a
 * comma, semicolon, tab or bar, blanks around a field are removed, and so are quotes; between quotes a
 * separator separates nothing and "" is a quote. */
size_t trk_split(char *text, char separator, char *out_fields[TRK_MAX_FIELDS]);

/* The separator that a line of names has most of, outside of quotes; TRK_BLANKS if it has none. */
char trk_separator_of(const char *line);

/* Take the first line that is not empty, past one that names the separator (sep=;). */
enum trk_line trk_first_row(struct trk_reading *reading, char out_error[TRK_ERROR_SIZE]);

/* Take the next line that is not empty. A last line that the file does not end, and that does not end with
 * what closes a row of its format, was cut off: it is left out and noted, and TRK_LINE_END is returned. */
enum trk_line trk_next_row(struct trk_reading *reading, char out_error[TRK_ERROR_SIZE]);

/* What to do with a row that is too short. TRK_LINE_END, and noted, if it is the last of several rows: the
 * file was cut off. Otherwise TRK_LINE_FAILED. */
enum trk_line trk_short_row(struct trk_reading *reading);

/* A field that says that there is no value: empty, NaN, -nan(ind), n/a, #N/A, ?, `.` and others. */
bool trk_is_missing(const char *field);

/* A number, with a decimal point or comma; NaN where it is missing. False if it is anything else or infinite.
 * A comma is changed in place. */
bool trk_field_number(struct trk_reading *reading, char *field, double *out_value);

/* The same for a time, which must not be missing: see trk_parse_time(). */
bool trk_field_time(struct trk_reading *reading, char *field, double unit_ns, int64_t *out_ns);

/* Note in trk_log.assumed how the file was written. To be called after the last row. */
void trk_say_dialect(struct trk_reading *reading);

#endif
