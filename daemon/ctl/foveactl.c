/* foveactl: its options, one row each, and running the command that the command line names. */
#include <ctype.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ctl.h"
#include "image_options.h"
#include "option.h"
#include "streams.h"

#define INTO(field) DMN_INTO(struct ctl, field)

/* --- arguments of their own kind --- */

static bool take_address(const struct dmn_option *option, const char *text, void *values, char *out_error)
{
    struct ctl *ctl = values;

    (void)option;
    return ctl->has_address = pro_address_parse(text, &ctl->address, out_error);
}
_Static_assert((int)DMN_OPTION_ERROR_SIZE >= (int)PRO_ERROR_SIZE, "an address's error has no room");

static bool take_view(const struct dmn_option *option, const char *text, void *values, char *out_error)
{
    struct ctl *ctl = values;

    (void)option, (void)out_error;
    ctl->view_gaze = !strncmp(text, "gaze,", 5);
    ctl->has_view = ctl->view_gaze ? dmn_parse_numbers(text + 5, 1, &ctl->view[2])
                                   : dmn_parse_numbers(text, 3, ctl->view);
    return ctl->has_view && ctl->view[2] > 0 && ctl->view[2] < 180 && ctl->view[1] >= -90 &&
           ctl->view[1] <= 90;
}

static bool take_at(const struct dmn_option *option, const char *text, void *values, char *out_error)
{
    struct ctl *ctl = values;

    (void)option, (void)out_error;
    ctl->has_at = dmn_parse_numbers(text, 4, ctl->at) && ctl->at[2] > 0 && ctl->at[3] > 0;
    for (int i = 0; i < 4; i++) ctl->has_at = ctl->has_at && fabs(ctl->at[i]) <= 100;
    return ctl->has_at;
}

static bool take_size(const struct dmn_option *option, const char *text, void *values, char *out_error)
{
    struct ctl *ctl = values;

    (void)option, (void)out_error;
    return dmn_parse_size(text, &ctl->width, &ctl->height) && ctl->height && ctl->width <= 16384 &&
           ctl->height <= 16384;
}

static bool take_screen(const struct dmn_option *option, const char *text, void *values, char *out_error)
{
    struct ctl *ctl = values;
    double numbers[2];

    (void)option, (void)out_error;
    ctl->log.screen_fov_deg = ctl->log.screen_width_m = ctl->log.screen_distance_m = 0;
    if (dmn_parse_numbers(text, 1, &ctl->log.screen_fov_deg)) return ctl->log.screen_fov_deg > 0;
    ctl->log.screen_fov_deg = 0;
    if (!dmn_parse_numbers(text, 2, numbers) || numbers[0] <= 0 || numbers[1] <= 0) return false;
    ctl->log.screen_width_m = numbers[0];
    ctl->log.screen_distance_m = numbers[1];
    return true;
}

/* --- the rows --- */

/* --help writes the commands that take an option before its help, except under the first heading. */
static const struct dmn_option ROWS[] = {
    {.help = "Options of every command that connects to fovead"},
    {.name = "connect",
     .argument = "ADDRESS",
     .help = "unix:PATH, of this user or root, or tcp:HOST:PORT; default: $XDG_RUNTIME_DIR/fovead.sock, else "
             "/tmp/fovead-UID/fovead.sock. FOVEAD_TOKEN in the environment is sent as token",
     .take = take_address},
    {.name = "wait", .help = "wait until fovead is up, at most ten minutes", INTO(wait)},

    {.help = "Options of some commands"},
    {.name = "json", .help = "print one JSON object", INTO(json)},
    {.name = "for",
     .argument = "SECONDS",
     .help =
         "end after so long; default: watch and view end with the daemon or at Ctrl-C, a recording at record "
         "--stop",
     INTO(seconds),
     .number = {.low = 0, .high = 1e7, .unit = "seconds"},
     .excludes = "stop"},
    {.name = "until-finished", .help = "end when the gaze recording has ended", INTO(until_finished)},
    {.name = "stop", .help = "end the recording", INTO(stop)},
    {.name = "replace", .help = "replace a file that is there", INTO(replace), .excludes = "stop"},
    {.name = "view",
     .argument = "YAW,PITCH,FOV",
     .help = "what lies in that direction, in degrees right and up of forward, with that horizontal field of "
             "view; or gaze,FOV: what lies where the gaze is",
     .take = take_view,
     .wants = "YAW,PITCH,FOV or gaze,FOV in degrees"},
    {.name = "at",
     .argument = "LEFT,TOP,WIDTH,HEIGHT",
     .help = "where the view is on the eye tracker's screen, as shares of the screen's width and height; "
             "default: it fills the screen",
     .take = take_at,
     .wants = "LEFT,TOP,WIDTH,HEIGHT, width and height above 0 and none beyond 100"},
    {.name = "size",
     .argument = "WxH",
     .help = "pixels of the view; default: 1280x1280",
     .take = take_size,
     .wants = "WxH, up to 16384x16384",
     .need = {{"--view"}}},
    {.name = "exposure",
     .argument = "STOPS",
     .help = "brighten by so many stops, or auto: half of the sphere above middle grey, half below; default: "
             "0. An .exr keeps the radiance as it is",
     .take = dmn_take_exposure,
     .target = offsetof(struct ctl, exposure),
     .number = {.low = -64, .high = 64},
     .wants = "stops from -64 to 64, or auto"},
    {.name = "settle",
     .argument = "SECONDS",
     .help = "wait so long for finer tiles once the whole picture is there; default: 1.5",
     INTO(settle),
     .number = {.low = 0, .high = 1e7, .unit = "seconds"}},
    {.name = "within",
     .argument = "SECONDS",
     .help = "give up if the whole picture is not there by then; default: 120",
     INTO(within),
     .number = {.low = 0, .high = 1e7, .unit = "seconds"}},
    {.name = "by",
     .help = "X,Y,Z is how far to move to the right, up and backward (the axes of the scene)",
     INTO(by)},
    {.name = "gaze", .argument = "LOG", .help = "draw the path of this recorded gaze", INTO(gaze)},
    {.name = "ppd",
     .argument = "N",
     .help = "pixels per degree as the pictures are seen, 1 to 300; default: 67.02, a screen at arm's "
             "length. Headsets have 12 to 25",
     INTO(ppd),
     .number = {.low = 1, .high = RND_FLIP_MAX_PPD, .unit = "pixels per degree"}},
    {.name = "ldr",
     .help = "compare what a display shows (LDR-FLIP), even if both files hold radiance (else HDR-FLIP)",
     INTO(ldr)},
    {.name = "map",
     .argument = "FILE.png",
     .help = "draw where the pictures differ: from black, no difference, to white",
     INTO(map)},
    {.name = "format",
     .argument = "NAME",
     .help = "the log's format, if its content does not tell",
     INTO(log.format)},
    {.name = "time-unit",
     .argument = "UNIT",
     .help = "unit of the log's times: s, ms, us or ns",
     INTO(log.time_unit)},
    {.name = "frame",
     .argument = "XYZ",
     .help = "where the log's +X, +Y and +Z point: L or R, U or D, F or B",
     INTO(log.frame)},
    {.name = "screen",
     .argument = "WIDTH,DISTANCE",
     .help = "the screen of a log in screen coordinates: its width and distance in metres, or its width in "
             "degrees",
     .take = take_screen,
     .wants = "WIDTH,DISTANCE in metres, or degrees across"},
    {.name = "recording",
     .argument = "NAME",
     .help = "which of several recordings in a file: its name, its participant, or PARTICIPANT/NAME",
     INTO(log.recording)},
    {0},
};
enum { ROW_COUNT = sizeof(ROWS) / sizeof(*ROWS) };
_Static_assert(ROW_COUNT <= DMN_OPTION_MOST + 1, "more rows than fit");
_Static_assert(RND_FLIP_MAX_PPD == 300, "the row of --ppd names another number");

#define ADDRESS(command) &command,
static const struct ctl_command *const COMMANDS[] = {CTL_COMMANDS(ADDRESS) NULL};

static bool takes(const struct ctl_command *command, const char *option)
{
    const size_t length = strlen(option);

    for (const char *word = command->options; *word; word += strcspn(word, " "), word += strspn(word, " "))
        if (strcspn(word, " ") == length && !strncmp(word, option, length)) return true;
    return false;
}

/* --- --help --- */

enum { COMMAND_COLUMN = 29, HELP_SIZE = 640 };

static void append(char text[HELP_SIZE], const char *before, const char *more)
{
    const size_t length = strlen(text);

    snprintf(text + length, HELP_SIZE - length, "%s%s", before, more);
}

/* Write "watch, record: HELP": the commands that take an option, and its help. The first word of "gaze info",
 * "gaze plot" is written once. */
static void put_help(const struct dmn_option *row, char out[HELP_SIZE])
{
    const char *before = "";

    *out = '\0';
    for (const struct ctl_command *const *c = COMMANDS; *c; c++) {
        const char *name = (*c)->name;
        const size_t first = strcspn(name, " ");

        if (!takes(*c, row->name)) continue;
        if (name[first] && !strncmp(name, before, first + 1)) name += first + 1;
        append(out, *before ? ", " : "", name);
        before = (*c)->name;
    }
    append(out, ": ", row->help);
}

static void help(void)
{
    struct dmn_option shown[ROW_COUNT];
    char text[ROW_COUNT][HELP_SIZE];
    int headings = 0;

    puts(
        "Usage: foveactl [OPTION]... COMMAND\n\nShows and steers what a running fovead renders.\n\nCommands");
    for (const struct ctl_command *const *c = COMMANDS; *c; c++) {
        char usage[64];

        snprintf(usage, sizeof(usage), "  %s %s", (*c)->name, (*c)->operands);
        dmn_print_columns(stdout, usage, COMMAND_COLUMN, (*c)->summary);
    }
    memcpy(shown, ROWS, sizeof(ROWS));
    for (int i = 0; i < ROW_COUNT - 1; i++) {
        headings += !ROWS[i].name;
        if (!ROWS[i].name || headings < 2) continue;
        put_help(&ROWS[i], text[i]);
        shown[i].help = text[i];
    }
    dmn_option_help(shown);
}

static const struct dmn_option_set SET = {"foveactl", ROWS, help};

/* --- the command line --- */

bool ctl_fail(const char *format, ...)
{
    va_list args;

    fputs("foveactl: ", stderr);
    va_start(args, format);
    dmn_vprint(stderr, format, args);
    va_end(args);
    fputc('\n', stderr);
    return false;
}

bool ctl_is_picture(const struct ctl *ctl, const char *path)
{
    return dmn_image_is_named(path) ||
           ctl_fail("%s wants a name that ends in " DMN_IMAGE_ENDS ", not '%s'", ctl->command, path);
}

/* The number of words of a command line (which ends with NULL) that are this command's name; 0 if it is
 * another command. */
static int words_of(const char *name, char *const *words)
{
    size_t length = strlen(words[0]);

    if (strcmp(name, words[0]) == 0) return 1;
    if (strncmp(name, words[0], length) != 0 || name[length] != ' ' || !words[1]) return 0;
    return strcmp(name + length + 1, words[1]) == 0 ? 2 : 0;
}

static bool fits(const struct ctl_command *command, const struct dmn_given *given, int operands)
{
    int most = 0;

    for (const char *word = command->operands; *word; word += strspn(word, " "), most++)
        word += strcspn(word, " ");
    if (operands > most || operands < most - (*command->operands == '['))
        return ctl_fail("usage: foveactl %s %s", command->name, command->operands);
    for (int i = 0; i < ROW_COUNT - 1; i++)
        if (given->rows >> i & 1 && !takes(command, ROWS[i].name))
            return ctl_fail("--%s does not go with %s", ROWS[i].name, command->name);
    return true;
}

/* Parse the command line. -1: run the command; else the exit status. */
static int parse(int argc, char **argv, struct ctl *ctl, const struct ctl_command **out_command)
{
    const struct ctl_command *const *command = COMMANDS;
    struct dmn_given given;
    char **operand;
    int words = 0;

    switch (dmn_option_parse(&SET, argc, argv, ctl, &given)) {
    case DMN_OPTIONS_ANSWERED:
        return 0;
    case DMN_OPTIONS_REFUSED:
        return 2;
    case DMN_OPTIONS_TAKEN:
        break;
    }
    operand = argv + given.operand;
    if (!*operand) return dmn_option_refuse(&SET, "which command?"), 2;
    while (*command && (words = words_of((*command)->name, operand)) == 0) command++;
    if (!*command) return dmn_option_refuse(&SET, "there is no command '%s'", *operand), 2;
    ctl->command = *operand;
    ctl->operand = operand + words;
    if (!fits(*command, &given, argc - given.operand - words)) return 2;
    if (!dmn_option_check(&SET, &given, ctl)) return 2;
    *out_command = *command;
    return -1;
}

/* getopt takes "-30,10" for an option. A space before it makes it an operand; reading numbers skips spaces.
 */
static bool hide_negatives(int argc, char **argv)
{
    for (int i = 1; i < argc; i++) {
        char *hidden;

        if (argv[i][0] != '-' || !(isdigit((unsigned char)argv[i][1]) || argv[i][1] == '.')) continue;
        if (asprintf(&hidden, " %s", argv[i]) < 0) return ctl_fail("out of memory");
        argv[i] = hidden;
    }
    return true;
}

int main(int argc, char **argv)
{
    struct ctl ctl = {.seconds = INFINITY,
                      .settle = 1.5,
                      .within = 120,
                      .width = 1280,
                      .height = 1280,
                      .ppd = RND_FLIP_PPD,
                      .arguments = argv};
    const struct ctl_command *command = NULL;
    char **own = calloc((size_t)argc + 1, sizeof(*own));
    int status = 1;

    dmn_streams_open("foveactl");
    if (!own) return ctl_fail("out of memory"), 1;
    memcpy(own, argv, (size_t)argc * sizeof(*own));
    if (hide_negatives(argc, own) && (status = parse(argc, own, &ctl, &command)) < 0)
        status = command->run(&ctl);
    for (int i = 0; i < argc; i++) {
        bool same = false;

        /* getopt has changed the order of arguments. */
        for (int j = 0; j < argc; j++) same |= own[i] == argv[j];
        if (!same) free(own[i]);
    }
    free(own);
    return status;
}
