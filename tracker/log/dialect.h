/* dialect: how programs and spreadsheets differ in writing the same rows: line ends, empty lines, quotes,
 * separators, decimal commas, words for missing values, and files that were cut off. The same code serves
 * every format. */
#ifndef FOVEAD_TRACKER_LOG_DIALECT_H
#define FOVEAD_TRACKER_LOG_DIALECT_H

#include "log/reading.h"

/* The separator is any run of spaces and tabs. Spaces and tabs at the start and end of a line do not count.
 */
enum { TRK_BLANKS = 1 };

/* Split text in place at every separator; two separators in a row enclose an empty field. Returns the number
 * of fields and fills the first TRK_MAX_FIELDS of out_fields, which point into text. If the separator is a
 * comma, semicolon, tab or bar, the blanks and the quotes around a field are removed. Inside quotes,
 * separators do not split, and "" stands for one quote. */
size_t trk_split(char *text, char separator, char *out_fields[TRK_MAX_FIELDS]);

/* The separator that occurs most often in a header line, outside of quotes; TRK_BLANKS if there is none. */
char trk_separator_of(const char *line);

/* Take the first line that is not empty, and skip a line that names the separator (sep=;). */
enum trk_line trk_first_row(struct trk_reading *reading, char out_error[TRK_ERROR_SIZE]);

/* Take the next line that is not empty. The last line was cut off if it has no line end and does not end with
 * the text that closes a row of its format. Then it is dropped with a note, and TRK_LINE_END is returned. */
enum trk_line trk_next_row(struct trk_reading *reading, char out_error[TRK_ERROR_SIZE]);

/* Decide about a row that is too short. If it is the last of several rows, the file was cut off: the row is
 * dropped with a note, and TRK_LINE_END is returned. Otherwise TRK_LINE_FAILED. */
enum trk_line trk_short_row(struct trk_reading *reading);

/* True if the field stands for a missing value: empty, NaN, -nan(ind), n/a, #N/A, ?, `.` and others. */
bool trk_is_missing(const char *field);

/* Read a number with a decimal point or comma; NaN if the value is missing. False if the field is anything
 * else, or infinite. A decimal comma is replaced in place. */
bool trk_field_number(struct trk_reading *reading, char *field, double *out_value);

/* Read a time in the same way, but it must not be missing: see trk_parse_time(). */
bool trk_field_time(struct trk_reading *reading, char *field, double unit_ns, int64_t *out_ns);

/* Note in trk_log.assumed how the file was written. Call it after the last row. */
void trk_say_dialect(struct trk_reading *reading);

#endif
