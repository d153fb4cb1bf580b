/* A pointer as a source: directions that a client sends, in world frame, delivered in the order they came. */
#include "source/source.h"

#include "error.h"
#include "source/ring.h"

#include <stdio.h>
#include <string.h>

struct pointer {
    struct trk_source source;
    /* all of these under source.lock */
    struct trk_ring ring;
    uint64_t sequence, first_ns, last_ns;
};

static struct trk_source *pointer_open(const char *argument, const struct trk_source_options *options,
                                       char out_error[TRK_ERROR_SIZE])
{
    if (argument) {
        trk_fail(out_error, "gaze source 'pointer:%.100s': expected pointer, which takes no argument",
                 argument);
        return NULL;
    }
    struct pointer *pointer = trk_source_create(sizeof *pointer, &trk_pointer, options->virtual_clock);
    if (!pointer) {
        trk_fail(out_error, "gaze source 'pointer': no memory");
        return NULL;
    }
    snprintf(pointer->source.description, sizeof pointer->source.description, "pointer, moved by a client");
    return &pointer->source;
}

static void pointer_push(struct trk_source *source, const float direction[3], uint64_t time_ns)
{
    struct pointer *pointer = (struct pointer *)source;
    pthread_mutex_lock(&source->lock);
    /* Clients' clocks are only nearly one: time stands still rather than going back. */
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
    const struct trk_sample *first;
    pthread_mutex_lock(&source->lock);
    /* On the virtual clock a sample exists from its own time on. */
    while (result == TRK_SAMPLE && (!(first = trk_ring_first(&pointer->ring)) ||
                                    (source->virtual_clock && first->arrival_ns > until_ns)))
        if (!trk_source_sleep(source, UINT64_MAX, until_ns)) result = TRK_TIMEOUT;
    if (result == TRK_SAMPLE) {
        *out_sample = *first;
        trk_ring_drop(&pointer->ring);
    }
    pthread_mutex_unlock(&source->lock);
    return result;
}

const struct trk_source_type trk_pointer = {
    .name = "pointer",
    .usage = "pointer",
    .open = pointer_open,
    .read = pointer_read,
    .push = pointer_push,
    .close = trk_source_destroy,
};
