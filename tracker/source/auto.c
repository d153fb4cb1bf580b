/* The source that switches once, from a replay to an eye tracker. */
#include "source/auto.h"

#include "source/device.h"
#include "system.h"

#include <stdatomic.h>
#include <stdio.h>
#include <string.h>

struct auto_source {
    struct trk_source source;
    struct trk_source *replay, *device;
    atomic_bool interrupted;
    atomic_bool taken_up; /* set by the reader: samples are the device's */
    /* Only the reader uses the rest. */
    bool ended; /* the replay */
    /* Where the replay stopped. The device's sequence and times continue from there. */
    uint64_t sequence, device_ns, arrival_ns, first_ns;
    bool has_first;
};

static void take_up(struct auto_source *both)
{
    trk_device_release(both->device);
    atomic_store(&both->taken_up, true);
}

static void go_on(struct auto_source *both, struct trk_sample *sample)
{
    if (!both->has_first) {
        both->has_first = true;
        both->first_ns = sample->device_ns;
        if (both->sequence && sample->arrival_ns > both->arrival_ns)
            both->device_ns += sample->arrival_ns - both->arrival_ns;
    }
    sample->sequence += both->sequence;
    sample->device_ns += both->device_ns - both->first_ns;
}

/* trk_interrupt() ends a wait for the replay or the device. The flags tell whether the caller interrupted it,
 * or the device. */
static enum trk_result auto_read(struct trk_source *source, uint64_t until_ns, struct trk_sample *out_sample,
                                 char out_error[TRK_ERROR_SIZE])
{
    struct auto_source *both = (struct auto_source *)source;
    for (;;) {
        if (trk_device_sees_eye(both->device) && !atomic_load(&both->taken_up)) take_up(both);
        bool from_device = atomic_load(&both->taken_up) || both->ended;
        enum trk_result result =
            trk_read(from_device ? both->device : both->replay, until_ns, out_sample, out_error);
        if (result == TRK_SAMPLE && from_device) {
            go_on(both, out_sample);
            return result;
        }
        if (result == TRK_SAMPLE) {
            both->sequence = out_sample->sequence;
            both->device_ns = out_sample->device_ns;
            both->arrival_ns = out_sample->arrival_ns;
            return result;
        }
        if (atomic_exchange(&both->interrupted, false)) return TRK_TIMEOUT;
        if (result == TRK_END) {
            both->ended = true;
            take_up(both);
            return result;
        }
        if (result == TRK_FAILED || trk_now_ns() >= until_ns) return result;
    }
}

static void auto_interrupt(struct trk_source *source)
{
    struct auto_source *both = (struct auto_source *)source;
    atomic_store(&both->interrupted, true);
    trk_interrupt(both->replay);
    trk_interrupt(both->device);
}

static void auto_status(struct trk_source *source, struct trk_status *out_status)
{
    struct auto_source *both = (struct auto_source *)source;
    bool taken_up = atomic_load(&both->taken_up);
    trk_get_status(both->device, out_status);
    out_status->changes += taken_up; /* the switch changes the description once */
    if (taken_up) return;
    memcpy(out_status->description, source->description, sizeof source->description);
    out_status->is_device = false;
    out_status->on_screen = source->on_screen; /* of the replay */
}

static void auto_close(struct trk_source *source)
{
    struct auto_source *both = (struct auto_source *)source;
    trk_close(both->device); /* the device first, because its thread interrupts the replay */
    trk_close(both->replay);
    trk_source_destroy(source);
}

static const struct trk_source_methods methods = {
    .read = auto_read,
    .interrupt = auto_interrupt,
    .status = auto_status,
    .close = auto_close,
};

struct trk_source *trk_auto_create(struct trk_source *replay, struct trk_source *device, const char *problem)
{
    struct auto_source *both = trk_source_create(sizeof *both, &methods, false);
    if (!both) {
        trk_close(device);
        trk_close(replay);
        return NULL;
    }
    both->replay = replay;
    both->device = device;
    both->source.speed = replay->speed;
    both->source.on_screen = replay->on_screen;
    snprintf(both->source.description, sizeof both->source.description, "%.290s (%.200s)",
             replay->description, *problem ? problem : "no eye tracker found");
    trk_device_hold(device, replay);
    return &both->source;
}
