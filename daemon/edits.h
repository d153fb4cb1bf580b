/* edits: reads the scene again when its files change, in a thread of its own, while the picture goes on.
 *
 * An edit is a change of the scene's own file, of its environment map, or of a file with a name that the
 * scene uses (buffers, textures, material libraries) in the scene's folder or a folder inside that. After an
 * edit that could not be read, a change of any file there is one. A file may be written, or replaced by
 * renaming. The new scene is read while the old one is in use, which takes memory for both. */
#ifndef FOVEAD_DAEMON_EDITS_H
#define FOVEAD_DAEMON_EDITS_H

#include <stdio.h>

#include "paint.h"
#include "picture.h"

struct dmn_edits;

struct dmn_edits_options {
    struct dmn_painter *painter;
    struct rnd_scene **scene; /* the scene in use; only this module changes it, until dmn_edits_destroy() */
    const struct dmn_scene_words *words; /* of the scene in use */
    FILE *out;                           /* for people: what was read */
    void (*wake)(void *context);         /* called when the words have changed */
    void *context;
};

/* Watch the files from now on. What options points to must last. NULL and a line in out_error on failure. */
struct dmn_edits *dmn_edits_create(const struct rnd_scene_options *options, char out_error[RND_ERROR_SIZE]);
/* Read the scene again for every edit since dmn_edits_create(). Each prints a line to options->out, or why it
 * failed to stderr. False if memory is short or no thread can be made. */
bool dmn_edits_start(struct dmn_edits *edits, const struct dmn_edits_options *options);
/* Copy the words, if they have changed since the last call. Any thread may call this. */
void dmn_edits_words(struct dmn_edits *edits, struct dmn_scene_words *words);
/* From now on ignore edits and wake nobody. A scene that is being read is abandoned, for which this does not
 * wait. Accepts NULL. */
void dmn_edits_stop(struct dmn_edits *edits);
/* Stop, and wait for the thread. The painter must have stopped, and still exist. Accepts NULL. */
void dmn_edits_destroy(struct dmn_edits *edits);

#endif
