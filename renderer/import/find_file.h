/* Finds the files that a scene names. Exporters often write names that differ from the files: in letter case,
 * with backslashes, or with folders of the machine that wrote them. */
#ifndef FOVEAD_RENDERER_FIND_FILE_H
#define FOVEAD_RENDERER_FIND_FILE_H

#include <stdbool.h>
#include <stddef.h>

enum { RND_PATH_SIZE = 4096 };

/* Find the file that a scene in directory ("", or with a slash at its end) calls name. Tried are: the name
 * with a slash for each backslash; the same in another letter case; and its base name beside the scene.
 * of_uri: name is a URI, so percent-encoding is undone, and of a URI that is not relative only the base name
 * is used. Only regular files are found. False if there is none; out is then the path at which it was
 * expected. */
bool rnd_find_file(const char *directory, const char *name, bool of_uri, char out[RND_PATH_SIZE]);
/* Why no file was found at the expected path: a static text. */
const char *rnd_why_not_found(const char *path);

#endif
