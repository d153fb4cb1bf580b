/* Opening files that a scene names: it never waits, and takes only regular files. */
#ifndef FOVEAD_RENDERER_OPEN_FILE_H
#define FOVEAD_RENDERER_OPEN_FILE_H

#include <stdbool.h>
#include <stdio.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Open a file to read its bytes; the caller closes it. NULL, with a static text in *out_why, if it is not
 * there, cannot be read, or is not a regular file: a pipe would make the reader wait, and a device may have
 * no end. */
FILE *rnd_open_file(const char *path, const char **out_why);
/* Why a file cannot be opened: a static text; NULL if it can. */
const char *rnd_why_closed(const char *path);

#ifdef __cplusplus
}
#endif
#endif
