/* A pointer as a source: world directions that a client sends, delivered in the order in which they came. */
#include "source/kinds.h"

#include "error.h"
#include "source/ring.h"

#include <stdio.h>
#include <string.h>

struct pointer {
    struct trk_source source;
    /* All of these need source.lock. */
    struct trk_ring ring;
    uint64_t sequence, first_ns, last_ns;
};

static void pointer_push(struct trk_source *source, const float direction[3], uint64_t time_ns)
{
    struct pointer *pointer = (struct pointer *)source;
    pthread_mutex_lock(&source->lock);
    /* The clocks of several clients differ a little: a time before the last one counts as the last one. */
    if (time_ns < pointer->last_ns) time_ns = pointer->last_ns;
    if (pointer->sequence == 0) pointer->first_ns = time_ns;
    pointer->last_ns = time_ns;
    struct trk_sample sample = {
        .sequence = ++pointer->sequence,
        .device_ns = time_ns - pointer->first_ns,
        .arrival_ns = time_ns,
        .valid = TRK_DIRECTION,
    };
    memcpy(sample.direction, direction, sizeof sample.direction);
    trk_ring_put(&pointer->ring, &sample);
    pthread_cond_signal(&source->changed);
    pthread_mutex_unlock(&source->lock);
}

static enum trk_result pointer_read(struct trk_source *source, uint64_t until_ns,
                                    struct trk_sample *out_sample, char out_error[TRK_ERROR_SIZE])
{
    (void)out_error;
    struct pointer *pointer = (struct pointer *)source;
    enum trk_result result = TRK_SAMPLE;
    pthread_mutex_lock(&source->lock);
    while (result == TRK_SAMPLE && !trk_ring_first(&pointer->ring))
        if (!trk_source_sleep(source, UINT64_MAX, until_ns)) result = TRK_TIMEOUT;
    if (result == TRK_SAMPLE) {
        *out_sample = *trk_ring_first(&pointer->ring);
        trk_ring_drop(&pointer->ring);
    }
    pthread_mutex_unlock(&source->lock);
    return result;
}

static const struct trk_source_methods methods = {
    .read = pointer_read,
    .push = pointer_push,
    .close = trk_source_destroy,
};

static struct trk_source *pointer_open(const char *argument, const struct trk_source_options *options,
                                       char out_error[TRK_ERROR_SIZE])
{
    (void)argument;
    struct pointer *pointer = trk_source_create(sizeof *pointer, &methods, options->virtual_clock);
    if (!pointer) {
        trk_fail(out_error, "gaze source 'pointer': no memory");
        return NULL;
    }
    snprintf(pointer->source.description, sizeof pointer->source.description, "pointer, moved by a client");
    return &pointer->source;
}

const struct trk_source_row trk_pointer = {
    .kind = {.name = "pointer",
             .usage = "pointer",
             .summary = "whatever clients send (foveactl look)",
             .needs_real_clock = true,
             .rests_when_silent = true},
    .open = pointer_open,
};
