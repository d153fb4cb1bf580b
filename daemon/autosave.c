/* Saves of the film at intervals, by the thread that does jobs. */
#include <stdio.h>
#include <string.h>

#include "autosave.h"
#include "job_kinds.h"
#include "options.h"
#include "paint.h"

static void ask(struct dmn_autosave *autosave, const struct dmn_handles *handles)
{
    struct dmn_job job = {.kind = &dmn_job_save, .exposure = handles->options->exposure};

    /* dmn_file_check() has refused longer paths. */
    snprintf(job.path, sizeof(job.path), "%s", handles->options->save);
    autosave->under_way = dmn_jobs_ask(handles->jobs, &job);
}

void dmn_autosave_tick(struct dmn_autosave *autosave, const struct dmn_handles *handles)
{
    const uint64_t now_ns = dmn_now_ns(), every_ns = (uint64_t)(handles->options->save_every * 1e9);
    struct dmn_work work;

    if (!autosave->next_ns) autosave->next_ns = now_ns + every_ns;
    if (now_ns < autosave->next_ns) return;
    dmn_painter_work(handles->painter, &work);
    /* An empty picture must not replace the last one. */
    if (!autosave->under_way && work.paths) ask(autosave, handles);
    autosave->next_ns += (now_ns - autosave->next_ns) / every_ns * every_ns + every_ns;
}

void dmn_autosave_done(struct dmn_autosave *autosave, const struct dmn_job *job)
{
    autosave->under_way = false;
    if (!job->good && !autosave->fails)
        dmn_print(stderr, "fovead: %s; rendering goes on, and fovead tries again at the next interval\n",
                  job->text);
    if (job->good && autosave->fails) dmn_print(stderr, "fovead: the film is saved again: %s\n", job->text);
    autosave->fails = !job->good;
}
