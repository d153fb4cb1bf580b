/* The threads of a render. */
#include "path/pool.h"

#include <pthread.h>
#include <stdbool.h>
#include <stdlib.h>

struct thread {
    struct rnd_pool *pool;
    int index;
    pthread_t id;
};

struct rnd_pool {
    int threads, started;
    struct thread *thread; /* the caller has none: threads - 1 of them */
    pthread_mutex_t mutex; /* guards all below */
    pthread_cond_t begin, end;
    unsigned round; /* of work handed out */
    int busy;
    bool quit;
    void (*work)(void *context, int worker);
    void *context;
};

static void *run(void *argument)
{
    const struct thread *self = argument;
    struct rnd_pool *pool = self->pool;
    unsigned seen = 0;
    pthread_mutex_lock(&pool->mutex);
    for (;;) {
        while (pool->round == seen && !pool->quit) pthread_cond_wait(&pool->begin, &pool->mutex);
        if (pool->quit) break;
        seen = pool->round;
        pthread_mutex_unlock(&pool->mutex);
        pool->work(pool->context, self->index);
        pthread_mutex_lock(&pool->mutex);
        if (--pool->busy == 0) pthread_cond_signal(&pool->end);
    }
    pthread_mutex_unlock(&pool->mutex);
    return NULL;
}

struct rnd_pool *rnd_pool_create(int threads)
{
    struct rnd_pool *pool = calloc(1, sizeof *pool);
    if (!pool) return NULL;
    pool->threads = threads;
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

void rnd_pool_run(struct rnd_pool *pool, void (*work)(void *context, int worker), void *context)
{
    pthread_mutex_lock(&pool->mutex);
    pool->work = work;
    pool->context = context;
    pool->busy = pool->threads - 1;
    pool->round++;
    pthread_cond_broadcast(&pool->begin);
    pthread_mutex_unlock(&pool->mutex);
    work(context, 0);
    pthread_mutex_lock(&pool->mutex);
    while (pool->busy > 0) pthread_cond_wait(&pool->end, &pool->mutex);
    pthread_mutex_unlock(&pool->mutex);
}
