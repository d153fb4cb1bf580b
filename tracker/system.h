/* system: the monotonic clock, and waiting on it. */
#ifndef FOVEAD_TRACKER_SYSTEM_H
#define FOVEAD_TRACKER_SYSTEM_H

#include <pthread.h>
#include <stdbool.h>
#include <stdint.h>

/* CLOCK_MONOTONIC in nanoseconds. */
uint64_t trk_now_ns(void);

/* A condition whose waits are timed on CLOCK_MONOTONIC. */
void trk_condition_init(pthread_cond_t *condition);

/* With the lock held, wait until the condition is signalled or end_ns has come; may also return early without
 * a reason. Returns false if end_ns has come. */
bool trk_condition_wait(pthread_cond_t *condition, pthread_mutex_t *lock, uint64_t end_ns);

#endif
