/* job_kinds: the kinds of job that clients ask for. */
#ifndef FOVEAD_DAEMON_JOB_KINDS_H
#define FOVEAD_DAEMON_JOB_KINDS_H

#include "jobs.h"

extern const struct dmn_job_kind dmn_job_save;       /* write the film to path */
extern const struct dmn_job_kind dmn_job_record;     /* record gaze samples to path from now on */
extern const struct dmn_job_kind dmn_job_record_end; /* end the recording */
extern const struct dmn_job_kind dmn_job_recentre;   /* turn all gaze so that it is at target, and keep the
                                                        rotation */

#endif
