/* What the operating system provides: the time, waiting, and prompt scheduling. */
#include "system.h"

#include "tracker.h"

#include <errno.h>
#include <sched.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

/* The shortest time slice that Linux grants. */
static const uint64_t prompt_slice_ns = 100000;

uint64_t trk_now_ns(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * 1000000000 + (uint64_t)now.tv_nsec;
}

void trk_condition_init(pthread_cond_t *condition)
{
    pthread_condattr_t attributes;
    pthread_condattr_init(&attributes);
    pthread_condattr_setclock(&attributes, CLOCK_MONOTONIC);
    pthread_cond_init(condition, &attributes);
    pthread_condattr_destroy(&attributes);
}

bool trk_condition_wait(pthread_cond_t *condition, pthread_mutex_t *lock, uint64_t end_ns)
{
    struct timespec end = {.tv_sec = (time_t)(end_ns / 1000000000), .tv_nsec = (long)(end_ns % 1000000000)};
    return pthread_cond_timedwait(condition, lock, &end) != ETIMEDOUT;
}

/* Of two threads that are ready to run, the kernel takes the one whose time slice ends sooner. A short slice
 * does not give a thread more processor time, but gives it sooner. */
void trk_be_prompt(void)
{
    struct { /* struct sched_attr; some systems' headers for it clash with sched.h */
        uint32_t size, policy;
        uint64_t flags;
        int32_t nice;
        uint32_t priority;
        uint64_t runtime, deadline, period;
    } attributes = {.size = sizeof attributes};
    if (syscall(SYS_sched_getattr, 0, &attributes, sizeof attributes, 0) != 0) return;
    if (attributes.policy != SCHED_OTHER) return; /* the user has chosen another policy */
    attributes.runtime = prompt_slice_ns;
    syscall(SYS_sched_setattr, 0, &attributes, 0);
}
