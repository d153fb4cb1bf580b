/* The threads of a render. */
#include "math/pool.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdlib.h>

/* How often a thread checks for what it waits for before it sleeps: about a tenth of a millisecond, which is
 * as long as one thread works alone between two rounds, and as long as waking a sleeper takes. A thread that
 * checked in vain checks half as often the next time: where other programs use the processors, waits are
 * longer. */
enum { CHECKS = 4000, LEAST_CHECKS = 60 };

struct thread {
    struct rnd_pool *pool;
    int index;
    pthread_t id;
};

struct rnd_pool {
    int threads, started;
    struct thread *thread; /* threads - 1 of them, as the caller is one too */
    pthread_mutex_t mutex; /* protects the rest, and is held to sleep */
    pthread_cond_t begin, end;
    _Atomic unsigned round; /* number of rounds of work handed out; and of the last one, threads that work
                               or must come */
    _Atomic int busy;
    bool open; /* a thread that comes now may still join */
    bool all;  /* every thread must join */
    bool quit;
    int checks; /* of the caller */
    void (*work)(void *context, int worker);
    void *context;
};

static void adapt(int *checks, bool found)
{
    const int next = found ? 2 * *checks : *checks / 2;
    *checks = next > CHECKS ? CHECKS : next < LEAST_CHECKS ? LEAST_CHECKS : next;
}

static void *run(void *argument)
{
    const struct thread *self = argument;
    struct rnd_pool *pool = self->pool;
    int checks = CHECKS;
    for (unsigned seen = 0;;) {
        for (int i = 0; i < checks && atomic_load(&pool->round) == seen; i++) rnd_pause();
        adapt(&checks, atomic_load(&pool->round) != seen);
        pthread_mutex_lock(&pool->mutex);
        while (atomic_load(&pool->round) == seen && !pool->quit)
            pthread_cond_wait(&pool->begin, &pool->mutex);
        seen = atomic_load(&pool->round);
        const bool quit = pool->quit, joins = pool->open || pool->all;
        if (joins && !pool->all) atomic_fetch_add(&pool->busy, 1);
        pthread_mutex_unlock(&pool->mutex);
        if (quit) return NULL;
        if (!joins) continue;
        pool->work(pool->context, self->index);
        if (atomic_fetch_sub(&pool->busy, 1) != 1) continue;
        pthread_mutex_lock(&pool->mutex);
        pthread_cond_signal(&pool->end);
        pthread_mutex_unlock(&pool->mutex);
    }
}

struct rnd_pool *rnd_pool_create(int threads)
{
    struct rnd_pool *pool = calloc(1, sizeof *pool);
    if (!pool) return NULL;
    pool->threads = threads;
    pool->checks = CHECKS;
    pthread_mutex_init(&pool->mutex, NULL);
    pthread_cond_init(&pool->begin, NULL);
    pthread_cond_init(&pool->end, NULL);
    pool->thread = calloc((size_t)threads, sizeof *pool->thread);
    while (pool->thread && pool->started < threads - 1) {
        struct thread *t = &pool->thread[pool->started];
        *t = (struct thread){.pool = pool, .index = pool->started + 1};
        if (pthread_create(&t->id, NULL, run, t) != 0) break;
        pool->started++;
    }
    if (pool->thread && pool->started == threads - 1) return pool;
    rnd_pool_destroy(pool);
    return NULL;
}

void rnd_pool_destroy(struct rnd_pool *pool)
{
    if (!pool) return;
    pthread_mutex_lock(&pool->mutex);
    pool->quit = true;
    pthread_cond_broadcast(&pool->begin);
    pthread_mutex_unlock(&pool->mutex);
    for (int i = 0; i < pool->started; i++) pthread_join(pool->thread[i].id, NULL);
    pthread_cond_destroy(&pool->begin);
    pthread_cond_destroy(&pool->end);
    pthread_mutex_destroy(&pool->mutex);
    free(pool->thread);
    free(pool);
}

static void hand_out(struct rnd_pool *pool, void (*work)(void *context, int worker), void *context, bool all)
{
    pthread_mutex_lock(&pool->mutex);
    pool->work = work;
    pool->context = context;
    pool->open = true;
    pool->all = all;
    atomic_store(&pool->busy, all ? pool->threads - 1 : 0);
    atomic_fetch_add(&pool->round, 1);
    pthread_cond_broadcast(&pool->begin);
    pthread_mutex_unlock(&pool->mutex);
    work(context, 0);
    pthread_mutex_lock(&pool->mutex);
    pool->open = false;
    pthread_mutex_unlock(&pool->mutex);
    if (atomic_load(&pool->busy) == 0) return;
    for (int i = 0; i < pool->checks && atomic_load(&pool->busy) > 0; i++) rnd_pause();
    adapt(&pool->checks, atomic_load(&pool->busy) == 0);
    if (atomic_load(&pool->busy) == 0) return;
    pthread_mutex_lock(&pool->mutex);
    while (atomic_load(&pool->busy) > 0) pthread_cond_wait(&pool->end, &pool->mutex);
    pthread_mutex_unlock(&pool->mutex);
}

void rnd_pool_run(struct rnd_pool *pool, void (*work)(void *context, int worker), void *context)
{
    hand_out(pool, work, context, false);
}

void rnd_pool_run_all(struct rnd_pool *pool, void (*work)(void *context, int worker), void *context)
{
    hand_out(pool, work, context, true);
}

struct sharing {
    uint32_t count, turn;
    _Atomic uint32_t next; /* the first number that no thread has taken yet */
    void (*work)(void *context, uint32_t first, uint32_t end);
    void *context;
};

static void take_turns(void *argument, int worker)
{
    struct sharing *s = argument;
    (void)worker;
    for (uint32_t i; (i = atomic_fetch_add_explicit(&s->next, s->turn, memory_order_relaxed)) < s->count;)
        s->work(s->context, i, s->count - i < s->turn ? s->count : i + s->turn);
}

void rnd_pool_share(struct rnd_pool *pool, uint32_t count, uint32_t turn,
                    void (*work)(void *context, uint32_t first, uint32_t end), void *context)
{
    struct sharing sharing = {.count = count, .turn = turn, .work = work, .context = context};
    rnd_pool_run(pool, take_turns, &sharing);
}
