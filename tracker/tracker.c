/* The tracker's front: the table of sources, how one is chosen, and what every caller goes through. */
#include "tracker.h"

#include "error.h"
#include "source/device.h"
#include "source/source.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const struct trk_source_type *const types[] = {
    &trk_replay,
    &trk_synthetic,
    &trk_pointer,
};
enum { TYPES = sizeof types / sizeof *types };

/* Eye trackers, in the order in which auto tries them. */
static const struct trk_driver *const drivers[] = {
    &trk_hid,
    &trk_psvr2,
};
enum { DRIVERS = sizeof drivers / sizeof *drivers };

/* The first device that opens; without one the recording, a word on why, and an eye on what is plugged in. */
static struct trk_source *open_auto(const struct trk_source_options *options, char out_error[TRK_ERROR_SIZE])
{
    struct trk_source *device = NULL;
    char problem[TRK_ERROR_SIZE] = "";
    bool is_present = false;
    if (!options->virtual_clock) {
        device = trk_device_open(drivers, DRIVERS, NULL, options, &is_present, problem);
        if (is_present) return device;
    }
    struct trk_source *recording = NULL;
    if (options->fallback_log)
        recording = trk_replay.open(options->fallback_log, options, out_error);
    else if (*problem)
        trk_fail(out_error, "gaze source 'auto': %s", problem);
    else
        trk_fail(out_error,
                 "gaze source 'auto': no eye tracker found, expected one or a recording to replay");
    if (!recording) {
        trk_close(device);
        return NULL;
    }
    if (device) {
        struct trk_source *both = trk_auto_create(recording, device, problem);
        if (!both) trk_fail(out_error, "gaze source 'auto': no memory");
        return both;
    }
    size_t length = strlen(recording->description);
    snprintf(recording->description + length, sizeof recording->description - length,
             " (no eye tracker on the virtual clock)");
    return recording;
}

static struct trk_source *open_device(const struct trk_driver *const *driver, const char *path,
                                      const struct trk_source_options *options,
                                      char out_error[TRK_ERROR_SIZE])
{
    bool is_present;
    char problem[TRK_ERROR_SIZE] = "";
    if (options->virtual_clock || (path && (!(*driver)->takes_path || *path != '/'))) {
        trk_fail(out_error, "gaze source '%.100s%s%.100s': expected %s%s", (*driver)->name, path ? ":" : "",
                 path ? path : "", (*driver)->usage,
                 options->virtual_clock  ? " on the real clock"
                 : (*driver)->takes_path ? ", an absolute path"
                                         : "");
        return NULL;
    }
    struct trk_source *source = trk_device_open(driver, 1, path, options, &is_present, problem);
    if (source && (is_present || !*problem)) return source;
    trk_fail(out_error, "%s", problem);
    trk_close(source);
    return NULL;
}

static bool is_screen(const struct trk_screen *screen)
{
    const float size[3] = {screen->width_m, screen->height_m, screen->distance_m};
    for (int i = 0; i < 3; i++)
        if (size[i] != 0 && !(size[i] >= 0.01f && size[i] <= 20)) return false;
    return (screen->width_m == 0) == (screen->height_m == 0);
}

static bool is_named(const char *spec, const char *name)
{
    size_t length = strlen(name);
    return strncmp(spec, name, length) == 0 && (spec[length] == '\0' || spec[length] == ':');
}

struct trk_source *trk_open(const struct trk_source_options *options, char out_error[TRK_ERROR_SIZE])
{
    const char *colon = strchr(options->spec, ':'), *argument = colon ? colon + 1 : NULL;
    if (!is_screen(&options->screen)) {
        trk_fail(out_error,
                 "screen of %g x %g m at %g m: expected width and height, or neither, and distance "
                 "from 0.01 to 20 m",
                 (double)options->screen.width_m, (double)options->screen.height_m,
                 (double)options->screen.distance_m);
        return NULL;
    }
    if (strcmp(options->spec, "auto") == 0) return open_auto(options, out_error);
    for (int i = 0; i < DRIVERS; i++)
        if (is_named(options->spec, drivers[i]->name))
            return open_device(&drivers[i], argument, options, out_error);
    for (int i = 0; i < TYPES; i++)
        if (is_named(options->spec, types[i]->name)) return types[i]->open(argument, options, out_error);

    char expected[256] = "auto";
    for (int i = 0; i < DRIVERS + TYPES; i++) {
        size_t end = strlen(expected);
        snprintf(expected + end, sizeof expected - end, ", %s",
                 i < DRIVERS ? drivers[i]->usage : types[i - DRIVERS]->usage);
    }
    trk_fail(out_error, "unknown gaze source '%.100s', expected one of %s", options->spec, expected);
    return NULL;
}

size_t trk_list(struct trk_device_info *out_devices, size_t room)
{
    size_t count = 0;
    for (int i = 0; i < DRIVERS; i++) {
        size_t used = count < room ? count : room;
        count += drivers[i]->list(out_devices + used, room - used);
    }
    return count;
}

void trk_close(struct trk_source *source)
{
    if (source) source->type->close(source);
}

const char *trk_describe(const struct trk_source *source)
{
    return source->description;
}

enum trk_result trk_read(struct trk_source *source, uint64_t until_ns, struct trk_sample *out_sample,
                         char out_error[TRK_ERROR_SIZE])
{
    return source->type->read(source, until_ns, out_sample, out_error);
}

bool trk_push(struct trk_source *source, const float direction[3], uint64_t time_ns)
{
    if (!source->type->push) return false;
    /* In double: the squares of the largest and smallest floats still count. */
    double x = direction[0], y = direction[1], z = direction[2], length = sqrt(x * x + y * y + z * z);
    if (!isfinite(length) || length == 0) return false;
    source->type->push(source, (float[3]){(float)(x / length), (float)(y / length), (float)(z / length)},
                       time_ns);
    return true;
}

void trk_get_status(struct trk_source *source, struct trk_status *out_status)
{
    memset(out_status, 0, sizeof *out_status);
    if (source->type->status)
        source->type->status(source, out_status);
    else
        memcpy(out_status->description, source->description, sizeof source->description);
    out_status->speed = out_status->is_device ? 1 : source->speed;
}

void trk_interrupt(struct trk_source *source)
{
    if (source->type->interrupt) {
        source->type->interrupt(source);
        return;
    }
    pthread_mutex_lock(&source->lock);
    source->interrupted = true;
    pthread_cond_signal(&source->changed);
    pthread_mutex_unlock(&source->lock);
}
