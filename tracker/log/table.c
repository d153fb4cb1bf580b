/* Tables: columns by name, rows, and numbers that may be missing. */
#include "log/table.h"

#include "log/clocks.h"
#include "log/dialect.h"
#include "log/recording.h"
#include "log/rows.h"

#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* --- the header --- */

void trk_header_parse(struct trk_header *header, const char *line, char separator)
{
    size_t length = strnlen(line, sizeof header->line - 1);
    memcpy(header->line, line, length);
    header->line[length] = '\0';
    header->separator = separator ? separator : trk_separator_of(header->line);
    header->count = trk_split(header->line, header->separator, header->names);
    /* Names that are empty at the end of the header come from superfluous separators. Rows may have them too.
     */
    while (header->count > 1 && header->count <= TRK_MAX_FIELDS && *header->names[header->count - 1] == '\0')
        header->count--;
}

/* The next significant character of a name; 0 at its end. */
static int next_letter(const char **at)
{
    while (**at && **at != '[' && !isalnum((unsigned char)**at)) ++*at;
    if (**at == '\0' || **at == '[') return 0;
    return tolower((unsigned char)*(*at)++);
}

static bool is_named(const char *column, const char *name)
{
    int c;
    while ((c = next_letter(&column)) == next_letter(&name))
        if (c == 0) return true;
    return false;
}

int trk_header_find(const struct trk_header *header, const char *name)
{
    if (header->count > TRK_MAX_FIELDS) return -1;
    for (size_t i = 0; i < header->count; i++)
        if (is_named(header->names[i], name)) return (int)i;
    return -1;
}

int trk_header_find_unit(const struct trk_header *header, const char *name, const char *unit)
{
    if (header->count > TRK_MAX_FIELDS) return -1;
    for (size_t i = 0; i < header->count; i++) {
        const char *bracket = strchr(header->names[i], '[');
        if (is_named(header->names[i], name) && (!bracket || strstr(bracket, unit))) return (int)i;
    }
    return -1;
}

bool trk_header_has(const struct trk_header *header, const char *const columns[])
{
    if (!columns[0]) return false;
    for (int i = 0; columns[i]; i++)
        if (trk_header_find(header, columns[i]) < 0) return false;
    return true;
}

/* The column of the first of these names that is in the header, or -1. */
static int find_any(const struct trk_header *header, const char *const names[])
{
    for (int i = 0; names[i]; i++) {
        int column = trk_header_find(header, names[i]);
        if (column >= 0) return column;
    }
    return -1;
}

/* --- rows --- */

void trk_table_init(struct trk_table *table, struct trk_reading *reading)
{
    static const char *const participants[] = {"participant name", "participant id", "participant",
                                               "subject id",       "subject",        NULL};
    static const char *const recordings[] = {"recording name", "recording id", "recording",
                                             "session id",     "session",      NULL};
    *table = (struct trk_table){.reading = reading,
                                .participant = find_any(&reading->header, participants),
                                .recording = find_any(&reading->header, recordings)};
}

bool trk_table_need(struct trk_table *table, const char *const names[], int n, int out_columns[],
                    char out_error[TRK_ERROR_SIZE])
{
    const struct trk_header *header = &table->reading->header;
    const struct trk_lines *lines = &table->reading->lines;
    if (header->count > TRK_MAX_FIELDS)
        return trk_lines_fail(lines, out_error, "header has %zu columns, expected at most %d", header->count,
                              TRK_MAX_FIELDS);
    for (int i = 0; i < n; i++) {
        out_columns[i] = trk_header_find(header, names[i]);
        if (out_columns[i] < 0)
            return trk_lines_fail(lines, out_error, "header lacks a column, expected '%s'", names[i]);
    }
    return true;
}

/* Do not count empty fields after the expected ones, because superfluous separators make them. */
static size_t count_filled(char *const *fields, size_t count, size_t expected)
{
    while (count > expected && count <= TRK_MAX_FIELDS && *fields[count - 1] == '\0') count--;
    return count;
}

/* Find the separator of the rows, which may differ from the header's: the one that splits the first row into
 * as many fields as the header has. */
static void find_separator(struct trk_table *table)
{
    const struct trk_header *header = &table->reading->header;
    const char tries[] = {header->separator, '\t', ';', ',', TRK_BLANKS};
    char *copy = table->reading->scratch;
    table->separator = header->separator;
    for (size_t i = 0; i < sizeof tries; i++) {
        strcpy(copy, table->reading->lines.text);
        size_t count = trk_split(copy, tries[i], table->fields);
        if (count_filled(table->fields, count, header->count) != header->count) continue;
        table->separator = tries[i];
        return;
    }
    for (size_t i = 1; i < sizeof tries && header->separator == TRK_BLANKS; i++)
        if (strchr(table->reading->lines.text, tries[i])) {
            table->separator = tries[i];
            return;
        }
}

/* Split a row into its fields. *out_is_empty: all fields are empty. */
static enum trk_line split(struct trk_table *table, bool *out_is_empty, char out_error[TRK_ERROR_SIZE])
{
    struct trk_lines *lines = &table->reading->lines;
    size_t expected = table->reading->header.count, count;
    static char none[] = "";
    if (!table->separator) find_separator(table);
    count = trk_split(lines->text, table->separator, table->fields);
    *out_is_empty = count_filled(table->fields, count, 0) == 0;
    if (*out_is_empty) return TRK_LINE;
    if (table->mend) count = table->mend(table->reader, table, count);
    count = count_filled(table->fields, count, expected);
    while (table->may_be_short && count < expected) table->fields[count++] = none;
    if (count == expected) return TRK_LINE;
    trk_lines_fail(lines, out_error, "%zu columns, expected %zu as in the header", count, expected);
    return count < expected ? trk_short_row(table->reading) : TRK_LINE_FAILED;
}

/* Take the next row of the file, whichever recording it belongs to. */
static enum trk_line next_row(struct trk_table *table, bool is_taken, char out_error[TRK_ERROR_SIZE])
{
    const char *text = table->reading->lines.text;
    bool is_empty = true;
    for (;; is_taken = false) {
        enum trk_line line = is_taken ? TRK_LINE : trk_next_row(table->reading, out_error);
        if (line != TRK_LINE) return line;
        if (table->comment && *text == table->comment) continue;
        line = split(table, &is_empty, out_error);
        if (line != TRK_LINE || !is_empty) return line;
    }
}

static enum trk_recording_row recording_of_row(struct trk_table *table)
{
    return trk_recording_of_row(table->reading,
                                table->participant < 0 ? NULL : table->fields[table->participant],
                                table->recording < 0 ? NULL : table->fields[table->recording]);
}

static bool is_recording_met(const struct trk_table *table, char out_error[TRK_ERROR_SIZE])
{
    return trk_recording_is_met(table->reading, table->participant >= 0 || table->recording >= 0, out_error);
}

static enum trk_line next_of_recording(struct trk_table *table, bool is_taken, char out_error[TRK_ERROR_SIZE])
{
    for (;; is_taken = false) {
        enum trk_line line = next_row(table, is_taken, out_error);
        if (line == TRK_LINE_FAILED) return line;
        if (line == TRK_LINE_END) return is_recording_met(table, out_error) ? line : TRK_LINE_FAILED;
        switch (recording_of_row(table)) {
        case TRK_RECORDING_WANTED:
            return TRK_LINE;
        case TRK_RECORDING_OTHER:
            break;
        case TRK_RECORDING_SEVERAL:
            while (next_row(table, false, out_error) == TRK_LINE) recording_of_row(table);
            return is_recording_met(table, out_error) ? TRK_LINE_END : TRK_LINE_FAILED;
        }
    }
}

enum trk_line trk_table_next(struct trk_table *table, char out_error[TRK_ERROR_SIZE])
{
    return next_of_recording(table, false, out_error);
}

enum trk_line trk_table_first(struct trk_table *table, char out_error[TRK_ERROR_SIZE])
{
    return next_of_recording(table, true, out_error);
}

bool trk_table_read(struct trk_table *table,
                    bool (*read_row)(void *reader, struct trk_sample *out_sample,
                                     char out_error[TRK_ERROR_SIZE]),
                    void *reader, char out_error[TRK_ERROR_SIZE])
{
    enum trk_line line;
    while ((line = trk_table_next(table, out_error)) == TRK_LINE) {
        struct trk_sample sample = {0};
        if (!read_row(reader, &sample, out_error)) return false;
        if (sample.sequence > 0 && !trk_log_append(table->reading, &sample, out_error)) return false;
    }
    return line == TRK_LINE_END;
}

bool trk_table_number(struct trk_table *table, int column, double *out_value, char out_error[TRK_ERROR_SIZE])
{
    *out_value = NAN;
    if (column < 0) return true;
    if (trk_field_number(table->reading, table->fields[column], out_value)) return true;
    return trk_lines_fail(&table->reading->lines, out_error, "%.60s is '%.40s', expected a finite number",
                          table->reading->header.names[column], table->fields[column]);
}

bool trk_table_integer(struct trk_table *table, int column, int64_t *out_value,
                       char out_error[TRK_ERROR_SIZE])
{
    double value;
    if (trk_parse_int64(table->fields[column], out_value)) return true;
    if (trk_field_number(table->reading, table->fields[column], &value) && rint(value) == value &&
        fabs(value) < 0x1p53) {
        *out_value = (int64_t)value;
        return true;
    }
    return trk_lines_fail(&table->reading->lines, out_error, "%.60s is '%.40s', expected a whole number",
                          table->reading->header.names[column], table->fields[column]);
}

bool trk_table_numbers(struct trk_table *table, const int *columns, int n, float *out_values,
                       char out_error[TRK_ERROR_SIZE])
{
    for (int i = 0; i < n; i++) {
        double value;
        if (!trk_table_number(table, columns[i], &value, out_error)) return false;
        out_values[i] = (float)value;
    }
    return true;
}

bool trk_table_time(struct trk_table *table, int column, double unit_ns, int64_t *out_ns,
                    char out_error[TRK_ERROR_SIZE])
{
    char *field = table->fields[column];
    if (trk_field_time(table->reading, field, unit_ns, out_ns)) return true;
    return trk_lines_fail(&table->reading->lines, out_error, "%.60s is '%.40s', expected a time",
                          table->reading->header.names[column], field);
}

/* --- guessing the unit of time --- */

enum { GUESS_ROWS = 1000 };

static int by_size(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Find the median and the mean of the steps forward in the first rows; both are 0 if there are no such steps.
 * False on failure. */
static bool measure_steps(struct trk_table *table, int column, double out_steps[2],
                          char out_error[TRK_ERROR_SIZE])
{
    double steps[GUESS_ROWS], last = NAN, sum = 0;
    size_t count = 0;
    for (int row = 0; row < GUESS_ROWS; row++) {
        double value;
        enum trk_line line = trk_table_next(table, out_error);
        if (line == TRK_LINE_END) break;
        if (line == TRK_LINE_FAILED || !trk_table_number(table, column, &value, out_error)) return false;
        if (value > last) {
            sum += value - last;
            steps[count++] = value - last;
        }
        if (!isnan(value)) last = value;
    }
    qsort(steps, count, sizeof *steps, by_size);
    out_steps[0] = count ? steps[count / 2] : 0;
    out_steps[1] = count ? sum / (double)count : 0;
    return true;
}

double trk_table_guess_unit(struct trk_table *table, int column, char out_error[TRK_ERROR_SIZE])
{
    static const struct {
        const char *name;
        double ns;
    } units[] = {{"s", 1e9}, {"ms", 1e6}, {"us", 1e3}, {"ns", 1}};
    struct trk_reading *reading = table->reading;
    double told = trk_time_unit(reading, 0);
    if (told > 0) return told;
    size_t header_line = reading->lines.number;
    double steps[2];
    if (!measure_steps(table, column, steps, out_error)) return 0;
    trk_lines_rewind(&reading->lines);
    while (reading->lines.number < header_line)
        if (trk_lines_next(&reading->lines, out_error) != TRK_LINE) return 0;
    for (size_t i = 0; i < 2 * sizeof units / sizeof *units; i++) {
        const size_t unit = i % (sizeof units / sizeof *units);
        const double step = steps[i / (sizeof units / sizeof *units)], step_ns = step * units[unit].ns;
        if (step_ns < 1e9 / 2500 * 0.99 || step_ns > 1e9 / 20 * 1.01) continue;
        trk_assume(reading, "%.40s is in %s (steps of %g)", reading->header.names[column], units[unit].name,
                   step);
        return units[unit].ns;
    }
    /* A log with at most one time works with any unit. */
    if (steps[0] == 0) return 1e6;
    trk_lines_fail(
        &reading->lines, out_error,
        "%.60s has steps of %g, which is not a rate of an eye tracker in any unit: expected an option for "
        "the unit (s, ms, us or ns)",
        reading->header.names[column], steps[0]);
    return 0;
}
