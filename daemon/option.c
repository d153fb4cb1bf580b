/* Command lines from tables of options. */
#include "option.h"

#include <getopt.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "numbers.h"
#include "print.h"

/* What getopt_long() returns: for row i, FIRST + i. Below are characters. */
enum { FIRST = 256, HELP = FIRST + DMN_OPTION_MOST, VERSION };

static bool is_end(const struct dmn_option *row)
{
    return !row->name && !row->help;
}

bool dmn_option_refuse(const struct dmn_option_set *set, const char *format, ...)
{
    va_list args;

    fprintf(stderr, "%s: ", set->program);
    va_start(args, format);
    dmn_vprint(stderr, format, args);
    va_end(args);
    fprintf(stderr, "; see %s --help\n", set->program);
    return false;
}

/* --- what rows say --- */

void dmn_print_columns(FILE *out, const char *left, int column, const char *text)
{
    int at = fprintf(out, "%s", left);

    if (at >= column && column) at = fprintf(out, "\n") - 1;
    for (bool first = true; *text; first = false) {
        int length = (int)strcspn(text, " ");

        if (!first && at + 1 + length > DMN_OPTION_COLUMNS) at = fprintf(out, "\n") - 1;
        at += fprintf(out, "%*s%.*s", at > column ? 1 : column - at, "", length, text);
        text += length;
        text += strspn(text, " ");
    }
    fputc('\n', out);
}

static void print_values(const struct dmn_option *row)
{
    const char *name, *summary;

    for (size_t i = 0; (name = row->value_at(i, &summary)); i++) {
        char left[64];

        snprintf(left, sizeof(left), "    %s", name);
        dmn_print_columns(stdout, left, DMN_OPTION_COLUMN, summary);
    }
}

void dmn_option_help(const struct dmn_option *rows)
{
    for (const struct dmn_option *row = rows; !is_end(row); row++) {
        char left[64], help[1024];

        if (!row->name) {
            printf("\n%s\n", row->help);
            continue;
        }
        snprintf(left, sizeof(left), "  --%s%s%s", row->name, row->argument ? " " : "",
                 row->argument ? row->argument : "");
        snprintf(help, sizeof(help), "%s%s%s", row->help, row->former ? "; formerly --" : "",
                 row->former ? row->former : "");
        dmn_print_columns(stdout, left, DMN_OPTION_COLUMN, help);
        if (row->value_at) print_values(row);
    }
    putchar('\n');
    dmn_print_columns(stdout, "  --help, --version", DMN_OPTION_COLUMN,
                      "print this help, or the version, and exit");
}

/* Write which arguments the row's limits allow. */
static void put_wants(const struct dmn_option *row, char *out, size_t size)
{
    const double low = row->number.low, high = row->number.high;
    const bool open = row->number.open, many = row->number.count > 1;
    const char *unit = row->number.unit;
    int length;

    if (row->whole.high) {
        snprintf(out, size, "a whole number from %llu to %llu", (unsigned long long)row->whole.low,
                 (unsigned long long)row->whole.high);
        return;
    }
    length = snprintf(out, size, "%s ", many ? row->argument : unit ? unit : "a number");
    if (high >= (double)FLT_MAX)
        length +=
            snprintf(out + length, size - (size_t)length, open ? "above %.15g" : "of %.15g or more", low);
    else
        length += snprintf(out + length, size - (size_t)length,
                           open ? "between %.15g and %.15g" : "from %.15g to %.15g", low, high);
    if (many && unit) snprintf(out + length, size - (size_t)length, " %s", unit);
}

/* --- reading arguments --- */

bool dmn_take_flag(const struct dmn_option *option, const char *text, void *values, char *out_error)
{
    (void)text, (void)out_error;
    return *(bool *)((char *)values + option->target) = true;
}

bool dmn_take_text(const struct dmn_option *option, const char *text, void *values, char *out_error)
{
    (void)out_error;
    *(const char **)((char *)values + option->target) = text;
    return true;
}

bool dmn_take_u64(const struct dmn_option *option, const char *text, void *values, char *out_error)
{
    (void)out_error;
    return dmn_parse_whole(text, option->whole.low, option->whole.high,
                           (uint64_t *)((char *)values + option->target));
}

bool dmn_take_u32(const struct dmn_option *option, const char *text, void *values, char *out_error)
{
    uint64_t whole;

    (void)out_error;
    if (!dmn_parse_whole(text, option->whole.low, option->whole.high, &whole)) return false;
    *(uint32_t *)((char *)values + option->target) = (uint32_t)whole;
    return true;
}

bool dmn_take_int(const struct dmn_option *option, const char *text, void *values, char *out_error)
{
    uint64_t whole;

    (void)out_error;
    if (!dmn_parse_whole(text, option->whole.low, option->whole.high, &whole)) return false;
    *(int *)((char *)values + option->target) = (int)whole;
    return true;
}

static int count_of(const struct dmn_option *option)
{
    return option->number.count ? option->number.count : 1;
}

bool dmn_option_numbers(const struct dmn_option *option, const char *text, double *out_numbers)
{
    const double low = option->number.low, high = option->number.high;
    bool good = dmn_parse_numbers(text, count_of(option), out_numbers);

    for (int i = 0; good && i < count_of(option); i++) {
        const double n = out_numbers[i];

        good = n >= low && n <= high;
        /* A float must not be rounded to the very number that is refused. */
        if (good && option->number.open) good = (float)n > (float)low && (float)n < (float)high;
    }
    return good;
}

bool dmn_take_doubles(const struct dmn_option *option, const char *text, void *values, char *out_error)
{
    double numbers[DMN_OPTION_NUMBERS];

    (void)out_error;
    if (!dmn_option_numbers(option, text, numbers)) return false;
    memcpy((char *)values + option->target, numbers, (size_t)count_of(option) * sizeof(*numbers));
    return true;
}

bool dmn_take_floats(const struct dmn_option *option, const char *text, void *values, char *out_error)
{
    float *target = (float *)((char *)values + option->target);
    double numbers[DMN_OPTION_NUMBERS];

    (void)out_error;
    if (!dmn_option_numbers(option, text, numbers)) return false;
    for (int i = 0; i < count_of(option); i++) target[i] = (float)numbers[i];
    return true;
}

/* --- command lines --- */

/* The table of the rows for getopt_long(), which the caller frees. NULL if memory is short. */
static struct option *make_table(const struct dmn_option *rows)
{
    struct option *table = calloc(2 * DMN_OPTION_MOST + 3, sizeof(*table)), *next = table;

    if (!table) return NULL;
    for (int i = 0; i < DMN_OPTION_MOST && !is_end(&rows[i]); i++) {
        const int argument = rows[i].argument ? required_argument : no_argument;

        if (rows[i].name) *next++ = (struct option){rows[i].name, argument, NULL, FIRST + i};
        if (rows[i].former) *next++ = (struct option){rows[i].former, argument, NULL, FIRST + i};
    }
    *next++ = (struct option){"help", no_argument, NULL, HELP};
    *next = (struct option){"version", no_argument, NULL, VERSION};
    return table;
}

/* Refuse a word that is no option, or short for more than one. */
static bool refuse_unknown(const struct dmn_option_set *set, const struct option *table, const char *word)
{
    const char *name = word + strspn(word, "-");
    const size_t length = strcspn(name, "=");
    char several[DMN_OPTION_ERROR_SIZE] = "";
    int count = 0;

    for (const struct option *option = table; option->name; option++) {
        const size_t end = strlen(several);

        if (strncmp(option->name, name, length) != 0) continue;
        snprintf(several + end, sizeof(several) - end, "%s--%s", count++ ? ", " : "", option->name);
    }
    if (count < 2 || strncmp(word, "--", 2) != 0) return dmn_option_refuse(set, "unknown option %s", word);
    return dmn_option_refuse(set, "%.*s is short for more than one option: %s",
                             (int)(name - word + (long)length), word, several);
}

/* Refuse what getopt_long() could not take. result is ':' if an argument is missing. */
static bool refuse_word(const struct dmn_option_set *set, const struct option *table, int result, char **argv)
{
    const char letter[] = {'-', (char)optopt, '\0'};
    const struct option *option = table;

    while (option->name && option->val != optopt) option++;
    if (option->name && result == ':') return dmn_option_refuse(set, "--%s needs a value", option->name);
    if (option->name) return dmn_option_refuse(set, "--%s takes no value", option->name);
    return refuse_unknown(set, table, optopt ? letter : argv[optind - 1]);
}

static bool take(const struct dmn_option_set *set, const struct dmn_option *row, const char *text,
                 void *values)
{
    char error[DMN_OPTION_ERROR_SIZE] = "", wants[DMN_OPTION_ERROR_SIZE];

    if (row->take(row, text, values, error)) return true;
    if (*error) return dmn_option_refuse(set, "--%s: %s", row->name, error);
    put_wants(row, wants, sizeof(wants));
    return dmn_option_refuse(set, "--%s wants %s, not '%s'", row->name, row->wants ? row->wants : wants,
                             text);
}

enum dmn_option_result dmn_option_parse(const struct dmn_option_set *set, int argc, char **argv, void *values,
                                        struct dmn_given *out_given)
{
    enum dmn_option_result result = DMN_OPTIONS_TAKEN;
    struct option *table = make_table(set->rows);
    int option;

    if (!table) return dmn_option_refuse(set, "out of memory"), DMN_OPTIONS_REFUSED;
    *out_given = (struct dmn_given){0};
    opterr = 0;
    optind = 0;
    while (result == DMN_OPTIONS_TAKEN && (option = getopt_long(argc, argv, ":", table, NULL)) != -1) {
        if (option == HELP || option == VERSION) {
            if (option == HELP) set->help();
            if (option == VERSION) printf("%s " FOVEAD_VERSION "\n", set->program);
            result = DMN_OPTIONS_ANSWERED;
        } else if (option < FIRST) {
            refuse_word(set, table, option, argv);
            result = DMN_OPTIONS_REFUSED;
        } else if (take(set, &set->rows[option - FIRST], optarg, values)) {
            out_given->rows |= UINT64_C(1) << (option - FIRST);
        } else {
            result = DMN_OPTIONS_REFUSED;
        }
    }
    out_given->operand = optind;
    free(table);
    return result;
}

/* --- what goes together --- */

static bool is_given(const struct dmn_given *given, const struct dmn_option_set *set,
                     const struct dmn_option *row)
{
    return given->rows >> (row - set->rows) & 1;
}

/* The row of that name, which must be there. */
static const struct dmn_option *find(const struct dmn_option_set *set, const char *name)
{
    const struct dmn_option *row = set->rows;

    while (!row->name || strcmp(row->name, name) != 0) row++;
    return row;
}

static bool is_met(const struct dmn_option_set *set, const struct dmn_given *given, const void *values,
                   const struct dmn_option_need *need)
{
    const struct dmn_option *other;

    if (need->is_met) return need->is_met(values);
    other = find(set, need->what + strlen("--"));
    return is_given(given, set, other) ||
           (other->take == dmn_take_text && *(const char *const *)((const char *)values + other->target));
}

bool dmn_option_check(const struct dmn_option_set *set, const struct dmn_given *given, const void *values)
{
    for (const struct dmn_option *row = set->rows; !is_end(row); row++) {
        if (!row->name) continue;
        if (!is_given(given, set, row)) {
            if (row->required) return dmn_option_refuse(set, "--%s %s is missing", row->name, row->argument);
            continue;
        }
        for (int i = 0; i < 2; i++)
            if (row->need[i].what && !is_met(set, given, values, &row->need[i]))
                return dmn_option_refuse(set, "--%s needs %s", row->name, row->need[i].what);
        if (row->excludes && is_given(given, set, find(set, row->excludes)))
            return dmn_option_refuse(set, "--%s does not go with --%s", row->name, row->excludes);
    }
    return true;
}
