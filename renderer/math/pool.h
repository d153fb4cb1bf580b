/* A pool of threads that do the same work at once, again and again. */
#ifndef FOVEAD_RENDERER_POOL_H
#define FOVEAD_RENDERER_POOL_H

#include <stdint.h>

/* Wait a few cycles between two checks of what another thread does. */
static inline void rnd_pause(void)
{
#if defined __x86_64__
    __builtin_ia32_pause();
#endif
}

struct rnd_pool;

/* threads, 1 or more, counts the calling thread. NULL if they cannot be started. */
struct rnd_pool *rnd_pool_create(int threads);
void rnd_pool_destroy(struct rnd_pool *pool); /* accepts NULL */

/* Call work(context, i) on the calling thread, with i = 0, and on every other thread of the pool that starts
 * before the first of these calls returns, with its number i from 1 to threads - 1. So work should take items
 * from a shared counter until none is left: a thread that the system runs late is then not waited for.
 * Returns when all calls have returned. All threads see what was written before this call; the caller then
 * sees what they wrote. */
void rnd_pool_run(struct rnd_pool *pool, void (*work)(void *context, int worker), void *context);
/* Split 0 to count - 1 into pieces of turn numbers, the last of them perhaps smaller, and call work(context,
 * first, end) once for each piece, on any thread. */
void rnd_pool_share(struct rnd_pool *pool, uint32_t count, uint32_t turn,
                    void (*work)(void *context, uint32_t first, uint32_t end), void *context);
/* As rnd_pool_run(), but every thread calls work once. */
void rnd_pool_run_all(struct rnd_pool *pool, void (*work)(void *context, int worker), void *context);

#endif
