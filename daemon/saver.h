/* saver: writes the film to files that clients ask for, in a thread of its own, so that the loop never waits.
 */
#ifndef FOVEAD_DAEMON_SAVER_H
#define FOVEAD_DAEMON_SAVER_H

#include "daemon.h"

enum { DMN_SAVES = 8 }; /* waiting at most */

struct dmn_save {
    unsigned client; /* who asked */
    uint32_t request;
    bool good;
    char path[1024];
    char error[RND_ERROR_SIZE];
};

struct dmn_saver;

/* wake(context) is called whenever a file is done. NULL if memory is short or no thread can be made. */
struct dmn_saver *dmn_saver_start(struct rnd_render *render, void (*wake)(void *context), void *context);
void dmn_saver_destroy(
    struct dmn_saver *saver); /* accepts NULL; the file under way is finished, others are not begun */

/* Ask for a file; false if too many wait already. */
bool dmn_saver_ask(struct dmn_saver *saver, const struct dmn_save *save);
/* The next one that is done; false if there is none. */
bool dmn_saver_take(struct dmn_saver *saver, struct dmn_save *out_save);

#endif
