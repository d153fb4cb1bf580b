/* jobs: what waits for the disk: requests of clients, and fovead's own saves. A thread of their own does one
 * after the other, so that the loop never waits. job_kinds.h has the kinds of job. */
#ifndef FOVEAD_DAEMON_JOBS_H
#define FOVEAD_DAEMON_JOBS_H

#include <limits.h>

#include "gaze.h"
#include "handles.h"

enum { DMN_JOBS = 8 }; /* waiting at most */

struct dmn_job;

struct dmn_job_kind {
    /* Do the job, in the jobs' thread, and write into job->text what was done, or why not. False if it was
     * not done. */
    bool (*run)(const struct dmn_handles *handles, struct dmn_job *job);
};

struct dmn_job {
    const struct dmn_job_kind *kind;
    unsigned client; /* number of the client that asked; 0: fovead itself */
    uint32_t request;
    char path[PATH_MAX];          /* of the file to write */
    struct rnd_exposure exposure; /* of a picture for displays */
    bool replace;                 /* an existing file may be replaced */
    bool has_target;              /* of recentring; else the view's centre: */
    float target[3];              /* unit, world */
    bool good;                    /* once the job is done: */
    char text[DMN_TEXT_SIZE];     /* what was done, or why not */
};

struct dmn_jobs;

/* Calls wake(context) after every job. NULL if memory is short or no thread can be made. */
struct dmn_jobs *dmn_jobs_start(const struct dmn_handles *handles, void (*wake)(void *context),
                                void *context);
/* Finish the job under way, and begin no other. Accepts NULL. */
void dmn_jobs_destroy(struct dmn_jobs *jobs);

/* Ask for a job; false if too many wait already. */
bool dmn_jobs_ask(struct dmn_jobs *jobs, const struct dmn_job *job);
/* The next job that is done; false if there is none. */
bool dmn_jobs_take(struct dmn_jobs *jobs, struct dmn_job *out_job);

#endif
