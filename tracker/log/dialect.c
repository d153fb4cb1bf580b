/* How programs and spreadsheets differ in writing the same rows, whatever the format. */
#include "log/dialect.h"

#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* --- rows --- */

static bool is_blank(const char *text)
{
    return text[strspn(text, " \t\v\f\r")] == '\0';
}

/* Take the next line that is not empty. */
static enum trk_line next_full_line(struct trk_lines *lines, char out_error[TRK_ERROR_SIZE])
{
    enum trk_line line;
    do {
        line = trk_lines_next(lines, out_error);
    } while (line == TRK_LINE && is_blank(lines->text));
    return line;
}

/* The separator named by Excel's first line, "sep=;", which may be in quotes; 0 if the line is not such a
 * line. */
static char separator_named_by(const char *text)
{
    text += *text == '"';
    if (strncasecmp(text, "sep=", 4) != 0 || !text[4] || !strchr("\t;,|", text[4])) return 0;
    return text[5 + (text[5] == '"')] == '\0' ? text[4] : 0;
}

enum trk_line trk_first_row(struct trk_reading *reading, char out_error[TRK_ERROR_SIZE])
{
    enum trk_line line = next_full_line(&reading->lines, out_error);
    if (line != TRK_LINE) return line;
    reading->separator = separator_named_by(reading->lines.text);
    return reading->separator ? next_full_line(&reading->lines, out_error) : line;
}

static bool ends_with(const char *text, const char *end)
{
    size_t length = strlen(text), size = strlen(end);
    while (length > 0 && isspace((unsigned char)text[length - 1])) length--;
    return length >= size && memcmp(text + length - size, end, size) == 0;
}

enum trk_line trk_next_row(struct trk_reading *reading, char out_error[TRK_ERROR_SIZE])
{
    struct trk_lines *lines = &reading->lines;
    const char *closes = reading->format->closes;
    enum trk_line line = next_full_line(lines, out_error);
    reading->rows += line == TRK_LINE;
    if (line != TRK_LINE || lines->has_end || (closes && ends_with(lines->text, closes))) return line;
    reading->cut_line = lines->number;
    return TRK_LINE_END;
}

enum trk_line trk_short_row(struct trk_reading *reading)
{
    char error[TRK_ERROR_SIZE];
    size_t number = reading->lines.number;
    if (reading->rows < 2 || next_full_line(&reading->lines, error) != TRK_LINE_END) return TRK_LINE_FAILED;
    reading->cut_line = number;
    return TRK_LINE_END;
}

/* --- fields --- */

static char *skip_blanks(char *text, char separator)
{
    while (*text == ' ' || (*text == '\t' && separator != '\t')) text++;
    return text;
}

/* The loop is by hand because fields have only a few letters, and strspn() and its like would build a table
 * for each field. */
static size_t split_runs(char *text, char *out_fields[TRK_MAX_FIELDS])
{
    size_t count = 0;
    for (char *at = skip_blanks(text, TRK_BLANKS); *at; at = skip_blanks(at, TRK_BLANKS)) {
        if (count < TRK_MAX_FIELDS) out_fields[count] = at;
        count++;
        while (*at && *at != ' ' && *at != '\t') at++;
        if (*at) *at++ = '\0';
    }
    return count;
}

/* The closing quote of a field that begins with a quote. NULL if there is none, or if more text follows it in
 * the field. *out_next becomes the separator after the field, or the end of the text. */
static char *closing_quote(char *text, char separator, char **out_next)
{
    for (char *at = text + 1; (at = strchr(at, '"')); at += 2) {
        if (at[1] == '"') continue;
        *out_next = skip_blanks(at + 1, separator);
        return **out_next == separator || **out_next == '\0' ? at : NULL;
    }
    return NULL;
}

/* Replace the field by the text between its quotes. */
static void unquote(char *text, const char *close)
{
    char *to = text;
    for (const char *from = text + 1; from < close; from++) {
        *to++ = *from;
        from += *from == '"';
    }
    *to = '\0';
}

size_t trk_split(char *text, char separator, char *out_fields[TRK_MAX_FIELDS])
{
    const bool is_table = separator == ',' || separator == ';' || separator == '\t' || separator == '|';
    size_t count = 0;
    if (separator == TRK_BLANKS) return split_runs(text, out_fields);
    for (char *next = text; next; count++) {
        char *field = is_table ? skip_blanks(next, separator) : next;
        char *close = is_table && *field == '"' ? closing_quote(field, separator, &next) : NULL;
        if (!close) next = strchrnul(field, separator);
        char *end = next;
        if (*next)
            *next++ = '\0';
        else
            next = NULL;
        if (close)
            unquote(field, close);
        else
            while (is_table && end > field && (end[-1] == ' ' || end[-1] == '\t')) *--end = '\0';
        if (count < TRK_MAX_FIELDS) out_fields[count] = field;
    }
    return count;
}

/* A tab decides at once, because no column name contains a tab. Names do contain some commas and semicolons,
 * so these are counted. */
char trk_separator_of(const char *line)
{
    size_t semicolons = 0, commas = 0;
    bool is_quoted = false;
    for (const char *c = line; *c; c++) {
        is_quoted ^= *c == '"';
        if (is_quoted) continue;
        if (*c == '\t') return '\t';
        semicolons += *c == ';';
        commas += *c == ',';
    }
    return semicolons == 0 && commas == 0 ? TRK_BLANKS : semicolons >= commas ? ';' : ',';
}

/* --- values --- */

bool trk_is_missing(const char *field)
{
    static const char *const words[] = {"",     "n/a",  "na",  "<na>", ".",  "..",      "?",
                                        "none", "null", "nil", "-",    "--", "missing", "n. def."};
    /* Printers write NaN in longer forms too: nan(ind), -1.#IND00. Spreadsheets write #N/A, #NV, #VALUE! and
     * others. */
    static const char *const starts[] = {"nan", "1.#ind", "1.#qnan", "1.#snan"};
    if (*field == '#') return true;
    for (size_t i = 0; i < sizeof words / sizeof *words; i++)
        if (strcasecmp(field, words[i]) == 0) return true;
    field += *field == '-' || *field == '+';
    for (size_t i = 0; i < sizeof starts / sizeof *starts; i++)
        if (strncasecmp(field, starts[i], strlen(starts[i])) == 0) return true;
    return false;
}

static void mend_comma(struct trk_reading *reading, char *field)
{
    char *comma = strchr(field, ',');
    if (!comma) return;
    *comma = '.';
    reading->has_decimal_commas = true;
}

bool trk_field_number(struct trk_reading *reading, char *field, double *out_value)
{
    *out_value = NAN;
    if (trk_parse_double(field, out_value)) {
        if (isnan(*out_value)) *out_value = NAN;
        return !isinf(*out_value);
    }
    *out_value = NAN;
    if (trk_is_missing(field)) return true;
    mend_comma(reading, field);
    return trk_parse_double(field, out_value) && isfinite(*out_value);
}

/* For a time that is written with an exponent, note how exact it is. */
static void note_exponent(struct trk_reading *reading, const char *field, double unit_ns)
{
    if (reading->has_plain_times) return;
    const char *exponent = strpbrk(field, "eE"), *point = strchr(field, '.');
    if (!exponent) {
        reading->has_plain_times = true;
        return;
    }
    double digits = point && point < exponent ? (double)(exponent - point - 1) : 0;
    double step_ns = pow(10, strtod(exponent + 1, NULL) - digits) * unit_ns;
    if (!*reading->exponent_time || step_ns < reading->exponent_step_ns) reading->exponent_step_ns = step_ns;
    if (!*reading->exponent_time)
        snprintf(reading->exponent_time, sizeof reading->exponent_time, "%s", field);
}

bool trk_field_time(struct trk_reading *reading, char *field, double unit_ns, int64_t *out_ns)
{
    if (!trk_parse_time(field, unit_ns, out_ns)) {
        mend_comma(reading, field);
        if (!trk_parse_time(field, unit_ns, out_ns)) return false;
    }
    note_exponent(reading, field, unit_ns);
    return true;
}

void trk_say_dialect(struct trk_reading *reading)
{
    const struct trk_lines *lines = &reading->lines;
    if (reading->has_decimal_commas) trk_assume(reading, "commas in numbers are decimal");
    if (reading->cut_line) trk_assume(reading, "line %zu was cut off and is left out", reading->cut_line);
    if (reading->held) trk_assume(reading, "times that go back, held at the time before: %zu", reading->held);
    if (lines->ends_in_zeros) trk_assume(reading, "the file ends in zero bytes, which are left out");
    if (lines->is_gzip_cut) trk_assume(reading, "the gzip data is cut off: the rest is lost");
}
