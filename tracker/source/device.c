/* The source that reads an eye tracker, and its thread. */
#include "source/device.h"

#include "clock.h"
#include "error.h"
#include "source/ring.h"
#include "system.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* How often to search for a device: every second; and every tenth of a second for three seconds after a
 * device has gone, because its plug may only be loose. */
static const uint64_t search_ns = 1000000000, search_soon_ns = 100000000, soon_ns = 3000000000;

/* No step of a device lasts longer, so closing does not take longer either. */
enum { STEP_MS = 20 };

/* A device that has sent nothing for this many of its periods has lost the eyes. */
static const double silent_periods = 5;
static const double shortest_silence_ns = 20e6, longest_silence_ns = 500e6, usual_period_ns = 1e9 / 60;

static const double period_weight = 1.0 / 32;

struct trk_device {
    struct trk_source source;
    const struct trk_source_row *const *rows; /* the rows that are devices are tried in turn */
    int count;
    char *path, *calibration;
    struct trk_source_options options;
    pthread_t thread;
    bool has_thread;

    /* Only the thread uses these, and before it starts only trk_device_open(). */
    const struct trk_source_row *row; /* row of the device that was opened last */
    void *handle;                     /* NULL: none is open */
    struct trk_device_facts facts;
    struct trk_clock clock;
    double period_ns;            /* measured; 0 until there are two samples */
    uint64_t base_ns, opened_ns; /* device_ns and arrival of the first sample since it was opened */
    uint64_t arrival_ns;         /* of the last sample; 0: none since the device was opened */
    uint64_t gone_ns;            /* when a device was last unplugged; 0: never */
    bool silent;
    char problem[TRK_ERROR_SIZE]; /* why no device is open, or "" */

    /* Under source.lock. */
    pthread_cond_t stopping; /* on CLOCK_MONOTONIC */
    bool stop;
    struct trk_ring ring;
    uint64_t sequence, device_ns, last_arrival_ns;
    struct trk_status status;
    struct trk_source *held_for; /* samples are held back for this source; NULL: the reader gets them */
    bool seen;
};

static void set_description(struct trk_device *device)
{
    char text[TRK_ERROR_SIZE];
    if (device->handle)
        snprintf(text, sizeof text, "eye tracker %s%s%s", device->facts.description,
                 *device->facts.remark ? "; " : "", device->facts.remark);
    else if (*device->problem)
        snprintf(text, sizeof text, "waiting for an eye tracker: %.480s", device->problem);
    else
        snprintf(text, sizeof text, "waiting for an eye tracker%s%s to be plugged in",
                 device->path ? " at " : "", device->path ? device->path : "");
    pthread_mutex_lock(&device->source.lock);
    struct trk_status *status = &device->status;
    if (strcmp(status->description, text) != 0) status->changes++;
    memcpy(status->description, text, sizeof text);
    status->present = device->handle;
    pthread_mutex_unlock(&device->source.lock);
}

/* --- samples --- */

static void put(struct trk_device *device, struct trk_sample *sample)
{
    pthread_mutex_lock(&device->source.lock);
    struct trk_source *wake = NULL;
    if (sample->device_ns < device->device_ns) sample->device_ns = device->device_ns;
    if (sample->arrival_ns < device->last_arrival_ns) sample->arrival_ns = device->last_arrival_ns;
    device->device_ns = sample->device_ns;
    device->last_arrival_ns = sample->arrival_ns;
    float head[3];
    if (device->held_for && trk_gaze_direction(sample, head, NULL)) {
        device->ring.count = 0;
        device->sequence = 0;
        device->seen = true;
        wake = device->held_for;
    }
    sample->sequence = ++device->sequence;
    if (!device->held_for || device->seen) trk_ring_put(&device->ring, sample);
    struct trk_status *status = &device->status;
    double period_ns = device->period_ns;
    status->rate_hz = period_ns > 0 ? 1e9 / period_ns : device->facts.rate_hz;
    status->has_clock = device->facts.clock_bits;
    struct trk_clock_figures figures;
    trk_clock_figures(&device->clock, &figures);
    status->jitter_ms = figures.jitter_ns / 1e6;
    status->drift_ppm = figures.drift_ppm;
    pthread_cond_signal(&device->source.changed);
    pthread_mutex_unlock(&device->source.lock);
    if (wake) trk_interrupt(wake);
}

void trk_device_deliver(struct trk_device *device, const struct trk_sample *sample, uint64_t ticks,
                        uint64_t arrival_ns)
{
    struct trk_sample copy = *sample;
    if (arrival_ns < device->arrival_ns) arrival_ns = device->arrival_ns;
    copy.arrival_ns = arrival_ns;
    copy.sensor_ns = 0;
    if (!device->arrival_ns) {
        /* Device time continues after the last sample of the former device, as if its clock had kept running.
         */
        if (device->sequence) device->base_ns = device->device_ns + arrival_ns - device->last_arrival_ns;
        device->opened_ns = arrival_ns;
    } else if (!device->silent) {
        double period_ns = (double)(arrival_ns - device->arrival_ns);
        device->period_ns += (device->period_ns > 0 ? period_weight : 1) * (period_ns - device->period_ns);
    }
    device->silent = false;
    device->arrival_ns = arrival_ns;
    copy.device_ns = arrival_ns - device->opened_ns;
    if (device->facts.clock_bits)
        trk_clock_add(&device->clock, ticks, arrival_ns, &copy.device_ns, &copy.sensor_ns);
    copy.device_ns += device->base_ns;
    put(device, &copy);
}

/* Deliver a sample without a gaze, because the device is silent or has gone. */
static void deliver_loss(struct trk_device *device, uint64_t now_ns)
{
    if (!device->arrival_ns || device->silent) return;
    struct trk_sample sample = {
        .arrival_ns = now_ns,
        .device_ns = device->device_ns + now_ns - device->last_arrival_ns,
        .sensor_ns = device->facts.clock_bits ? now_ns : 0,
    };
    device->silent = true;
    pthread_mutex_lock(&device->source.lock);
    device->status.losses++;
    pthread_mutex_unlock(&device->source.lock);
    put(device, &sample);
}

void trk_device_news(struct trk_device *device, double rate_hz, const char *remark)
{
    if (rate_hz > 0) device->facts.rate_hz = rate_hz;
    if (!remark || strcmp(device->facts.remark, remark) == 0) return;
    snprintf(device->facts.remark, sizeof device->facts.remark, "%s", remark);
    set_description(device);
}

/* How long a device may be silent: several periods of its nominal or its measured rate, whichever is slower.
 */
static uint64_t patience_ns(const struct trk_device *device)
{
    double period_ns = device->period_ns;
    if (device->facts.rate_hz > 0) period_ns = fmax(period_ns, 1e9 / device->facts.rate_hz);
    if (!(period_ns > 0)) period_ns = usual_period_ns;
    return (uint64_t)fmin(fmax(silent_periods * period_ns, shortest_silence_ns), longest_silence_ns);
}

/* --- plugging --- */

/* Open the first device that works. out_error says why the first one that did not work could not be opened;
 * "" if there is none. */
static bool search(struct trk_device *device, char out_error[TRK_ERROR_SIZE])
{
    char error[TRK_ERROR_SIZE];
    out_error[0] = '\0';
    for (int i = 0; i < device->count && !device->handle; i++) {
        const struct trk_source_row *row = device->rows[i];
        if (!row->attach) continue;
        memset(&device->facts, 0, sizeof device->facts);
        error[0] = '\0';
        device->handle = row->attach(device, device->path, &device->options, &device->facts, error);
        device->row = row;
        if (!device->handle && !*out_error) memcpy(out_error, error, sizeof error);
    }
    if (!device->handle) return false;
    if (device->facts.clock_bits)
        trk_clock_init(&device->clock, device->facts.clock_bits, device->facts.tick_ns);
    device->arrival_ns = 0;
    device->period_ns = 0;
    device->silent = false;
    *device->problem = '\0';
    pthread_mutex_lock(&device->source.lock);
    device->status.connections++;
    device->status.on_screen = device->facts.on_screen;
    pthread_mutex_unlock(&device->source.lock);
    set_description(device);
    return true;
}

static void unplug(struct trk_device *device)
{
    device->row->detach(device->handle);
    device->handle = NULL;
    device->gone_ns = trk_now_ns();
    deliver_loss(device, device->gone_ns);
    set_description(device);
}

static void step(struct trk_device *device)
{
    uint64_t wait_ns = STEP_MS * UINT64_C(1000000), now_ns = trk_now_ns();
    uint64_t end_ns = device->arrival_ns + patience_ns(device);
    bool listening = device->arrival_ns && !device->silent;
    if (listening && end_ns < now_ns + wait_ns) wait_ns = end_ns > now_ns ? end_ns - now_ns : 0;
    uint64_t before_ns = device->arrival_ns;
    if (!device->row->step(device->handle, (int)((wait_ns + 999999) / 1000000))) {
        unplug(device);
        return;
    }
    /* The device is silent only if there was nothing to read: the thread may just be late. */
    if (listening && device->arrival_ns == before_ns && (now_ns = trk_now_ns()) >= end_ns)
        deliver_loss(device, now_ns);
}

/* Wait until the next search, or until the source is closed. */
static void rest(struct trk_device *device)
{
    uint64_t now_ns = trk_now_ns();
    bool soon = device->gone_ns && now_ns < device->gone_ns + soon_ns;
    uint64_t end_ns = now_ns + (soon ? search_soon_ns : search_ns);
    pthread_mutex_lock(&device->source.lock);
    while (!device->stop && trk_now_ns() < end_ns)
        trk_condition_wait(&device->stopping, &device->source.lock, end_ns);
    pthread_mutex_unlock(&device->source.lock);
}

static bool is_stopped(struct trk_device *device)
{
    pthread_mutex_lock(&device->source.lock);
    bool stop = device->stop;
    pthread_mutex_unlock(&device->source.lock);
    return stop;
}

static void *run(void *argument)
{
    struct trk_device *device = argument;
    trk_be_prompt();
    while (!is_stopped(device)) {
        if (device->handle) {
            step(device);
            continue;
        }
        rest(device);
        if (is_stopped(device) || search(device, device->problem)) continue;
        set_description(device);
    }
    return NULL;
}

/* --- the source --- */

static void device_close(struct trk_source *source)
{
    struct trk_device *device = (struct trk_device *)source;
    pthread_mutex_lock(&source->lock);
    device->stop = true;
    pthread_cond_signal(&device->stopping);
    pthread_mutex_unlock(&source->lock);
    if (device->has_thread) pthread_join(device->thread, NULL);
    if (device->handle) device->row->detach(device->handle);
    pthread_cond_destroy(&device->stopping);
    free(device->path);
    free(device->calibration);
    trk_source_destroy(source);
}

static enum trk_result device_read(struct trk_source *source, uint64_t until_ns,
                                   struct trk_sample *out_sample, char out_error[TRK_ERROR_SIZE])
{
    (void)out_error;
    struct trk_device *device = (struct trk_device *)source;
    enum trk_result result = TRK_SAMPLE;
    pthread_mutex_lock(&source->lock);
    while (result == TRK_SAMPLE && !trk_ring_first(&device->ring))
        if (!trk_source_sleep(source, UINT64_MAX, until_ns)) result = TRK_TIMEOUT;
    if (result == TRK_SAMPLE) {
        *out_sample = *trk_ring_first(&device->ring);
        trk_ring_drop(&device->ring);
    }
    pthread_mutex_unlock(&source->lock);
    return result;
}

static void device_status(struct trk_source *source, struct trk_status *out_status)
{
    struct trk_device *device = (struct trk_device *)source;
    pthread_mutex_lock(&source->lock);
    *out_status = device->status;
    pthread_mutex_unlock(&source->lock);
}

static const struct trk_source_methods methods = {
    .read = device_read,
    .status = device_status,
    .close = device_close,
};

struct trk_source *trk_device_open(const struct trk_source_row *const *rows, int count, const char *path,
                                   const struct trk_source_options *options, bool *out_present,
                                   char out_error[TRK_ERROR_SIZE])
{
    struct trk_device *device = trk_source_create(sizeof *device, &methods, false);
    if (!device) goto no_memory;
    trk_condition_init(&device->stopping);
    device->rows = rows;
    device->count = count;
    device->status.is_device = true;
    device->options = (struct trk_source_options){.screen = options->screen};
    if (path && !(device->path = strdup(path))) goto no_memory;
    if (options->calibration && !(device->calibration = strdup(options->calibration))) goto no_memory;
    device->options.calibration = device->calibration;
    *out_present = search(device, device->problem);
    memcpy(out_error, device->problem, sizeof device->problem);
    set_description(device);
    memcpy(device->source.description, device->status.description, sizeof device->status.description);
    device->has_thread = pthread_create(&device->thread, NULL, run, device) == 0;
    if (device->has_thread) return &device->source;
no_memory:
    if (device) device_close(&device->source);
    *out_present = false;
    trk_fail(out_error, "eye tracker: no memory or thread for it");
    return NULL;
}

void trk_device_hold(struct trk_source *source, struct trk_source *other)
{
    struct trk_device *device = (struct trk_device *)source;
    pthread_mutex_lock(&source->lock);
    device->held_for = other;
    device->seen = false;
    device->ring.count = 0;
    pthread_mutex_unlock(&source->lock);
}

bool trk_device_sees_eye(struct trk_source *source)
{
    struct trk_device *device = (struct trk_device *)source;
    pthread_mutex_lock(&source->lock);
    bool seen = device->seen;
    pthread_mutex_unlock(&source->lock);
    return seen;
}

void trk_device_release(struct trk_source *source)
{
    struct trk_device *device = (struct trk_device *)source;
    pthread_mutex_lock(&source->lock);
    device->held_for = NULL;
    pthread_mutex_unlock(&source->lock);
}
