/* Files that a scene names. What exporters write is often not quite what lies beside the scene: another
 * letter case, back slashes, folders of the machine that it was made on. */
#ifndef FOVEAD_RENDERER_FIND_FILE_H
#define FOVEAD_RENDERER_FIND_FILE_H

#include <stdbool.h>
#include <stddef.h>

enum { RND_PATH_SIZE = 4096 };

/* The file that a scene in directory ("", or with a slash at its end) calls name: as it is written, with a
 * slash for each backslash, then in another letter case, then its base name beside the scene. of_uri: name is
 * a URI: percent-encoding is undone, and only the base name counts of a URI that is not relative. Only
 * regular files are found. If there is none, out is where it was expected, and the result is false. */
bool rnd_find_file(const char *directory, const char *name, bool of_uri, char out[RND_PATH_SIZE]);
/* Why there is none where it was expected: a static text. */
const char *rnd_why_not_found(const char *path);

#endif
