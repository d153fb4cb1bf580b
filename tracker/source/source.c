/* What all sources share: their clock, and the wait that an interrupt ends. */
#include "source/source.h"

#include <sched.h>
#include <stdlib.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

/* The least that Linux grants. */
static const uint64_t prompt_slice_ns = 100000;

uint64_t trk_now_ns(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * 1000000000 + (uint64_t)now.tv_nsec;
}

/* Of two threads that could run, the one whose slice of time ends sooner goes first: a short one is no more
 * of the processor, but sooner. */
void trk_be_prompt(void)
{
    struct { /* struct sched_attr, which the headers of some systems do not let one have beside sched.h */
        uint32_t size, policy;
        uint64_t flags;
        int32_t nice;
        uint32_t priority;
        uint64_t runtime, deadline, period;
    } attributes = {.size = sizeof attributes};
    if (syscall(SYS_sched_getattr, 0, &attributes, sizeof attributes, 0) != 0) return;
    if (attributes.policy != SCHED_OTHER) return; /* somebody knows better */
    attributes.runtime = prompt_slice_ns;
    syscall(SYS_sched_setattr, 0, &attributes, 0);
}

void *trk_source_create(size_t size, const struct trk_source_type *type, bool virtual_clock)
{
    struct trk_source *source = calloc(1, size);
    if (!source) return NULL;
    source->type = type;
    source->virtual_clock = virtual_clock;
    source->speed = 1;
    pthread_condattr_t attributes;
    pthread_condattr_init(&attributes);
    pthread_condattr_setclock(&attributes, CLOCK_MONOTONIC);
    pthread_cond_init(&source->changed, &attributes);
    pthread_condattr_destroy(&attributes);
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
    uint64_t end_ns = wake_ns < until_ns ? wake_ns : until_ns;
    struct timespec end = {.tv_sec = (time_t)(end_ns / 1000000000), .tv_nsec = (long)(end_ns % 1000000000)};
    pthread_cond_timedwait(&source->changed, &source->lock, &end);
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
