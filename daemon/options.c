/* fovead's command line: one row per option, and the defaults that depend on other options. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "arguments.h"
#include "image_options.h"
#include "numbers.h"
#include "option.h"
#include "options.h"

#define INTO(field) DMN_INTO(struct dmn_options, field)

/* --- what options need --- */

/* The kind of the source; NULL: there is no gaze, or no such source, which trk_open() refuses. */
static const struct trk_source_kind *kind_of(const struct dmn_options *options)
{
    return options->gaze ? trk_source_kind_find(options->gaze) : NULL;
}

static bool gaze_takes_screen(const void *values)
{
    const struct trk_source_kind *kind = kind_of(values);

    return kind && kind->takes_screen;
}

static bool gaze_takes_calibration(const void *values)
{
    const struct trk_source_kind *kind = kind_of(values);

    return kind && kind->takes_calibration;
}

static bool gaze_follows_eye(const void *values)
{
    const struct trk_source_kind *kind = kind_of(values);

    return kind && kind->follows_eye;
}

static bool listens_for_browsers(const void *values)
{
    const struct dmn_options *options = values;

    for (int i = 0; i < options->listens; i++)
        if (options->listen[i].is_http) return true;
    return false;
}

static bool clock_is_real(const void *values)
{
    return !((const struct dmn_options *)values)->virtual_clock;
}

static bool save_is_for_displays(const void *values)
{
    return !dmn_image_is_exr(((const struct dmn_options *)values)->save);
}

static bool mode_is_foveated(const void *values)
{
    return ((const struct dmn_options *)values)->render.distribution->is_foveated;
}

static bool mode_has_viewport(const void *values)
{
    return ((const struct dmn_options *)values)->render.distribution->has_viewport;
}

/* --- the rows --- */

static const struct dmn_option ROWS[] = {
    {.help = "What is rendered"},
    {.name = "scene",
     .argument = "FILE",
     .help = "glTF, GLB, OBJ, or what else assimp reads",
     INTO(scene.path),
     .required = true},
    {.name = "env",
     .argument = "FILE",
     .help = "equirectangular environment map: HDR, EXR; PNG and the like are sRGB",
     INTO(scene.env_path)},
    {.name = "env-turn",
     .argument = "DEG",
     .help = "turn the environment map to the right; default: 0",
     INTO(scene.env_azimuth),
     .number = {.low = -360, .high = 360, .unit = "degrees"},
     .need = {{"--env"}}},
    {.name = "sun",
     .argument = "AZ,EL,E,D",
     .help =
         "a sun: degrees right of -Z, elevation in degrees, irradiance on a surface that faces it, angular "
         "diameter in degrees (the real one: 0.53)",
     .take = dmn_take_sun,
     .number = {.count = 4, .low = -FLT_MAX, .high = FLT_MAX},
     .wants =
         "AZIMUTH,ELEVATION,IRRADIANCE,DIAMETER, elevation from -90 to 90 and diameter from 0 to 90 degrees"},
    {.name = "camera",
     .former = "eye",
     .argument = "X,Y,Z",
     .help = "position of the camera, m; default: that of the first camera in the file, else the middle of "
             "the scene. foveactl move changes it",
     .take = dmn_take_camera,
     .number = {.count = 3, .low = -DMN_FARTHEST, .high = DMN_FARTHEST, .unit = "m"}},
    {.name = "watch",
     .help = "read the scene again when its file changes, or the --env, or a file that the scene names in "
             "its own folder or a folder inside that; if the scene cannot be read, the picture stays",
     INTO(watch),
     .need = {{"the real clock", clock_is_real}}},
    {.name = "reader-memory",
     .argument = "MIB",
     .help = "most memory of each program that reads files for fovead, and of Embree's trees of the scene; "
             "at least 64; default: 4096, or half of the machine's memory if that is less",
     INTO(scene.reader_mib),
     .whole = {64, 1 << 24}},
    {.name = "reader-time",
     .argument = "S",
     .help = "most processor time for reading a file, seconds; ten times as many may pass on the clock; "
             "default: 20, and one more for every 2 MiB of the file. A file that takes longer, or crashes "
             "its reader, is refused",
     INTO(scene.reader_seconds),
     .whole = {1, 1 << 20}},
    {.name = "size",
     .argument = "WxH | W",
     .help = "size of the film in pixels: W is a multiple of 128, up to 32768, and H is half of W; default: "
             "4096x2048",
     .take = dmn_take_size,
     .wants = "a width that is a multiple of 128, up to 32768, and half of it as height"},
    {.name = "bounces",
     .argument = "N",
     .help = "most bounces of a path; default: 0, which leaves it to Russian roulette to end paths",
     INTO(render.max_bounces),
     .whole = {0, 1024}},
    {.name = "clamp",
     .argument = "L",
     .help = "clamp indirect light to this luminance: fewer bright specks, but a darker picture; default: "
             "nothing is clamped",
     INTO(render.firefly),
     .number = {.low = 0, .high = FLT_MAX, .open = true, .unit = "a luminance"}},
    {.name = "clear-glass",
     .help =
         "let light pass straight through thick glass of roughness up to 0.25: windows and bulbs light a "
         "room with little noise, but without caustics; default: light behind such glass is found by chance",
     INTO(scene.clear_glass)},
    {.name = "seed",
     .argument = "N",
     .help = "seed of all random numbers; default: 0",
     INTO(render.seed),
     .whole = {0, UINT64_MAX}},
    {.name = "threads",
     .argument = "N",
     .help = "threads that trace paths; default: one per processor",
     INTO(render.threads),
     .whole = {1, 256}},

    {.help = "Where the eye looks"},
    {.name = "gaze",
     .argument = "SOURCE",
     .help = "where the gaze comes from:",
     INTO(gaze),
     .value_at = dmn_gaze_usage_at},
    {.name = "list-trackers",
     .help = "list the eye trackers that are plugged in, what they can do, and why one cannot be opened; "
             "then exit",
     INTO(list_trackers)},
    {.name = "screen",
     .argument = "W,H,D",
     .help = "width and height of a HID tracker's screen and its distance from the eyes, m, if the tracker "
             "does not say, or is wrong; default: 0.531,0.299,0.65",
     INTO(screen.width_m),
     .number = {.count = 3, .low = 0.01, .high = 20, .unit = "m"},
     .need = {{"a --gaze that takes a screen", gaze_takes_screen}}},
    {.name = "calibration",
     .argument = "FILE",
     .help = "the user's calibration of a PlayStation VR2, as the device gave it",
     INTO(calibration),
     .need = {{"a --gaze that takes a calibration", gaze_takes_calibration}}},
    {.name = "raw-gaze",
     .help = "follow every sample as measured: no filter, no dead zone",
     INTO(raw_gaze),
     .need = {{"a --gaze that comes from an eye", gaze_follows_eye}}},
    {.name = "predict",
     .help = "during a saccade, render for where it will land",
     INTO(predict),
     .need = {{"a --gaze that comes from an eye", gaze_follows_eye}}},
    {.name = "record",
     .argument = "FILE",
     .help = "record the gaze samples as a log for replay:FILE; a crash loses its last second at most",
     INTO(record),
     .need = {{"--gaze"}}},
    {.name = "replace", .help = "let --record replace a file", INTO(replace), .need = {{"--record"}}},
    {.name = "speed",
     .argument = "F",
     .help = "pace of a replay: 2 is twice as fast, 0 as fast as the log can be read; default: 1",
     INTO(speed),
     .number = {.low = 0, .high = INFINITY},
     .need = {{"--gaze"}, {"the real clock", clock_is_real}}},
    {.name = "loop", .help = "start the recording again at its end", INTO(loop), .need = {{"--gaze"}}},
    {.name = "mode",
     .argument = "MODE",
     .help = "where samples fall:",
     .take = dmn_take_mode,
     .value_at = dmn_mode_at},
    {.name = "display-ppd",
     .argument = "N",
     .help = "pixels per degree of the display: samples are no denser than the display can show; default: as "
             "dense as the eye can use",
     INTO(display_ppd),
     .number = {.low = 1, .high = 1000, .unit = "pixels per degree"},
     .need = {{"--mode fv or fv-exact", mode_is_foveated}}},
    {.name = "fov",
     .argument = "X,Y",
     .help = "field of view of --mode vp, degrees; default: 100,100",
     .take = dmn_take_fov,
     .number = {.count = 2, .low = 0, .high = 180, .open = true, .unit = "degrees"},
     .need = {{"--mode vp", mode_has_viewport}}},

    {.help = "Who may watch"},
    {.name = "listen",
     .argument = "ADDRESS",
     .help =
         "unix:PATH, tcp:HOST:PORT, or http:HOST:PORT for browsers; up to 8 times. Default: "
         "$XDG_RUNTIME_DIR/fovead.sock, else "
         "/tmp/fovead-UID/fovead.sock, both for this user alone. If FOVEAD_TOKEN is set in the environment, "
         "clients on TCP must send the same token; without, addresses that other machines can reach are "
         "refused",
     .take = dmn_take_listen},
    {.name = "tls",
     .argument = "CERT,KEY",
     .help =
         "speak TLS on http: listeners, which are then opened as https:, and need this for WebXR in a "
         "headset on the network; PEM files of a certificate and its key. tcp: listeners stay without TLS",
     .take = dmn_take_tls,
     .wants = "two PEM files, CERT,KEY, with one comma",
     .need = {{"--listen http:HOST:PORT", listens_for_browsers}}},
    {.name = "tev",
     .argument = "HOST[:PORT]",
     .help = "show the picture in tev or HDRView, which listen at 127.0.0.1, port 14158: with channels as "
             "--save has "
             "them, and where the eye looks. fovead connects whenever a viewer is there",
     .take = dmn_take_tev,
     .wants = "HOST or HOST:PORT, with a port from 1 to 65535 and an IPv6 address in brackets"},

    {.help = "How it ends"},
    {.name = "until",
     .argument = "WHEN",
     .help = "256spp: after so many paths per film pixel; 30s: after so many seconds of rendering; "
             "converged: when every tile has converged (needs --mode od); end: when the gaze recording has "
             "ended; default: at SIGINT, SIGTERM or SIGHUP. When a move or an edit begins the picture anew, "
             "the count begins anew too",
     .take = dmn_take_until,
     .wants = "a number with spp or s, converged, or end"},
    {.name = "save",
     .argument = "FILE",
     .help = "at the end write the picture, also when a signal ends fovead, unless another signal comes a "
             "second or more after the first. An .exr has colour, sample counts, errors and --planes as "
             "channels; a .png or .jpg is as displays show it. All are marked as 360-degree panoramas",
     .take = dmn_take_save,
     .target = offsetof(struct dmn_options, save),
     .wants = "a name that ends in " DMN_IMAGE_ENDS},
    {.name = "save-every",
     .argument = "SECONDS",
     .help = "write --save also every so many seconds, while fovead goes on; if a save takes longer than "
             "that, intervals are left out",
     INTO(save_every),
     .number = {.low = 1, .high = 1e7, .unit = "seconds"},
     .need = {{"--save"}, {"the real clock", clock_is_real}}},
    {.name = "exposure",
     .argument = "STOPS",
     .help = "brighten the .png or .jpg of --save by so many stops, or auto: half of the sphere above "
             "middle grey, half below; default: 0",
     .take = dmn_take_exposure,
     .target = offsetof(struct dmn_options, exposure),
     .number = {.low = -64, .high = 64},
     .wants = "stops from -64 to 64, or auto",
     .need = {{"--save"}, {"a --save to .png or .jpg", save_is_for_displays}}},
    {.name = "planes",
     .argument = "NAMES",
     .help = "keep what paths hit first, for the channels of every saved .exr; this takes memory. all, or "
             "some of these with commas between them:",
     .take = dmn_take_planes,
     .value_at = rnd_plane_at},
    {.name = "json",
     .help = "print the summary as one JSON object on stdout, and everything else on stderr",
     INTO(json)},
    {.name = "clock",
     .argument = "real|virtual",
     .help = "virtual: every batch of 4096 paths counts as 5 ms, however long it takes, so that the same "
             "scene, log and seed give the same file byte for byte with any number of threads",
     .take = dmn_take_clock,
     .wants = "real or virtual"},
    {0},
};
_Static_assert(sizeof(ROWS) / sizeof(*ROWS) <= DMN_OPTION_MOST + 1, "more rows than fit");

static void help(void)
{
    printf("Usage: fovead --scene FILE [OPTION]...\n\n");
    dmn_print_columns(
        stdout, "", 0,
        "Renders a 360-degree picture of a scene by path tracing, most samples where the eye looks, and "
        "streams it to clients while it sharpens. To see it: foveactl watch, foveactl snapshot FILE.png");
    dmn_option_help(ROWS);
    printf("\n");
    dmn_print_columns(
        stdout, "", 0,
        "With --until and without --listen no socket is opened: fovead renders, shows its progress, saves "
        "and exits. Defaults are --gaze auto and --mode fv. With --until and without --gaze there is no gaze "
        "and the mode is od, so that the whole picture gets equally many samples; --until end keeps auto and "
        "fv. --clock virtual implies --until end and opens a socket only with --listen.");
    printf("\nExample: a picture to keep\n"
           "  fovead --scene hall.gltf --env sky.hdr --until 256spp --save hall.exr\n");
}

static const struct dmn_option_set SET = {"fovead", ROWS, help};

/* --- what was not given, and what does not go together --- */

static void fill_in(struct dmn_options *out)
{
    if (out->virtual_clock && out->until.kind == DMN_UNTIL_STOPPED) out->until.kind = DMN_UNTIL_END;
    if (!out->gaze && (out->until.kind == DMN_UNTIL_STOPPED || out->until.kind == DMN_UNTIL_END))
        out->gaze = "auto";
    if (!out->render.distribution) out->render.distribution = rnd_distribution_find(out->gaze ? "fv" : "od");
}

/* Can the end that --until waits for come? */
static bool check_end(const struct dmn_options *out)
{
    const struct trk_source_kind *kind = kind_of(out);
    const bool endless = out->loop || (kind && !kind->ends);

    if (out->until.kind == DMN_UNTIL_CONVERGED && !out->render.distribution->covers_sphere)
        return dmn_option_refuse(&SET,
                                 "--until converged needs --mode od: %s leaves parts of the sphere aside",
                                 out->render.distribution->name);
    if (out->until.kind == DMN_UNTIL_END && endless)
        return dmn_option_refuse(&SET, "%s has no end to wait for: use another --until",
                                 out->loop ? "--loop" : out->gaze);
    return true;
}

enum dmn_parsed dmn_options_parse(int argc, char **argv, struct dmn_options *out_options)
{
    struct dmn_given given;
    char error[DMN_OPTION_ERROR_SIZE];

    *out_options = (struct dmn_options){.speed = 1, .fov = {(float)(M_PI / 1.8), (float)(M_PI / 1.8)}};
    out_options->render.width = 4096;
    out_options->render.height = 2048;
    switch (dmn_option_parse(&SET, argc, argv, out_options, &given)) {
    case DMN_OPTIONS_ANSWERED:
        return DMN_ANSWERED;
    case DMN_OPTIONS_REFUSED:
        return DMN_REFUSED;
    case DMN_OPTIONS_TAKEN:
        break;
    }
    if (given.operand < argc)
        return dmn_option_refuse(&SET, "'%s' belongs to no option", argv[given.operand]), DMN_REFUSED;
    if (out_options->list_trackers) return DMN_LIST;
    fill_in(out_options);
    if (!dmn_option_check(&SET, &given, out_options) || !check_end(out_options)) return DMN_REFUSED;
    if (out_options->virtual_clock && kind_of(out_options) && kind_of(out_options)->needs_real_clock)
        return dmn_option_refuse(&SET, "--gaze %s needs the real clock", out_options->gaze), DMN_REFUSED;
    if (!out_options->listens && out_options->until.kind == DMN_UNTIL_STOPPED &&
        !dmn_take_listen(NULL, NULL, out_options, error))
        return dmn_option_refuse(&SET, "--listen: %s", error), DMN_REFUSED;
    return DMN_RUN;
}
