/* Tables: columns by name, rows, numbers that may be missing. */
#include "log/log.h"

#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* --- the header ----------------------------------------------------------------------------------------- */

/* The first of these that a line has; a name may hold spaces only where something else separates. */
static char separator_of(const char *line)
{
    static const char separators[] = {'\t', ';', ','};
    for (size_t i = 0; i < sizeof separators; i++)
        if (strchr(line, separators[i])) return separators[i];
    return TRK_BLANKS;
}

static void strip_quotes(char **field)
{
    size_t length = strlen(*field);
    if (length < 2 || (*field)[0] != '"' || (*field)[length - 1] != '"') return;
    (*field)[length - 1] = '\0';
    ++*field;
}

void trk_header_parse(struct trk_header *header, const char *line)
{
    size_t length = strnlen(line, sizeof header->line - 1);
    memcpy(header->line, line, length);
    header->line[length] = '\0';
    header->separator = separator_of(header->line);
    header->count = trk_split(header->line, header->separator, header->names);
    /* An empty name at the end is a separator too many, which rows may have as well. */
    if (header->count > 1 && header->count <= TRK_MAX_FIELDS && *header->names[header->count - 1] == '\0')
        header->count--;
    for (size_t i = 0; i < header->count && i < TRK_MAX_FIELDS; i++) strip_quotes(&header->names[i]);
}

/* The next character of a name that counts; 0 at its end. */
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

/* --- rows ----------------------------------------------------------------------------------------------- */

void trk_table_init(struct trk_table *table, struct trk_reading *reading)
{
    *table = (struct trk_table){.reading = reading, .separator = reading->header.separator};
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

enum trk_line trk_table_split(struct trk_table *table, char out_error[TRK_ERROR_SIZE])
{
    struct trk_lines *lines = &table->reading->lines;
    size_t expected = table->reading->header.count, count;
    count = trk_split(lines->text, table->separator, table->fields);
    if (count == expected + 1 && count <= TRK_MAX_FIELDS && *table->fields[expected] == '\0') count--;
    static char none[] = "";
    while (table->may_be_short && count < expected) table->fields[count++] = none;
    if (count != expected) {
        trk_lines_fail(lines, out_error, "%zu columns, expected %zu as in the header", count, expected);
        return TRK_LINE_FAILED;
    }
    for (size_t i = 0; i < count; i++) strip_quotes(&table->fields[i]);
    return TRK_LINE;
}

enum trk_line trk_table_next(struct trk_table *table, char out_error[TRK_ERROR_SIZE])
{
    struct trk_lines *lines = &table->reading->lines;
    enum trk_line line;
    do {
        line = trk_lines_next(lines, out_error);
    } while (line == TRK_LINE && lines->text[0] == '\0');
    return line == TRK_LINE ? trk_table_split(table, out_error) : line;
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

static bool is_missing(const char *field)
{
    static const char *const words[] = {"", "nan", "-nan", "n/a", "na", ".", "none", "null", "-"};
    for (size_t i = 0; i < sizeof words / sizeof *words; i++)
        if (strcasecmp(field, words[i]) == 0) return true;
    return false;
}

/* In place: the row is not read again. */
static void mend_comma(struct trk_table *table, char *field)
{
    char *comma = table->decimal_comma ? strchr(field, ',') : NULL;
    if (!comma) return;
    *comma = '.';
    table->was_comma = true;
}

bool trk_table_number(struct trk_table *table, int column, double *out_value, char out_error[TRK_ERROR_SIZE])
{
    *out_value = NAN;
    if (column < 0) return true;
    char *field = table->fields[column];
    if (is_missing(field)) return true;
    mend_comma(table, field);
    if (trk_parse_double(field, out_value) && isfinite(*out_value)) return true;
    return trk_lines_fail(&table->reading->lines, out_error, "%.60s is '%.40s', expected a finite number",
                          table->reading->header.names[column], field);
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
    mend_comma(table, field);
    if (trk_parse_time(field, unit_ns, out_ns)) return true;
    return trk_lines_fail(&table->reading->lines, out_error, "%.60s is '%.40s', expected a time",
                          table->reading->header.names[column], field);
}

/* --- guessing the unit of time -------------------------------------------------------------------------- */

enum { GUESS_ROWS = 1000 };

static int by_size(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* The middle of the steps forward in the first rows; 0 if there is none. */
static double middle_step(struct trk_table *table, int column, char out_error[TRK_ERROR_SIZE])
{
    double steps[GUESS_ROWS], last = NAN;
    size_t count = 0;
    for (int row = 0; row < GUESS_ROWS; row++) {
        double value;
        enum trk_line line = trk_table_next(table, out_error);
        if (line == TRK_LINE_END) break;
        if (line == TRK_LINE_FAILED || !trk_table_number(table, column, &value, out_error)) return -1;
        if (value > last) steps[count++] = value - last;
        if (!isnan(value)) last = value;
    }
    if (count == 0) return 0;
    qsort(steps, count, sizeof *steps, by_size);
    return steps[count / 2];
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
    double step = middle_step(table, column, out_error);
    if (step < 0) return 0;
    gzrewind(reading->lines.file);
    reading->lines.number = 0;
    while (reading->lines.number < header_line)
        if (trk_lines_next(&reading->lines, out_error) != TRK_LINE) return 0;
    for (size_t i = 0; i < sizeof units / sizeof *units; i++) {
        double step_ns = step * units[i].ns;
        if (step_ns < 1e9 / 2500 * 0.99 || step_ns > 1e9 / 20 * 1.01) continue;
        trk_assume(reading, "%.40s is in %s (steps of %g)", reading->header.names[column], units[i].name,
                   step);
        return units[i].ns;
    }
    /* One sample, or none: any unit will do. */
    if (step == 0) return 1e6;
    trk_lines_fail(
        &reading->lines, out_error,
        "%.60s has steps of %g, which is no rate of an eye tracker in any unit: expected the unit to "
        "be told (s, ms, us or ns)",
        reading->header.names[column], step);
    return 0;
}
