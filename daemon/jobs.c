/* A thread that does one job after the other. */
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>

#include "jobs.h"

struct dmn_jobs {
    const struct dmn_handles *handles;
    void (*wake)(void *context);
    void *context;
    pthread_t thread;
    bool started;

    pthread_mutex_t lock; /* of all that follows */
    pthread_cond_t changed;
    bool stop;
    /* A ring: first jobs that are done, then jobs that wait. */
    struct dmn_job job[DMN_JOBS];
    unsigned first, done, count;
};

static void *run(void *argument)
{
    struct dmn_jobs *jobs = argument;

    pthread_mutex_lock(&jobs->lock);
    while (!jobs->stop) {
        struct dmn_job *job;

        if (jobs->done == jobs->count) {
            pthread_cond_wait(&jobs->changed, &jobs->lock);
            continue;
        }
        /* Only this thread uses the job's place in the ring until the job is marked done. */
        job = &jobs->job[(jobs->first + jobs->done) % DMN_JOBS];
        pthread_mutex_unlock(&jobs->lock);
        job->good = job->kind->run(jobs->handles, job);
        pthread_mutex_lock(&jobs->lock);
        jobs->done++;
        jobs->wake(jobs->context);
    }
    pthread_mutex_unlock(&jobs->lock);
    return NULL;
}

struct dmn_jobs *dmn_jobs_start(const struct dmn_handles *handles, void (*wake)(void *context), void *context)
{
    struct dmn_jobs *jobs = calloc(1, sizeof(*jobs));

    if (!jobs) return NULL;
    jobs->handles = handles;
    jobs->wake = wake;
    jobs->context = context;
    pthread_mutex_init(&jobs->lock, NULL);
    pthread_cond_init(&jobs->changed, NULL);
    jobs->started = !pthread_create(&jobs->thread, NULL, run, jobs);
    if (!jobs->started) {
        dmn_jobs_destroy(jobs);
        return NULL;
    }
    return jobs;
}

void dmn_jobs_destroy(struct dmn_jobs *jobs)
{
    if (!jobs) return;
    if (jobs->started) {
        pthread_mutex_lock(&jobs->lock);
        jobs->stop = true;
        pthread_cond_signal(&jobs->changed);
        pthread_mutex_unlock(&jobs->lock);
        pthread_join(jobs->thread, NULL);
    }
    pthread_cond_destroy(&jobs->changed);
    pthread_mutex_destroy(&jobs->lock);
    free(jobs);
}

bool dmn_jobs_ask(struct dmn_jobs *jobs, const struct dmn_job *job)
{
    bool room;

    pthread_mutex_lock(&jobs->lock);
    room = jobs->count < DMN_JOBS;
    if (room) {
        jobs->job[(jobs->first + jobs->count++) % DMN_JOBS] = *job;
        pthread_cond_signal(&jobs->changed);
    }
    pthread_mutex_unlock(&jobs->lock);
    return room;
}

bool dmn_jobs_take(struct dmn_jobs *jobs, struct dmn_job *out_job)
{
    bool found;

    pthread_mutex_lock(&jobs->lock);
    found = jobs->done > 0;
    if (found) {
        *out_job = jobs->job[jobs->first];
        jobs->first = (jobs->first + 1) % DMN_JOBS;
        jobs->done--;
        jobs->count--;
    }
    pthread_mutex_unlock(&jobs->lock);
    return found;
}
