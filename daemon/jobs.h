/* jobs: what clients ask for that waits for the disk, done one after the other in a thread of its own, so
 * that the loop never waits. What kinds of job there are is in job_kinds.h. */
#ifndef FOVEAD_DAEMON_JOBS_H
#define FOVEAD_DAEMON_JOBS_H

#include "gaze.h"
#include "handles.h"

enum { DMN_JOBS = 8 }; /* waiting at most */

struct dmn_job;

struct dmn_job_kind {
    /* The jobs' thread: do it, and write what was done, or why not, to job->text. False: it was not done. */
    bool (*run)(const struct dmn_handles *handles, struct dmn_job *job);
};

struct dmn_job {
    const struct dmn_job_kind *kind;
    unsigned client; /* who asked */
    uint32_t request;
    char path[1024];          /* of the file to write */
    bool replace;             /* what path names may exist */
    bool has_target;          /* of recentring: */
    float target[3];          /* unit, world */
    bool good;                /* when it is done: */
    char text[DMN_TEXT_SIZE]; /* what was done, or why not */
};

struct dmn_jobs;

/* wake(context) is called whenever a job is done. NULL if memory is short or no thread can be made. */
struct dmn_jobs *dmn_jobs_start(const struct dmn_handles *handles, void (*wake)(void *context),
                                void *context);
/* Accepts NULL; the job under way is finished, the rest is not begun. */
void dmn_jobs_destroy(struct dmn_jobs *jobs);

/* Ask for a job; false if too many wait already. */
bool dmn_jobs_ask(struct dmn_jobs *jobs, const struct dmn_job *job);
/* The next job that is done; false if there is none. */
bool dmn_jobs_take(struct dmn_jobs *jobs, struct dmn_job *out_job);

#endif
