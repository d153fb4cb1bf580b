/* A few threads that do the same thing at once, again and again. */
#ifndef FOVEAD_RENDERER_POOL_H
#define FOVEAD_RENDERER_POOL_H

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

/* Call work(context, i) once for every i in 0..threads-1, each on its own thread, and wait for all; i = 0 is
 * the caller's. What was written before is seen by all, and what they wrote is seen after. */
void rnd_pool_run(struct rnd_pool *pool, void (*work)(void *context, int worker), void *context);

#endif
