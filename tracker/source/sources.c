/* The table of gaze sources, and how one of them is chosen: by name, or by what is plugged in. */
#include "error.h"
#include "source/auto.h"
#include "source/device.h"
#include "source/kinds.h"

#include <stdio.h>
#include <string.h>

static struct trk_source *open_auto(const char *argument, const struct trk_source_options *options,
                                    char out_error[TRK_ERROR_SIZE]);

static const struct trk_source_row automatic = {
    .kind = {.name = "auto",
             .usage = "auto",
             .summary =
                 "an eye tracker as soon as there is one, until then the recording that comes with fovead",
             .is_device = true,
             .takes_screen = true,
             .takes_calibration = true,
             .follows_eye = true,
             .ends = true,
             .waits_after_end = true},
    .open = open_auto,
};

/* clang-format off */
static const struct trk_source_row *const rows[] = {
    &automatic,
#define ROW(row) &row,
    TRK_SOURCE_KINDS(ROW)
#undef ROW
};
/* clang-format on */
enum { ROWS = sizeof rows / sizeof *rows };

/* --- by name --- */

/* The entry of the table that a spec names; NULL if there is none. */
static const struct trk_source_row *const *find(const char *spec)
{
    for (int i = 0; i < ROWS; i++) {
        size_t length = strlen(rows[i]->kind.name);
        if (strncmp(spec, rows[i]->kind.name, length) == 0 && (spec[length] == '\0' || spec[length] == ':'))
            return &rows[i];
    }
    return NULL;
}

const struct trk_source_kind *trk_source_kind_at(size_t index)
{
    return index < ROWS ? &rows[index]->kind : NULL;
}

const struct trk_source_kind *trk_source_kind_find(const char *spec)
{
    const struct trk_source_row *const *row = find(spec);
    return row ? &(*row)->kind : NULL;
}

static void fail_unknown(const char *spec, char out_error[TRK_ERROR_SIZE])
{
    char expected[256] = "";
    for (int i = 0; i < ROWS; i++) {
        size_t end = strlen(expected);
        snprintf(expected + end, sizeof expected - end, "%s%s", i ? ", " : "", rows[i]->kind.usage);
    }
    trk_fail(out_error, "unknown gaze source '%.100s', expected one of %s", spec, expected);
}

static bool is_screen(const struct trk_screen *screen)
{
    const float size[3] = {screen->width_m, screen->height_m, screen->distance_m};
    for (int i = 0; i < 3; i++)
        if (size[i] != 0 && !(size[i] >= 0.01f && size[i] <= 20)) return false;
    return (screen->width_m == 0) == (screen->height_m == 0);
}

/* Can this kind be used with these options? */
static bool check(const struct trk_source_kind *kind, const char *argument,
                  const struct trk_source_options *options, char out_error[TRK_ERROR_SIZE])
{
    const struct trk_screen *screen = &options->screen;
    if (!is_screen(screen))
        return trk_fail(out_error,
                        "screen of %g x %g m at %g m: expected width and height, or neither, and distance "
                        "from 0.01 to 20 m",
                        (double)screen->width_m, (double)screen->height_m, (double)screen->distance_m);
    if (argument && strcmp(kind->name, kind->usage) == 0)
        return trk_fail(out_error, "gaze source '%.200s': expected %s, which takes no argument",
                        options->spec, kind->usage);
    if (options->virtual_clock && kind->needs_real_clock)
        return trk_fail(out_error, "gaze source '%.200s': expected %s on the real clock", options->spec,
                        kind->usage);
    return true;
}

/* Open one kind of device, at path if that is not NULL. If the device is absent, the source waits for it. */
static struct trk_source *open_device(const struct trk_source_row *const *row, const char *path,
                                      const struct trk_source_options *options,
                                      char out_error[TRK_ERROR_SIZE])
{
    bool is_present;
    char problem[TRK_ERROR_SIZE] = "";
    if (path && *path != '/') {
        trk_fail(out_error, "gaze source '%.200s': expected %s, an absolute path", options->spec,
                 (*row)->kind.usage);
        return NULL;
    }
    struct trk_source *source = trk_device_open(row, 1, path, options, &is_present, problem);
    if (source && (is_present || !*problem)) return source;
    trk_fail(out_error, "%s", problem);
    trk_close(source);
    return NULL;
}

struct trk_source *trk_open(const struct trk_source_options *options, char out_error[TRK_ERROR_SIZE])
{
    const char *colon = strchr(options->spec, ':'), *argument = colon ? colon + 1 : NULL;
    const struct trk_source_row *const *row = find(options->spec);
    if (!row) {
        fail_unknown(options->spec, out_error);
        return NULL;
    }
    if (!check(&(*row)->kind, argument, options, out_error)) return NULL;
    return (*row)->open ? (*row)->open(argument, options, out_error)
                        : open_device(row, argument, options, out_error);
}

/* --- by what is plugged in --- */

/* Open the first device that works. If there is none, replay the recording, say why, and wait for a device.
 */
static struct trk_source *open_auto(const char *argument, const struct trk_source_options *options,
                                    char out_error[TRK_ERROR_SIZE])
{
    (void)argument;
    struct trk_source *device = NULL;
    char problem[TRK_ERROR_SIZE] = "";
    bool is_present = false;
    if (!options->virtual_clock) {
        device = trk_device_open(rows, ROWS, NULL, options, &is_present, problem);
        if (is_present) return device;
    }
    struct trk_source *replay = NULL;
    if (options->fallback_log)
        replay = trk_replay.open(options->fallback_log, options, out_error);
    else if (*problem)
        trk_fail(out_error, "gaze source 'auto': %s", problem);
    else
        trk_fail(out_error,
                 "gaze source 'auto': no eye tracker found, expected one or a recording to replay");
    if (!replay) {
        trk_close(device);
        return NULL;
    }
    if (device) {
        struct trk_source *both = trk_auto_create(replay, device, problem);
        if (!both) trk_fail(out_error, "gaze source 'auto': no memory");
        return both;
    }
    size_t length = strlen(replay->description);
    snprintf(replay->description + length, sizeof replay->description - length,
             " (no eye tracker on the virtual clock)");
    return replay;
}

size_t trk_list(struct trk_device_info *out_devices, size_t room)
{
    size_t count = 0;
    for (int i = 0; i < ROWS; i++) {
        size_t used = count < room ? count : room;
        if (rows[i]->list) count += rows[i]->list(out_devices + used, room - used);
    }
    return count;
}
