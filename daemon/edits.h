/* edits: takes up edits of the scene's files in a thread of its own, while the picture goes on.
 *
 * A change of the scene's own file counts, of its environment map, and of any file in the scene's folder or
 * the folders in that which has the name of one that the scene names, as the renderer tells: buffers,
 * textures, material libraries. As long as an edit could not be taken any file there counts. Files that are
 * replaced by renaming count as those that are written. The scene is read beside the one in use, so meanwhile
 * there is memory for two. */
#ifndef FOVEAD_DAEMON_EDITS_H
#define FOVEAD_DAEMON_EDITS_H

#include <stdio.h>

#include "paint.h"
#include "picture.h"

struct dmn_edits;

struct dmn_edits_options {
    struct dmn_painter *painter;
    struct rnd_scene **scene; /* the one in use, until dmn_edits_destroy() to be changed here alone */
    const struct dmn_scene_words *words; /* of it */
    FILE *out;                           /* for people: what was read */
    void (*wake)(void *context);         /* called when there are new words */
    void *context;
};

/* Watch the files from now on. What options points to must last. NULL and a line in out_error on failure. */
struct dmn_edits *dmn_edits_create(const struct rnd_scene_options *options, char out_error[RND_ERROR_SIZE]);
/* Read the scene again for every edit since then, with a line in options->out, or why not on stderr. False if
 * memory is short or no thread can be made. */
bool dmn_edits_start(struct dmn_edits *edits, const struct dmn_edits_options *options);
/* Any thread: the words, if they are new. */
void dmn_edits_words(struct dmn_edits *edits, struct dmn_scene_words *words);
/* Take up no more, and wake nobody any more; a scene that is being read is let go, which this does not wait
 * for. Accepts NULL. */
void dmn_edits_stop(struct dmn_edits *edits);
/* Accepts NULL; stops, and waits. The painter must have stopped, and still be there. */
void dmn_edits_destroy(struct dmn_edits *edits);

#endif
