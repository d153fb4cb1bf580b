/* saver: does what clients ask for that waits for the disk, in a thread of its own, so that the loop never
 * does: the film, recordings of gaze, what recentring is kept as. */
#ifndef FOVEAD_DAEMON_SAVER_H
#define FOVEAD_DAEMON_SAVER_H

#include "gaze.h"

enum { DMN_SAVES = 8 }; /* waiting at most */

enum dmn_save_what { DMN_SAVE_FILM, DMN_SAVE_GAZE, DMN_SAVE_GAZE_END, DMN_SAVE_RECENTRE };

struct dmn_save {
    unsigned client; /* who asked */
    uint32_t request;
    enum dmn_save_what what;
    char path[1024];          /* of film or gaze */
    bool replace;             /* gaze: what path names may exist */
    bool has_target;          /* recentre: */
    float target[3];          /* unit, world */
    bool good;                /* when it is done: */
    char text[DMN_TEXT_SIZE]; /* what was done, or why not */
};

struct dmn_saver;

/* wake(context) is called whenever something is done. NULL if memory is short or no thread can be made. */
struct dmn_saver *dmn_saver_start(struct rnd_render *render, struct dmn_gaze *gaze,
                                  void (*wake)(void *context), void *context);
void dmn_saver_destroy(
    struct dmn_saver *saver); /* accepts NULL; what is under way is finished, the rest not begun */

/* Ask for it; false if too many wait already. */
bool dmn_saver_ask(struct dmn_saver *saver, const struct dmn_save *save);
/* The next one that is done; false if there is none. */
bool dmn_saver_take(struct dmn_saver *saver, struct dmn_save *out_save);

#endif
