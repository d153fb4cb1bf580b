/* foveactl: the command line, and what commands share. */
#include <ctype.h>
#include <getopt.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ctl.h"
#include "streams.h"

static const struct ctl_command COMMANDS[] = {
    {"watch", "", "show how the picture grows, where the eye looks and how long things take", 0,
     CTL_DAEMON | CTL_JSON | CTL_FOR | CTL_UNTIL_FINISHED, ctl_watch},
    {"snapshot", "FILE", "save the picture as received: .exr, .png or .jpg; panorama or --view", 1,
     CTL_DAEMON | CTL_JSON | CTL_VIEW | CTL_SIZE | CTL_EXPOSURE | CTL_SETTLE | CTL_WITHIN, ctl_snapshot},
    {"stats", "", "print the daemon's figures once", 0, CTL_DAEMON | CTL_JSON, ctl_stats},
    {"freeze", "", "keep sampling where the gaze is now", 0, CTL_DAEMON, ctl_freeze},
    {"unfreeze", "", "follow the gaze again", 0, CTL_DAEMON, ctl_unfreeze},
    {"look", "YAW,PITCH", "move the gaze there, degrees (for fovead --gaze pointer)", 1, CTL_DAEMON,
     ctl_look},
    {"move", "X,Y,Z", "move the eye there, metres, or with --by so far; the picture begins anew", 1,
     CTL_DAEMON | CTL_JSON | CTL_BY, ctl_move},
    {"save", "FILE.exr", "have the daemon write colour, sample counts and errors", 1, CTL_DAEMON, ctl_save},
    {"record", "[FILE]", "have the daemon record gaze samples, as a log; until record --stop", 1,
     CTL_DAEMON | CTL_FOR | CTL_STOP | CTL_REPLACE, ctl_record},
    {"recentre", "[YAW,PITCH]", "the eye looks there now, or at the view's centre: turn all gaze so", 1,
     CTL_DAEMON, ctl_recentre},
    {"samples", "FILE.exr OUT.png", "draw where samples went, from a file that was saved", 2, CTL_GAZE,
     ctl_samples},
    {"compare", "REFERENCE TEST", "how different two pictures are to an eye: FLIP, relative errors, PSNR", 2,
     CTL_JSON | CTL_PPD | CTL_LDR | CTL_MAP, ctl_compare},
    {"gaze info", "LOG", "what a gaze log holds, and what was assumed of it", 1, CTL_JSON | CTL_LOG,
     ctl_gaze_info},
    {"gaze convert", "LOG OUT", "write it as OUT: .gaze (fovead's own) or _physio.tsv.gz (BIDS)", 2,
     CTL_LOG | CTL_REPLACE, ctl_gaze_convert},
    {"gaze plot", "LOG OUT", "chart it as OUT, .svg or .png: yaw and pitch over time, path of gaze", 2,
     CTL_LOG, ctl_gaze_plot},
    {0},
};

static const char HELP[] =
    "\n"
    "Options\n"
    "  --connect ADDRESS       unix:PATH or tcp:HOST:PORT; default: $XDG_RUNTIME_DIR/fovead.sock, else\n"
    "                          /tmp/fovead-UID/fovead.sock; only of this user or root. FOVEAD_TOKEN in the\n"
    "                          environment is sent along\n"
    "  --wait                  wait for the daemon to come up, ten minutes at most\n"
    "  --json                  watch, stats, snapshot, move, compare, gaze info: one JSON object\n"
    "  --for SECONDS           watch: so long; otherwise until the daemon ends or Ctrl-C. record: so long, "
    "and "
    "stop\n"
    "  --stop                  record: end the recording\n"
    "  --replace               record, gaze convert: a file of that name may go\n"
    "  --until-finished        watch: until the gaze recording has ended\n"
    "  --view YAW,PITCH,FOV    snapshot: what lies in that direction, in degrees right and up of forward, "
    "with that\n"
    "  --view gaze,FOV         horizontal field of view; or where the gaze is\n"
    "  --size WxH              snapshot: of the view; 1280x1280\n"
    "  --exposure STOPS        snapshot: brighter by so many doublings, or auto: half of the sphere above, "
    "half below\n"
    "                          middle grey; 0. An .exr keeps the radiance as it is\n"
    "  --settle SECONDS        snapshot: wait for finer tiles once all is there; 1.5\n"
    "  --within SECONDS        snapshot: give up if not all of the picture is there by then; 120\n"
    "  --by                    move: so far to the right, up and backward (the axes of the scene) from where "
    "the\n"
    "                          eye is\n"
    "  --gaze LOG              samples: draw the path of this recorded gaze\n"
    "  --ppd N                 compare: pixels per degree where the pictures are seen, 1 to 300; 67.02, a "
    "screen at\n"
    "                          arm's length. Headsets have 12 to 25\n"
    "  --ldr                   compare: what a display shows (LDR-FLIP), although both files hold light "
    "(HDR-FLIP)\n"
    "  --map FILE.png          compare: draw where they differ: from black, no difference, to white\n"
    "  --format NAME           gaze ...: the log's format, where its content does not tell it\n"
    "  --time-unit UNIT        gaze ...: of its times: s, ms, us or ns\n"
    "  --frame XYZ             gaze ...: where its +X, +Y and +Z point: L or R, U or D, F or B\n"
    "  --screen WIDTH,DISTANCE gaze ...: of a log in screen coordinates, metres; or one number, degrees "
    "across\n"
    "  --recording NAME        gaze ...: which one, where a file holds several: its name, its participant's, "
    "or\n"
    "                          PARTICIPANT/NAME\n"
    "      --help, --version\n";

static const struct option LONG[] = {
    {"connect", required_argument, NULL, 'c'},
    {"wait", no_argument, NULL, 'w'},
    {"json", no_argument, NULL, 'j'},
    {"for", required_argument, NULL, 'f'},
    {"until-finished", no_argument, NULL, 'u'},
    {"view", required_argument, NULL, 'v'},
    {"size", required_argument, NULL, 'z'},
    {"settle", required_argument, NULL, 's'},
    {"within", required_argument, NULL, 'W'},
    {"exposure", required_argument, NULL, 'x'},
    {"gaze", required_argument, NULL, 'g'},
    {"ppd", required_argument, NULL, 'P'},
    {"ldr", no_argument, NULL, 'L'},
    {"map", required_argument, NULL, 'M'},
    {"stop", no_argument, NULL, 'p'},
    {"replace", no_argument, NULL, 'r'},
    {"by", no_argument, NULL, 'b'},
    {"format", required_argument, NULL, 'F'},
    {"time-unit", required_argument, NULL, 'T'},
    {"frame", required_argument, NULL, 'R'},
    {"screen", required_argument, NULL, 'S'},
    {"recording", required_argument, NULL, 'N'},
    {"help", no_argument, NULL, 'h'},
    {"version", no_argument, NULL, 'V'},
    {0},
};

/* What an option is called in ctl_command.options. */
static unsigned bit_of(int option)
{
    switch (option) {
    case 'c':
    case 'w':
        return CTL_DAEMON;
    case 'j':
        return CTL_JSON;
    case 'f':
        return CTL_FOR;
    case 'u':
        return CTL_UNTIL_FINISHED;
    case 'v':
        return CTL_VIEW;
    case 'z':
        return CTL_SIZE;
    case 's':
        return CTL_SETTLE;
    case 'W':
        return CTL_WITHIN;
    case 'g':
        return CTL_GAZE;
    case 'x':
        return CTL_EXPOSURE;
    case 'p':
        return CTL_STOP;
    case 'r':
        return CTL_REPLACE;
    case 'P':
        return CTL_PPD;
    case 'L':
        return CTL_LDR;
    case 'M':
        return CTL_MAP;
    case 'b':
        return CTL_BY;
    case 'F':
        return CTL_LOG_FORMAT;
    case 'T':
        return CTL_LOG_TIME_UNIT;
    case 'R':
        return CTL_LOG_FRAME;
    case 'S':
        return CTL_LOG_SCREEN;
    case 'N':
        return CTL_LOG_RECORDING;
    default:
        return 0;
    }
}

static const char *name_of(unsigned bits)
{
    for (const struct option *o = LONG; o->name; o++)
        if (bit_of(o->val) & bits) return o->name;
    return "";
}

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

static void help(void)
{
    puts(
        "Usage: foveactl [OPTION]... COMMAND\n\nShows and steers what a running fovead renders.\n\nCommands");
    for (const struct ctl_command *c = COMMANDS; c->name; c++) {
        char usage[64];

        snprintf(usage, sizeof(usage), "%s %s", c->name, c->operands);
        printf("  %-27s%s\n", usage, c->summary);
    }
    fputs(HELP, stdout);
}

static bool take_seconds(const char *name, const char *text, double *out)
{
    if (dmn_parse_numbers(text, 1, out) && *out >= 0 && *out < 1e7) return true;
    return ctl_fail("--%s wants seconds, not '%s'", name, text);
}

static bool take_view(struct ctl *ctl, const char *text)
{
    ctl->view_gaze = !strncmp(text, "gaze,", 5);
    if (ctl->view_gaze ? dmn_parse_numbers(text + 5, 1, &ctl->view[2])
                       : dmn_parse_numbers(text, 3, ctl->view))
        if (ctl->view[2] > 0 && ctl->view[2] < 180 && ctl->view[1] >= -90 && ctl->view[1] <= 90) return true;
    return ctl_fail("--view wants YAW,PITCH,FOV or gaze,FOV in degrees, not '%s'", text);
}

static bool take_screen(struct ctl *ctl, const char *text)
{
    double numbers[2];

    if (dmn_parse_numbers(text, 1, &ctl->log.screen_fov_deg) && ctl->log.screen_fov_deg > 0) return true;
    if (!dmn_parse_numbers(text, 2, numbers) || numbers[0] <= 0 || numbers[1] <= 0)
        return ctl_fail("--screen wants WIDTH,DISTANCE in metres, or degrees across, not '%s'", text);
    ctl->log.screen_fov_deg = 0;
    ctl->log.screen_width_m = numbers[0];
    ctl->log.screen_distance_m = numbers[1];
    return true;
}

static bool take(struct ctl *ctl, int option, const char *text)
{
    char error[PRO_ERROR_SIZE];

    ctl->given |= bit_of(option);
    switch (option) {
    case 'c':
        ctl->has_address = true;
        return pro_address_parse(text, &ctl->address, error) || ctl_fail("--connect: %s", error);
    case 'w':
        return ctl->wait = true;
    case 'j':
        return ctl->json = true;
    case 'f':
        return take_seconds("for", text, &ctl->seconds);
    case 'u':
        return ctl->until_finished = true;
    case 'v':
        return take_view(ctl, text);
    case 'z':
        if (dmn_parse_size(text, &ctl->width, &ctl->height) && ctl->height && ctl->width <= 16384 &&
            ctl->height <= 16384)
            return true;
        return ctl_fail("--size wants WxH, up to 16384x16384, not '%s'", text);
    case 'x':
        ctl->exposure_auto = !strcmp(text, "auto");
        if (ctl->exposure_auto || (dmn_parse_numbers(text, 1, &ctl->exposure) && fabs(ctl->exposure) <= 64))
            return true;
        return ctl_fail("--exposure wants stops or auto, not '%s'", text);
    case 's':
        return take_seconds("settle", text, &ctl->settle);
    case 'W':
        return take_seconds("within", text, &ctl->within);
    case 'p':
        return ctl->stop = true;
    case 'r':
    case 'b':
        return true;
    case 'P':
        if (dmn_parse_numbers(text, 1, &ctl->ppd) && ctl->ppd >= 1 && ctl->ppd <= RND_FLIP_MAX_PPD)
            return true;
        return ctl_fail("--ppd wants pixels per degree, 1 to %d, not '%s'", RND_FLIP_MAX_PPD, text);
    case 'L':
        return ctl->ldr = true;
    case 'M':
        ctl->map = text;
        return true;
    case 'F':
        ctl->log.format = text;
        return true;
    case 'T':
        ctl->log.time_unit = text;
        return true;
    case 'R':
        ctl->log.frame = text;
        return true;
    case 'S':
        return take_screen(ctl, text);
    case 'N':
        ctl->log.recording = text;
        return true;
    default:
        ctl->gaze = text;
        return true;
    }
}

/* How many words of a command line, which ends with NULL, are this command's name; 0 if it is not that. */
static int words_of(const char *name, char *const *words)
{
    size_t length = strlen(words[0]);

    if (strcmp(name, words[0]) == 0) return 1;
    if (strncmp(name, words[0], length) != 0 || name[length] != ' ' || !words[1]) return 0;
    return strcmp(name + length + 1, words[1]) == 0 ? 2 : 0;
}

/* -1: run it; else the exit status. */
static int parse(int argc, char **argv, struct ctl *ctl, const struct ctl_command **out_command)
{
    const struct ctl_command *command = COMMANDS;
    int option, words = 0;

    opterr = 0;
    while ((option = getopt_long(argc, argv, ":", LONG, NULL)) != -1) {
        if (option == 'h') return help(), 0;
        if (option == 'V') return puts("foveactl " FOVEAD_VERSION), 0;
        if (option == ':') return ctl_fail("%s needs a value; see foveactl --help", argv[optind - 1]), 2;
        if (option == '?') return ctl_fail("unknown option %s; see foveactl --help", argv[optind - 1]), 2;
        if (!take(ctl, option, optarg)) return 2;
    }
    if (optind == argc) return ctl_fail("which command? see foveactl --help"), 2;
    ctl->command = argv[optind];
    while (command->name && (words = words_of(command->name, argv + optind)) == 0) command++;
    optind += words;
    if (!command->name) return ctl_fail("there is no command '%s'; see foveactl --help", ctl->command), 2;
    if (argc - optind > command->count || argc - optind < command->count - (*command->operands == '['))
        return ctl_fail("usage: foveactl %s %s", command->name, command->operands), 2;
    if (ctl->given & ~command->options)
        return ctl_fail("--%s does not go with %s", name_of(ctl->given & ~command->options), command->name),
               2;
    if (ctl->given & CTL_SIZE && !(ctl->given & CTL_VIEW)) return ctl_fail("--size needs --view"), 2;
    ctl->operand = argv + optind;
    *out_command = command;
    return -1;
}

/* getopt takes "-30,10" for an option; a space before it makes it an operand, and numbers are read past
 * spaces. */
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
    struct ctl ctl = {
        .settle = 1.5, .within = 120, .width = 1280, .height = 1280, .ppd = RND_FLIP_PPD, .arguments = argv};
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

        /* getopt has changed their order. */
        for (int j = 0; j < argc; j++) same |= own[i] == argv[j];
        if (!same) free(own[i]);
    }
    free(own);
    return status;
}

/* --- for the commands
 * ---------------------------------------------------------------------------------------- */

struct pro_client *ctl_connect(const struct ctl *ctl, Fovea__Encoding tiles, bool gaze, bool stats)
{
    Fovea__Hello hello = FOVEA__HELLO__INIT;
    char name[64], error[PRO_ERROR_SIZE];
    const char *token = getenv("FOVEAD_TOKEN");
    struct pro_address address = ctl->address;
    struct pro_client *client;
    double patience_s = ctl->wait ? CTL_START_S : fmin(CTL_PATIENCE_S, ctl->within);

    if (!ctl->has_address && !pro_address_parse(NULL, &address, error)) return ctl_fail("%s", error), NULL;
    snprintf(name, sizeof(name), "foveactl %s " FOVEAD_VERSION, ctl->command);
    hello.client = name;
    hello.tiles = tiles;
    hello.gaze = gaze;
    hello.stats = stats;
    if (token) hello.token = (char *)token;
    client = pro_connect(&address, &hello, (int)(patience_s * 1000), ctl->wait, error);
    if (!client) ctl_fail("%s", error);
    return client;
}

Fovea__Message *ctl_await(struct pro_client *client, Fovea__Message__BodyCase body, uint64_t from_ns,
                          double seconds)
{
    uint64_t end_ns = from_ns + (uint64_t)(seconds * 1e9), now_ns;
    char error[PRO_ERROR_SIZE];

    while ((now_ns = dmn_now_ns()) < end_ns) {
        Fovea__Message *message;
        enum pro_result result = pro_receive(client, (int)((end_ns - now_ns) / 1000000 + 1), &message, error);

        if (result == PRO_BROKEN) {
            ctl_fail("%s", error);
            return NULL;
        }
        if (result != PRO_MESSAGE) continue;
        if (message->body_case == body) return message;
        fovea__message__free_unpacked(message, NULL);
    }
    ctl_fail("no answer within %g s", seconds);
    return NULL;
}

bool ctl_request(struct pro_client *client, const Fovea__Message *message, double seconds)
{
    char error[PRO_ERROR_SIZE];
    Fovea__Message *answer;
    bool good;

    if (!pro_send(client, message, error)) return ctl_fail("%s", error);
    if (!(answer = ctl_await(client, FOVEA__MESSAGE__BODY_DONE, dmn_now_ns(), seconds))) return false;
    good = answer->done->ok;
    if (good)
        dmn_print(stdout, "%s\n", answer->done->text);
    else
        ctl_fail("%s", answer->done->text);
    fflush(stdout);
    fovea__message__free_unpacked(answer, NULL);
    return good;
}

/* Messages are taken in order, so a Pong says that what went before it is done. */
bool ctl_tell(struct pro_client *client, const Fovea__Message *message)
{
    Fovea__Message message_ping = FOVEA__MESSAGE__INIT;
    Fovea__Ping ping = FOVEA__PING__INIT;
    char error[PRO_ERROR_SIZE];
    uint64_t client_ns, sent_ns = dmn_now_ns();

    /* The client library asks the time as well: its own questions never carry this. */
    ping.client_ns = UINT64_MAX;
    message_ping.body_case = FOVEA__MESSAGE__BODY_PING;
    message_ping.ping = &ping;
    if (!pro_send(client, message, error) || !pro_send(client, &message_ping, error))
        return ctl_fail("%s", error);
    do {
        Fovea__Message *pong = ctl_await(client, FOVEA__MESSAGE__BODY_PONG, sent_ns, CTL_PATIENCE_S);

        if (!pong) return false;
        client_ns = pong->pong->client_ns;
        fovea__message__free_unpacked(pong, NULL);
    } while (client_ns != UINT64_MAX);
    return true;
}
