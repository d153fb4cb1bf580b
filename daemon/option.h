/* option: command lines. A program describes each of its options by one row of a table. What getopt_long() is
 * given, the text of --help, what a refusal says, and the checks of which options go together follow from the
 * rows. */
#ifndef FOVEAD_DAEMON_OPTION_H
#define FOVEAD_DAEMON_OPTION_H

#include <float.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

enum {
    DMN_OPTION_ERROR_SIZE = 512,
    DMN_OPTION_MOST = 64,    /* rows of a table */
    DMN_OPTION_NUMBERS = 4,  /* in one argument */
    DMN_OPTION_COLUMN = 26,  /* where --help's second column begins */
    DMN_OPTION_COLUMNS = 120 /* the width of --help */
};

/* What an option needs besides itself. */
struct dmn_option_need {
    const char *what; /* for the refusal, such as "--env"; NULL: nothing */
    /* NULL: what is an option, and was given, or has a text by default. */
    bool (*is_met)(const void *values);
};

struct dmn_option {
    const char *name;     /* without dashes; NULL: help is the heading of the rows that follow */
    const char *former;   /* an older name that is taken as well; or NULL */
    const char *argument; /* as --help calls it; NULL: the option takes none */
    const char *help;
    /* Read text, which is NULL for an option without argument, into the program's values; text stays valid.
     * False if it cannot be taken: the refusal then consists of *out_error, or, if that is "", of what the
     * option wants. Usually DMN_INTO() chooses it. */
    bool (*take)(const struct dmn_option *option, const char *text, void *values,
                 char out_error[DMN_OPTION_ERROR_SIZE]);
    size_t target; /* offset of the field of values that dmn_take_...() fills in */
    struct {
        uint64_t low, high;
    } whole; /* of a whole number, both included */
    struct {
        int count; /* of numbers with commas between them, at most DMN_OPTION_NUMBERS; 0 is 1 */
        double low, high;
        bool open;        /* low and high themselves are refused */
        const char *unit; /* or NULL */
    } number;
    const char *wants; /* what the option takes, for refusals; NULL: it is told from the limits */
    /* The values that the option takes and what each means, listed below its help; NULL at the end. May be
     * NULL. */
    const char *(*value_at)(size_t index, const char **out_summary);
    bool required;
    struct dmn_option_need need[2];
    const char *excludes; /* the name of an option that this one does not go with; or NULL */
};

/* The target of a row, and the function that fills in a field of that type: a bool is set to true, a string
 * points to the argument, numbers are read. */
#define DMN_INTO(type, field)                                                                                \
    .target = offsetof(type, field),                                                                         \
    .take = _Generic(((type *)0)->field,                                                                     \
        bool: dmn_take_flag,                                                                                 \
        const char *: dmn_take_text,                                                                         \
        int: dmn_take_int,                                                                                   \
        uint32_t: dmn_take_u32,                                                                              \
        uint64_t: dmn_take_u64,                                                                              \
        float: dmn_take_floats,                                                                              \
        double: dmn_take_doubles)

bool dmn_take_flag(const struct dmn_option *option, const char *text, void *values, char *out_error);
bool dmn_take_text(const struct dmn_option *option, const char *text, void *values, char *out_error);
bool dmn_take_int(const struct dmn_option *option, const char *text, void *values, char *out_error);
bool dmn_take_u32(const struct dmn_option *option, const char *text, void *values, char *out_error);
bool dmn_take_u64(const struct dmn_option *option, const char *text, void *values, char *out_error);
/* option->number.count of them, from the target on. */
bool dmn_take_floats(const struct dmn_option *option, const char *text, void *values, char *out_error);
bool dmn_take_doubles(const struct dmn_option *option, const char *text, void *values, char *out_error);

/* For other functions that take an option: option->number.count numbers within its limits. */
bool dmn_option_numbers(const struct dmn_option *option, const char *text, double *out_numbers);

struct dmn_option_set {
    const char *program;
    const struct dmn_option *rows; /* at most DMN_OPTION_MOST; the last has neither name nor help */
    void (*help)(void);            /* prints all of --help */
};

/* What a command line holds. */
struct dmn_given {
    uint64_t rows; /* a bit for each row that was given */
    int operand;   /* index in argv of the first argument that belongs to no option; argc: there is none */
};

enum dmn_option_result { DMN_OPTIONS_TAKEN, DMN_OPTIONS_ANSWERED, DMN_OPTIONS_REFUSED };

/* Take all options out of argv, whose operands are moved to its end, and fill in values, which hold the
 * defaults. An option that is given again replaces what it said before, unless its take() collects. Answers
 * --help and --version on stdout. Refuses with one line on stderr. */
enum dmn_option_result dmn_option_parse(const struct dmn_option_set *set, int argc, char **argv, void *values,
                                        struct dmn_given *out_given);

/* Check what goes together, once all defaults are filled in. False after one line on stderr. */
bool dmn_option_check(const struct dmn_option_set *set, const struct dmn_given *given, const void *values);

/* Print "PROGRAM: ...; see PROGRAM --help" on stderr; returns false. */
bool dmn_option_refuse(const struct dmn_option_set *set, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* Print the rows for --help, --help and --version last. */
void dmn_option_help(const struct dmn_option *rows);

/* Print what stands on the left, and text from that column on, broken between words where it is longer than
 * DMN_OPTION_COLUMNS allow. */
void dmn_print_columns(FILE *out, const char *left, int column, const char *text);

#endif
