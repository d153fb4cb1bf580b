/* A toy program's command lines, parsed by a table of options: which are taken, which are refused and in what
 * words, and --help. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "option.h"

struct values {
    bool loud, quiet, soft;
    const char *name, *base, *suffix;
    int count, tones;
    uint32_t small;
    uint64_t large;
    float turn, weight, place[3];
    double pace;
    char collected[16];
};

#define INTO(field) DMN_INTO(struct values, field)

static bool take_letter(const struct dmn_option *option, const char *text, void *values, char *out_error)
{
    char *collected = ((struct values *)values)->collected;

    (void)option;
    if (strlen(text) != 1) return false;
    if (strlen(collected) == 3) return strcpy(out_error, "3 letters at most"), false;
    strcat(collected, text);
    return true;
}

static bool has_many(const void *values)
{
    return ((const struct values *)values)->count > 1;
}

static const char *letter_at(size_t index, const char **out_summary)
{
    *out_summary = index ? "the second letter" : "the first letter";
    return index == 0 ? "a" : index == 1 ? "b" : NULL;
}

static const struct dmn_option ROWS[] = {
    {.help = "First"},
    {.name = "name", .argument = "NAME", .help = "a name", INTO(name), .required = true},
    {.name = "base", .argument = "FILE", .help = "a base", INTO(base)},
    {.name = "suffix",
     .argument = "S",
     .help = "needs a base, by default or given",
     INTO(suffix),
     .need = {{"--base"}}},
    {.name = "loud", .help = "a flag", INTO(loud), .excludes = "quiet"},
    {.name = "quiet", .help = "a flag", INTO(quiet)},
    {.name = "soft", .help = "a flag", INTO(soft), .need = {{"--quiet"}, {"a --count above 1", has_many}}},
    {.help = "Second"},
    {.name = "count", .argument = "N", .help = "an int", INTO(count), .whole = {1, 100}},
    {.name = "tones",
     .argument = "A-VERY-LONG-ARGUMENT-NAME",
     .help = "aaaaaaaaa bbbbbbbbb ccccccccc ddddddddd eeeeeeeee fffffffff ggggggggg hhhhhhhhh iiiiiiiii 1234 "
             "jjjj",
     INTO(tones),
     .whole = {0, 7}},
    {.name = "small", .argument = "N", .help = "32 bits", INTO(small), .whole = {0, UINT32_MAX}},
    {.name = "large", .argument = "N", .help = "64 bits", INTO(large), .whole = {0, UINT64_MAX}},
    {.name = "turn",
     .argument = "DEG",
     .help = "a float",
     INTO(turn),
     .number = {.low = -360, .high = 360, .unit = "degrees"}},
    {.name = "weight",
     .argument = "W",
     .help = "a float",
     INTO(weight),
     .number = {.low = 0, .high = FLT_MAX, .open = true}},
    {.name = "place",
     .former = "spot",
     .argument = "X,Y,Z",
     .help = "floats",
     INTO(place[0]),
     .number = {.count = 3, .low = -10, .high = 10, .unit = "m"}},
    {.name = "pace",
     .argument = "F",
     .help = "a double",
     INTO(pace),
     .number = {.low = 0, .high = DBL_MAX, .unit = "seconds"}},
    {.name = "letter",
     .argument = "L",
     .help = "its own function",
     .take = take_letter,
     .wants = "one letter",
     .value_at = letter_at},
    {0},
};

static void help(void)
{
    dmn_option_help(ROWS);
}

static const struct dmn_option_set SET = {"toy", ROWS, help};

/* Catches what is written to a descriptor between begin() and end(). */
struct catch
{
    int descriptor, kept;
    FILE *file;
};

static struct catch begin(int descriptor)
{
    struct catch catch = {descriptor, dup(descriptor), tmpfile()};

    fflush(NULL);
    dup2(fileno(catch.file), descriptor);
    return catch;
}

static const char *end(struct catch *catch)
{
    static char text[8192];

    fflush(NULL);
    dup2(catch->kept, catch->descriptor);
    close(catch->kept);
    rewind(catch->file);
    text[fread(text, 1, sizeof(text) - 1, catch->file)] = '\0';
    fclose(catch->file);
    return text;
}

static char words[512], *arguments[32];
static int count;
static struct dmn_given given;

static enum dmn_option_result parse(const char *line, struct values *out)
{
    char *save = NULL;

    *out = (struct values){.pace = 2};
    snprintf(words, sizeof(words), "toy %s", line);
    count = 0;
    for (char *word = strtok_r(words, " ", &save); word; word = strtok_r(NULL, " ", &save))
        arguments[count++] = word;
    arguments[count] = NULL;
    return dmn_option_parse(&SET, count, arguments, out, &given);
}

static void taken(void **state)
{
    struct values v;

    (void)state;
    assert_int_equal(
        parse("--name=n one --count 100 --small 4294967295 two --large 18446744073709551615 --tones 0 "
              "--turn -360 --weight 1e-30 --place -10,0.5,10 --pace 1e300 --loud",
              &v),
        DMN_OPTIONS_TAKEN);
    assert_string_equal(v.name, "n");
    assert_null(v.base);
    assert_true(v.loud && !v.quiet);
    assert_int_equal(v.count, 100);
    assert_true(v.small == UINT32_MAX && v.large == UINT64_MAX && v.turn == -360 && v.weight == 1e-30f);
    assert_true(v.place[0] == -10 && v.place[1] == 0.5f && v.place[2] == 10 && v.pace == 1e300);
    assert_true(dmn_option_check(&SET, &given, &v));
    /* Operands are moved to the end, in their order. */
    assert_int_equal(count - given.operand, 2);
    assert_string_equal(arguments[given.operand], "one");
    assert_string_equal(arguments[given.operand + 1], "two");

    assert_int_equal(parse("--name n -- --count", &v), DMN_OPTIONS_TAKEN);
    assert_string_equal(arguments[given.operand], "--count");
    assert_true(v.pace == 2);

    /* Of an option given twice the last one counts, unless the option collects its values. */
    assert_int_equal(parse("--count 3 --letter a --count 4 --letter b --letter c", &v), DMN_OPTIONS_TAKEN);
    assert_int_equal(v.count, 4);
    assert_string_equal(v.collected, "abc");

    /* The start of a name is enough if it fits one option alone. */
    assert_int_equal(parse("--na n --cou=5 --q", &v), DMN_OPTIONS_TAKEN);
    assert_true(v.count == 5 && v.quiet && !strcmp(v.name, "n"));

    /* An option's older name sets the same field, and counts as that option. */
    assert_int_equal(parse("--spot 1,2,3", &v), DMN_OPTIONS_TAKEN);
    assert_true(v.place[0] == 1 && v.place[1] == 2 && v.place[2] == 3);
    assert_true(SET.rows[__builtin_ctzll(given.rows)].former && !(given.rows & (given.rows - 1)));
}

static const struct {
    const char *line, *words;
} REFUSED[] = {
    {"--nonsense", "unknown option --nonsense"},
    {"--nonsense=3", "unknown option --nonsense=3"},
    {"-n", "unknown option -n"},
    {"-xyz", "unknown option -x"},
    {"--s 1", "--s is short for more than one option: --suffix, --soft, --small, --spot"},
    {"--l=1", "--l is short for more than one option: --loud, --large, --letter"},
    {"--name", "--name needs a value"},
    {"--nam", "--name needs a value"},
    {"--loud=1", "--loud takes no value"},
    {"--count 0", "--count wants a whole number from 1 to 100, not '0'"},
    {"--count 101", "--count wants a whole number from 1 to 100, not '101'"},
    {"--count -1", "--count wants a whole number from 1 to 100, not '-1'"},
    {"--count +1", "--count wants a whole number from 1 to 100, not '+1'"},
    {"--count 1.5", "--count wants a whole number from 1 to 100, not '1.5'"},
    {"--count=", "--count wants a whole number from 1 to 100, not ''"},
    {"--count many", "--count wants a whole number from 1 to 100, not 'many'"},
    {"--count 4294967297", "--count wants a whole number from 1 to 100, not '4294967297'"},
    {"--small 4294967296", "--small wants a whole number from 0 to 4294967295, not '4294967296'"},
    {"--large 18446744073709551616",
     "--large wants a whole number from 0 to 18446744073709551615, not '18446744073709551616'"},
    {"--turn 360.5", "--turn wants degrees from -360 to 360, not '360.5'"},
    {"--turn nan", "--turn wants degrees from -360 to 360, not 'nan'"},
    {"--turn 1,2", "--turn wants degrees from -360 to 360, not '1,2'"},
    {"--turn 1x", "--turn wants degrees from -360 to 360, not '1x'"},
    {"--weight 0", "--weight wants a number above 0, not '0'"},
    {"--weight 1e-60", "--weight wants a number above 0, not '1e-60'"}, /* 0 as a float */
    {"--weight 1e60", "--weight wants a number above 0, not '1e60'"},   /* no float */
    {"--place 1,2", "--place wants X,Y,Z from -10 to 10 m, not '1,2'"},
    {"--place 1,2,3,4", "--place wants X,Y,Z from -10 to 10 m, not '1,2,3,4'"},
    {"--place 1,,3", "--place wants X,Y,Z from -10 to 10 m, not '1,,3'"},
    {"--spot", "--place needs a value"},
    {"--spot 1,2,11", "--place wants X,Y,Z from -10 to 10 m, not '1,2,11'"},
    {"--place 1,2,11", "--place wants X,Y,Z from -10 to 10 m, not '1,2,11'"},
    {"--pace -0.5", "--pace wants seconds of 0 or more, not '-0.5'"},
    {"--pace 1e999", "--pace wants seconds of 0 or more, not '1e999'"},
    {"--letter ab", "--letter wants one letter, not 'ab'"},
    {"--letter a --letter b --letter c --letter d", "--letter: 3 letters at most"},
    {"--count \033[31m", "--count wants a whole number from 1 to 100, not ' [31m'"},
    /* These are refused by dmn_option_check(). */
    {"--count 3", "--name NAME is missing"},
    {"--name n --suffix s", "--suffix needs --base"},
    {"--name n --soft", "--soft needs --quiet"},
    {"--name n --soft --quiet --count 1", "--soft needs a --count above 1"},
    {"--name n --loud --quiet", "--loud does not go with --quiet"},
    {"--name n --quiet --loud", "--loud does not go with --quiet"},
};

static void refused(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof(REFUSED) / sizeof(*REFUSED); i++) {
        struct values v;
        struct catch catch = begin(STDERR_FILENO);
        const enum dmn_option_result result = parse(REFUSED[i].line, &v);
        const bool checked = result == DMN_OPTIONS_TAKEN && dmn_option_check(&SET, &given, &v);
        const char *said = end(&catch);
        char expected[512];

        snprintf(expected, sizeof(expected), "toy: %s; see toy --help\n", REFUSED[i].words);
        assert_string_equal(said, expected);
        assert_true(result == DMN_OPTIONS_REFUSED || (result == DMN_OPTIONS_TAKEN && !checked));
    }
}

static void needs_met(void **state)
{
    struct values v;

    (void)state;
    parse("--name n --suffix s --base b", &v);
    assert_true(dmn_option_check(&SET, &given, &v));
    parse("--name n --suffix s", &v);
    v.base = "by default";
    assert_true(dmn_option_check(&SET, &given, &v));
    parse("--name n --soft --quiet --count 2", &v);
    assert_true(dmn_option_check(&SET, &given, &v));
}

static void answered(void **state)
{
    struct values v;
    struct catch catch = begin(STDOUT_FILENO);
    const enum dmn_option_result result = parse("--count 3 --help --nonsense", &v);
    const char *said = end(&catch);

    (void)state;
    assert_int_equal(result, DMN_OPTIONS_ANSWERED);
    assert_string_equal(
        said, "\n"
              "First\n"
              "  --name NAME             a name\n"
              "  --base FILE             a base\n"
              "  --suffix S              needs a base, by default or given\n"
              "  --loud                  a flag\n"
              "  --quiet                 a flag\n"
              "  --soft                  a flag\n"
              "\n"
              "Second\n"
              "  --count N               an int\n"
              "  --tones A-VERY-LONG-ARGUMENT-NAME\n"
              "                          aaaaaaaaa bbbbbbbbb ccccccccc ddddddddd eeeeeeeee fffffffff "
              "ggggggggg hhhhhhhhh iiiiiiiii 1234\n"
              "                          jjjj\n"
              "  --small N               32 bits\n"
              "  --large N               64 bits\n"
              "  --turn DEG              a float\n"
              "  --weight W              a float\n"
              "  --place X,Y,Z           floats; formerly --spot\n"
              "  --pace F                a double\n"
              "  --letter L              its own function\n"
              "    a                     the first letter\n"
              "    b                     the second letter\n"
              "\n"
              "  --help, --version       print this help, or the version, and exit\n");
    catch = begin(STDOUT_FILENO);
    assert_int_equal(parse("--vers", &v), DMN_OPTIONS_ANSWERED);
    assert_string_equal(end(&catch), "toy " FOVEAD_VERSION "\n");
}

/* Lines are filled to the last column, and broken only between words. */
static void wrapped(void **state)
{
    static const struct {
        int last;
        const char *end;
    } CASES[] = {{20, " y\n"}, {21, "\ny\n"}};

    (void)state;
    for (size_t i = 0; i < 2; i++) {
        char text[256], expected[256];
        struct catch catch;

        /* 98 letters, a blank, and a word that ends in column 119 or 120; "y" follows. */
        memset(text, 'x', 98);
        snprintf(text + 98, sizeof(text) - 98, " %.*s y", CASES[i].last - 1, "wwwwwwwwwwwwwwwwwwwwwwww");
        snprintf(expected, sizeof(expected), "%.*s%s", (int)strlen(text) - 2, text, CASES[i].end);
        catch = begin(STDOUT_FILENO);
        dmn_print_columns(stdout, "", 0, text);
        assert_string_equal(end(&catch), expected);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(taken),    cmocka_unit_test(refused), cmocka_unit_test(needs_met),
        cmocka_unit_test(answered), cmocka_unit_test(wrapped),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
