/* autosave: the film is saved at intervals, while fovead goes on (--save-every). All of it is for the loop's
 * thread. */
#ifndef FOVEAD_DAEMON_AUTOSAVE_H
#define FOVEAD_DAEMON_AUTOSAVE_H

#include "jobs.h"

struct dmn_autosave {
    uint64_t next_ns; /* when the film is saved next; 0 at the start */
    bool under_way;
    bool fails; /* the last save failed, and people were told so */
};

/* Ask for a save if it is due. If the save before is still under way, this one is left out, so that saves do
 * not pile up. */
void dmn_autosave_tick(struct dmn_autosave *autosave, const struct dmn_handles *handles);

/* Such a save is done: tell people of the first one that fails, and of the first that succeeds after it. */
void dmn_autosave_done(struct dmn_autosave *autosave, const struct dmn_job *job);

#endif
