/* What all sources share: the clock, the wait that an interrupt ends, and the functions of tracker.h that
 * take an open source. */
#include "source/source.h"

#include "system.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void *trk_source_create(size_t size, const struct trk_source_methods *methods, bool virtual_clock)
{
    struct trk_source *source = calloc(1, size);
    if (!source) return NULL;
    source->methods = methods;
    source->virtual_clock = virtual_clock;
    source->speed = 1;
    trk_condition_init(&source->changed);
    pthread_mutex_init(&source->lock, NULL);
    return source;
}

void trk_source_destroy(struct trk_source *source)
{
    pthread_cond_destroy(&source->changed);
    pthread_mutex_destroy(&source->lock);
    free(source);
}

bool trk_source_sleep(struct trk_source *source, uint64_t wake_ns, uint64_t until_ns)
{
    bool interrupted = source->interrupted;
    source->interrupted = false;
    if (interrupted || source->virtual_clock || trk_now_ns() >= until_ns) return false;
    trk_condition_wait(&source->changed, &source->lock, wake_ns < until_ns ? wake_ns : until_ns);
    return true;
}

enum trk_result trk_source_pace(struct trk_source *source, uint64_t offset_ns, uint64_t until_ns,
                                uint64_t *out_due_ns)
{
    if (!source->started) {
        source->started = true;
        source->start_ns = source->virtual_clock ? 0 : trk_now_ns();
    }
    if (__builtin_add_overflow(source->start_ns, offset_ns, out_due_ns)) *out_due_ns = UINT64_MAX;
    enum trk_result result = TRK_SAMPLE;
    pthread_mutex_lock(&source->lock);
    while (result == TRK_SAMPLE && *out_due_ns > (source->virtual_clock ? until_ns : trk_now_ns()))
        if (!trk_source_sleep(source, *out_due_ns, until_ns)) result = TRK_TIMEOUT;
    pthread_mutex_unlock(&source->lock);
    return result;
}

/* --- functions of tracker.h --- */

void trk_close(struct trk_source *source)
{
    if (source) source->methods->close(source);
}

enum trk_result trk_read(struct trk_source *source, uint64_t until_ns, struct trk_sample *out_sample,
                         char out_error[TRK_ERROR_SIZE])
{
    return source->methods->read(source, until_ns, out_sample, out_error);
}

bool trk_push(struct trk_source *source, const float direction[3], uint64_t time_ns)
{
    if (!source->methods->push) return false;
    /* Use double, so that the squares of the largest and smallest floats neither overflow nor vanish. */
    double x = direction[0], y = direction[1], z = direction[2], length = sqrt(x * x + y * y + z * z);
    if (!isfinite(length) || length == 0) return false;
    source->methods->push(source, (float[3]){(float)(x / length), (float)(y / length), (float)(z / length)},
                          time_ns);
    return true;
}

void trk_get_status(struct trk_source *source, struct trk_status *out_status)
{
    memset(out_status, 0, sizeof *out_status);
    if (source->methods->status) {
        source->methods->status(source, out_status);
    } else {
        memcpy(out_status->description, source->description, sizeof source->description);
        out_status->on_screen = source->on_screen;
    }
    out_status->speed = out_status->is_device ? 1 : source->speed;
}

void trk_interrupt(struct trk_source *source)
{
    if (source->methods->interrupt) {
        source->methods->interrupt(source);
        return;
    }
    pthread_mutex_lock(&source->lock);
    source->interrupted = true;
    pthread_cond_signal(&source->changed);
    pthread_mutex_unlock(&source->lock);
}
