/* fovead's command line. */
#include <getopt.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "numbers.h"
#include "options.h"
#include "print.h"

static const char HELP[] =
    "Usage: fovead --scene FILE [OPTION]...\n"
    "\n"
    "Renders a 360-degree picture of a scene by path tracing, most of it where the eye looks, and streams it "
    "to\n"
    "clients as it sharpens. See it with: foveactl watch, foveactl snapshot FILE.png\n"
    "\n"
    "What is rendered\n"
    "  --scene FILE            glTF, GLB, OBJ, or what else assimp reads\n"
    "  --env FILE              equirectangular environment map: HDR, EXR; PNG and the like are sRGB\n"
    "  --env-turn DEG          turn the environment map to the right; 0\n"
    "  --sun AZ,EL,E,D         a sun: degrees right of -Z, elevation in degrees, irradiance on a surface "
    "that\n"
    "                          faces it, angular diameter in degrees (the real one: 0.53)\n"
    "  --eye X,Y,Z             where the eye is, m; otherwise the file's first camera, else the scene's "
    "middle;\n"
    "                          foveactl move takes it elsewhere\n"
    "  --watch                 read the scene again whenever its file changes, the --env, or a file that the "
    "scene\n"
    "                          names in its folder or the folders in that; if it cannot be read, the picture "
    "stays\n"
    "  --reader-memory MIB     that a program which reads a file for fovead may use, and that Embree may use for "
    "the\n"
    "                          scene's triangles; at least 64; default: 4096, or half of the machine's memory if "
    "that is less\n"
    "  --reader-time S         seconds of processor time for a file, and ten times as many on the clock; 20, "
    "and one more\n"
    "                          for every 2 MiB of the file. A file that takes more, or crashes its reader, "
    "is refused\n"
    "  --size WxH | W          film in pixels; W a multiple of 128, up to 32768, H half of it; 4096x2048\n"
    "  --bounces N             longest path; 0, the default: Russian roulette alone ends a path\n"
    "  --clamp L               clamp light that comes by way of a second surface to this luminance: fewer "
    "bright specks, and\n"
    "                          a darker picture; default: nothing is clamped\n"
    "  --clear-glass           let light straight through thick glass, rough up to 0.25: windows and bulbs "
    "light a room at\n"
    "                          once, without caustics; default: light behind such glass is found by chance\n"
    "  --seed N                of all random numbers; 0\n"
    "  --threads N             that trace paths; one a processor\n"
    "\n"
    "Where the eye looks\n"
    "  --gaze SOURCE           auto: an eye tracker as soon as there is one, until then the recording that "
    "comes\n"
    "                          with fovead; hid or hid:/dev/hidrawN: a HID eye tracker; psvr2: a PlayStation "
    "VR2;\n"
    "                          replay:FILE: a recorded log; synthetic or synthetic:SEED: an observer made "
    "up;\n"
    "                          pointer: whatever clients send (foveactl look)\n"
    "  --list-trackers         what eye trackers are plugged in, what they can do, why one cannot be opened; "
    "then\n"
    "                          fovead ends\n"
    "  --screen W,H,D          of a HID tracker: width and height of its screen and distance of the eyes, m, "
    "if it\n"
    "                          does not say, or says it wrongly; 0.531,0.299,0.65\n"
    "  --calibration FILE      of the PlayStation VR2's user, as the device gave it\n"
    "  --raw-gaze              follow every sample as measured: no filter, no dead zone\n"
    "  --predict               during a saccade, render for where it will land\n"
    "  --record FILE           record the gaze samples, as a log for replay:FILE; nothing but its last "
    "second "
    "can\n"
    "                          be lost. --replace: a file of that name may go\n"
    "  --speed F               pace of a replay: 2 is twice as fast, 0 as fast as it can be read; 1\n"
    "  --loop                  start the recording again at its end\n"
    "  --mode MODE             where samples fall:\n";

static const char HELP_REST[] =
    "  --display-ppd N         pixels per degree of the display: samples are no denser than it can show; "
    "default: as dense as\n"
    "                          the eye can use\n"
    "  --fov X,Y               field of view of vp, degrees; 100,100\n"
    "\n"
    "Who may watch\n"
    "  --listen ADDRESS        unix:PATH or tcp:HOST:PORT; up to 8 times. Default: "
    "$XDG_RUNTIME_DIR/fovead.sock,\n"
    "                          else /tmp/fovead-UID/fovead.sock, both for this user alone. If FOVEAD_TOKEN "
    "is set in "
    "the\n"
    "                          environment, clients on TCP must send the same token; without, addresses that "
    "other\n"
    "                          machines can reach are refused\n"
    "\n"
    "How it ends\n"
    "  --until WHEN            256spp: so many paths a film pixel; 30s: so long a time of rendering; "
    "converged:\n"
    "                          every tile is (needs --mode od); end: the gaze recording has ended. Without "
    "it\n"
    "                          fovead runs until SIGINT, SIGTERM or SIGHUP. A picture that begins anew, for "
    "a\n"
    "                          move or an edit, is counted anew\n"
    "  --save FILE.exr         at the end write colour, sample count and error channels, also when a signal "
    "ends\n"
    "                          fovead; but not if another one comes a second or more after the first\n"
    "  --json                  the summary as one JSON object, alone on stdout; all else goes to stderr\n"
    "  --clock real|virtual    virtual: recorded time passes by 5 ms a batch of 4096 paths, however long "
    "they take,\n"
    "                          so that the same scene, log and seed give the same file byte for byte with "
    "any\n"
    "                          number of threads\n"
    "\n"
    "      --help, --version\n"
    "\n"
    "With --until and without --listen no socket is opened: fovead renders, shows its progress, saves and "
    "ends.\n"
    "Defaults are --gaze auto and --mode fv. With --until and without --gaze there is no gaze and the mode "
    "is od, so\n"
    "that the whole picture gets the same; --until end keeps auto and fv. --clock virtual implies --until "
    "end and\n"
    "opens a socket only with --listen.\n"
    "\n"
    "Example: a picture to keep\n"
    "  fovead --scene hall.gltf --env sky.hdr --until 256spp --save hall.exr\n";

struct parser {
    struct dmn_options *out;
    const char *mode;
    bool has_gaze, has_speed, has_fov, has_screen, has_env_turn, list;
};

static bool refuse(const char *format, ...) __attribute__((format(printf, 1, 2)));

static bool refuse(const char *format, ...)
{
    va_list args;

    fputs("fovead: ", stderr);
    va_start(args, format);
    dmn_vprint(stderr, format, args);
    va_end(args);
    fputs("; see fovead --help\n", stderr);
    return false;
}

static void help(void)
{
    const struct rnd_distribution *d;

    fputs(HELP, stdout);
    for (size_t i = 0; (d = rnd_distribution_at(i)); i++) printf("    %-22s%s\n", d->name, d->summary);
    fputs(HELP_REST, stdout);
}

static bool take_sun(struct parser *p, const char *text)
{
    double n[4];

    if (!dmn_parse_numbers(text, 4, n) || n[1] < -90 || n[1] > 90 || n[2] < 0 || n[3] < 0 || n[3] > 90)
        return refuse("--sun wants AZIMUTH,ELEVATION,IRRADIANCE,DIAMETER, not '%s'", text);
    for (int i = 0; i < 4; i++) p->out->scene.sun[i] = (float)n[i];
    return p->out->scene.has_sun = true;
}

static bool take_eye(struct parser *p, const char *text)
{
    double n[3];
    bool good = dmn_parse_numbers(text, 3, n);

    for (int i = 0; good && i < 3; i++) p->out->scene.eye[i] = n[i];
    if (!good || !dmn_eye_is_somewhere(p->out->scene.eye))
        return refuse("--eye wants X,Y,Z, each %d m at most, not '%s'", DMN_FARTHEST, text);
    return p->out->scene.has_eye = true;
}

static bool take_fov(struct parser *p, const char *text)
{
    double n[2];

    if (!dmn_parse_numbers(text, 2, n) || n[0] <= 0 || n[0] >= 180 || n[1] <= 0 || n[1] >= 180)
        return refuse("--fov wants two angles between 0 and 180 degrees, not '%s'", text);
    for (int i = 0; i < 2; i++) p->out->fov[i] = (float)(n[i] * M_PI / 180);
    return p->has_fov = true;
}

static bool take_screen(struct parser *p, const char *text)
{
    double n[3];
    bool good = dmn_parse_numbers(text, 3, n);

    for (int i = 0; i < 3 && good; i++) good = n[i] >= 0.01 && n[i] <= 20;
    if (!good) return refuse("--screen wants WIDTH,HEIGHT,DISTANCE from 0.01 to 20 m, not '%s'", text);
    p->out->screen = (struct trk_screen){(float)n[0], (float)n[1], (float)n[2]};
    return p->has_screen = true;
}

static bool take_size(struct parser *p, const char *text)
{
    int width, height;

    if (!dmn_parse_size(text, &width, &height) || width % (2 * RND_TILE) || width > RND_MAX_WIDTH ||
        (height && 2 * height != width))
        return refuse(
            "--size wants a width that is a multiple of %d, up to %d, and half of it as height, not '%s'",
            2 * RND_TILE, RND_MAX_WIDTH, text);
    p->out->render.width = width;
    p->out->render.height = width / 2;
    return true;
}

static bool take_listen(struct parser *p, const char *text)
{
    char error[PRO_ERROR_SIZE];

    if (p->out->listens == DMN_MAX_LISTEN) return refuse("--listen: %d addresses at most", DMN_MAX_LISTEN);
    if (!pro_address_parse(text, &p->out->listen[p->out->listens], error))
        return refuse("--listen: %s", error);
    p->out->listens++;
    return true;
}

static bool take_whole(const char *name, const char *text, uint64_t low, uint64_t high, uint64_t *out)
{
    if (dmn_parse_whole(text, low, high, out)) return true;
    return refuse("--%s wants a whole number from %llu to %llu, not '%s'", name, (unsigned long long)low,
                  (unsigned long long)high, text);
}

static const struct option LONG[] = {
    {"scene", required_argument, NULL, 's'},
    {"env", required_argument, NULL, 'e'},
    {"sun", required_argument, NULL, 'u'},
    {"eye", required_argument, NULL, 'y'},
    {"size", required_argument, NULL, 'z'},
    {"bounces", required_argument, NULL, 'b'},
    {"seed", required_argument, NULL, 'd'},
    {"env-turn", required_argument, NULL, 'T'},
    {"clamp", required_argument, NULL, 'K'},
    {"display-ppd", required_argument, NULL, 'D'},
    {"threads", required_argument, NULL, 't'},
    {"clear-glass", no_argument, NULL, 'G'},
    {"gaze", required_argument, NULL, 'g'},
    {"list-trackers", no_argument, NULL, 'L'},
    {"screen", required_argument, NULL, 'S'},
    {"calibration", required_argument, NULL, 'C'},
    {"raw-gaze", no_argument, NULL, 'W'},
    {"predict", no_argument, NULL, 'P'},
    {"record", required_argument, NULL, 'R'},
    {"replace", no_argument, NULL, 'r'},
    {"speed", required_argument, NULL, 'p'},
    {"loop", no_argument, NULL, 'o'},
    {"mode", required_argument, NULL, 'm'},
    {"fov", required_argument, NULL, 'f'},
    {"listen", required_argument, NULL, 'l'},
    {"until", required_argument, NULL, 'n'},
    {"save", required_argument, NULL, 'a'},
    {"json", no_argument, NULL, 'j'},
    {"clock", required_argument, NULL, 'c'},
    {"help", no_argument, NULL, 'h'},
    {"reader-memory", required_argument, NULL, 'M'},
    {"reader-time", required_argument, NULL, 'E'},
    {"version", no_argument, NULL, 'v'},
    {"watch", no_argument, NULL, 'w'},
    {0},
};

static bool take(struct parser *p, int option, const char *text)
{
    struct dmn_options *out = p->out;
    uint64_t whole = 0;
    double number;
    bool good = true;

    switch (option) {
    case 's':
        out->scene.path = text;
        break;
    case 'e':
        out->scene.env_path = text;
        break;
    case 'u':
        return take_sun(p, text);
    case 'y':
        return take_eye(p, text);
    case 'w':
        return out->watch = true;
    case 'z':
        return take_size(p, text);
    case 'T':
        if (!dmn_parse_numbers(text, 1, &number) || fabs(number) > 360)
            return refuse("--env-turn wants degrees from -360 to 360, not '%s'", text);
        out->scene.env_azimuth = (float)number, p->has_env_turn = true;
        break;
    case 'K':
        if (!dmn_parse_numbers(text, 1, &number) || number <= 0)
            return refuse("--clamp wants a luminance above 0, not '%s'", text);
        out->render.firefly = (float)number;
        break;
    case 'G':
        return out->scene.clear_glass = true;
    case 'D':
        if (!dmn_parse_numbers(text, 1, &number) || number < 1 || number > 1000)
            return refuse("--display-ppd wants pixels per degree, 1 to 1000, not '%s'", text);
        out->display_ppd = (float)number;
        break;
    case 'b':
        good = take_whole("bounces", text, 0, 1024, &whole), out->render.max_bounces = (int)whole;
        break;
    case 'M':
        good = take_whole("reader-memory", text, 64, 1 << 24, &whole),
        out->scene.reader_mib = (uint32_t)whole;
        break;
    case 'E':
        good = take_whole("reader-time", text, 1, 1 << 20, &whole),
        out->scene.reader_seconds = (uint32_t)whole;
        break;
    case 'd':
        return take_whole("seed", text, 0, UINT64_MAX, &out->render.seed);
    case 't':
        good = take_whole("threads", text, 1, 256, &whole), out->render.threads = (int)whole;
        break;
    case 'g':
        out->gaze = text, p->has_gaze = true;
        break;
    case 'L':
        return p->list = true;
    case 'S':
        return take_screen(p, text);
    case 'C':
        out->calibration = text;
        break;
    case 'W':
        return out->raw_gaze = true;
    case 'P':
        return out->predict = true;
    case 'R':
        out->record = text;
        break;
    case 'r':
        return out->replace = true;
    case 'p':
        if (!dmn_parse_numbers(text, 1, &number) || number < 0)
            return refuse("--speed wants a number of 0 or more, not '%s'", text);
        out->speed = number, p->has_speed = true;
        break;
    case 'o':
        out->loop = true;
        break;
    case 'm':
        p->mode = text;
        break;
    case 'f':
        return take_fov(p, text);
    case 'l':
        return take_listen(p, text);
    case 'n':
        if (!dmn_until_parse(text, &out->until))
            return refuse("--until wants a number with spp or s, converged, or end, not '%s'", text);
        break;
    case 'a':
        if (strlen(text) < 4 || strcasecmp(text + strlen(text) - 4, ".exr"))
            return refuse("--save wants a name that ends in .exr, not '%s'", text);
        out->save = text;
        break;
    case 'j':
        out->json = true;
        break;
    case 'c':
        out->virtual_clock = !strcmp(text, "virtual");
        if (!out->virtual_clock && strcmp(text, "real"))
            return refuse("--clock wants real or virtual, not '%s'", text);
        break;
    }
    return good;
}

/* Options of gaze that go with some sources alone. */
static bool settle_gaze(const struct parser *p)
{
    const struct dmn_options *out = p->out;
    const char *gaze = out->gaze ? out->gaze : "";
    const bool automatic = !strcmp(gaze, "auto"), pointer = !strcmp(gaze, "pointer");

    if (out->virtual_clock && pointer) return refuse("--gaze pointer needs the real clock");
    if ((p->has_speed || out->loop) && !out->gaze) return refuse("--speed and --loop need --gaze");
    if (p->has_speed && out->virtual_clock) return refuse("--speed needs the real clock");
    if (p->has_screen && !automatic && strcmp(gaze, "hid") && strncmp(gaze, "hid:", 4))
        return refuse("--screen needs --gaze hid or auto");
    if (out->calibration && !automatic && strcmp(gaze, "psvr2"))
        return refuse("--calibration needs --gaze psvr2 or auto");
    if ((out->raw_gaze || out->predict) && (!out->gaze || pointer))
        return refuse("%s needs a --gaze that comes from an eye", out->raw_gaze ? "--raw-gaze" : "--predict");
    if (out->record && !out->gaze) return refuse("--record needs --gaze");
    if (out->replace && !out->record) return refuse("--replace needs --record");
    return true;
}

/* What was not said, and what does not go together. */
static bool settle(struct parser *p)
{
    struct dmn_options *out = p->out;
    bool endless =
        out->loop || (p->has_gaze && (!strcmp(out->gaze, "pointer") || !strncmp(out->gaze, "synth", 5)));

    if (!out->scene.path) return refuse("--scene FILE is missing");
    if (out->virtual_clock && out->until.kind == DMN_UNTIL_STOPPED) out->until.kind = DMN_UNTIL_END;
    if (!p->has_gaze && (out->until.kind == DMN_UNTIL_STOPPED || out->until.kind == DMN_UNTIL_END))
        out->gaze = "auto";
    if (!p->mode) p->mode = out->gaze ? "fv" : "od";
    out->render.distribution = rnd_distribution_find(p->mode);
    if (!out->render.distribution) return refuse("--mode: there is no '%s'", p->mode);
    if (out->until.kind == DMN_UNTIL_CONVERGED && strcmp(p->mode, "od"))
        return refuse("--until converged needs --mode od: %s leaves parts of the sphere aside", p->mode);
    if (out->until.kind == DMN_UNTIL_END && endless)
        return refuse("%s has no end to wait for: use another --until", out->loop ? "--loop" : out->gaze);
    if (!settle_gaze(p)) return false;
    if (out->watch && out->virtual_clock) return refuse("--watch needs the real clock");
    if (p->has_env_turn && !out->scene.env_path) return refuse("--env-turn needs --env");
    if (out->display_ppd > 0 && strncmp(p->mode, "fv", 2))
        return refuse("--display-ppd needs --mode fv or fv-exact");
    if (p->has_fov && strcmp(p->mode, "vp")) return refuse("--fov needs --mode vp");
    if (!out->listens && out->until.kind == DMN_UNTIL_STOPPED) return take_listen(p, NULL);
    return true;
}

enum dmn_parsed dmn_options_parse(int argc, char **argv, struct dmn_options *out_options)
{
    struct parser parser = {.out = out_options};
    int option;

    *out_options = (struct dmn_options){.speed = 1, .fov = {(float)(M_PI / 1.8), (float)(M_PI / 1.8)}};
    out_options->render.width = 4096;
    out_options->render.height = 2048;
    opterr = 0;
    optind = 0;
    while ((option = getopt_long(argc, argv, ":", LONG, NULL)) != -1) {
        if (option == 'h') return help(), DMN_ANSWERED;
        if (option == 'v') return puts("fovead " FOVEAD_VERSION), DMN_ANSWERED;
        if (option == ':') return refuse("%s needs a value", argv[optind - 1]), DMN_REFUSED;
        if (option == '?') return refuse("unknown option %s", argv[optind - 1]), DMN_REFUSED;
        if (!take(&parser, option, optarg)) return DMN_REFUSED;
    }
    if (optind < argc) return refuse("'%s' belongs to no option", argv[optind]), DMN_REFUSED;
    if (parser.list) return DMN_LIST;
    return settle(&parser) ? DMN_RUN : DMN_REFUSED;
}
