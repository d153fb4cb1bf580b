/* The kinds of job. */
#include "job_kinds.h"
#include "save.h"

static bool save(const struct dmn_handles *handles, struct dmn_job *job)
{
    char error[RND_ERROR_SIZE];
    bool good = dmn_save_film(handles->render, job->path, &job->exposure, error);

    snprintf(job->text, sizeof(job->text), good ? "wrote %.900s" : "%.900s", good ? job->path : error);
    return good;
}

static bool record(const struct dmn_handles *handles, struct dmn_job *job)
{
    return dmn_gaze_record(handles->gaze, job->path, job->replace, job->text);
}

static bool record_end(const struct dmn_handles *handles, struct dmn_job *job)
{
    return dmn_gaze_record(handles->gaze, NULL, false, job->text);
}

static bool recentre(const struct dmn_handles *handles, struct dmn_job *job)
{
    return dmn_gaze_recentre(handles->gaze, job->has_target ? job->target : NULL, job->text);
}

const struct dmn_job_kind dmn_job_save = {save};
const struct dmn_job_kind dmn_job_record = {record};
const struct dmn_job_kind dmn_job_record_end = {record_end};
const struct dmn_job_kind dmn_job_recentre = {recentre};
