/* Opening what a scene names, whatever that is: never waits, and takes regular files alone. */
#ifndef FOVEAD_RENDERER_OPEN_FILE_H
#define FOVEAD_RENDERER_OPEN_FILE_H

#include <stdbool.h>
#include <stdio.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Open a file to read its bytes. NULL, and *out_why is a static text, if it is not there, cannot be read, or
 * is no regular file: a pipe would make the reader wait, and a device may have no end. The caller closes. */
FILE *rnd_open_file(const char *path, const char **out_why);
/* Why it cannot be opened: a static text, or NULL if it can. */
const char *rnd_why_closed(const char *path);

#ifdef __cplusplus
}
#endif
#endif
