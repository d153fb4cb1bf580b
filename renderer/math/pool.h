/* A few threads that do the same thing at once, again and again. */
#ifndef FOVEAD_RENDERER_POOL_H
#define FOVEAD_RENDERER_POOL_H

#include <stdint.h>

/* Between two looks for what another thread is about to do. */
static inline void rnd_pause(void)
{
#if defined __x86_64__
    __builtin_ia32_pause();
#endif
}

struct rnd_pool;

/* threads, the caller's included: 1 or more. NULL if they cannot be started. */
struct rnd_pool *rnd_pool_create(int threads);
void rnd_pool_destroy(struct rnd_pool *pool); /* accepts NULL */

/* Call work(context, i) on the caller's thread, i = 0, and on every other one of the pool that comes before
 * the caller's call has returned; i in 1..threads-1 tells them apart. So work is to take turns from a counter
 * until none is left. A thread that the system lets run late is then not waited for: it has nothing to do.
 * Returns when all calls have. What was written before is seen by all, and what they wrote is seen after. */
void rnd_pool_run(struct rnd_pool *pool, void (*work)(void *context, int worker), void *context);
/* Split 0 to count - 1 into pieces of turn, of which the last may be smaller, and call work(context, first,
 * end) once for each, on any of the threads. */
void rnd_pool_share(struct rnd_pool *pool, uint32_t count, uint32_t turn,
                    void (*work)(void *context, uint32_t first, uint32_t end), void *context);
/* As rnd_pool_run(), but every thread makes its call, once. */
void rnd_pool_run_all(struct rnd_pool *pool, void (*work)(void *context, int worker), void *context);

#endif
