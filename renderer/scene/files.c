/* The files that a scene's own file names. */
#include "scene/files.h"

#include <stdlib.h>
#include <string.h>

void rnd_files_add(struct rnd_files *files, const char *path)
{
    const size_t length = strlen(path) + 1;
    for (size_t at = 0; at < files->size; at += strlen(files->text + at) + 1)
        if (strcmp(files->text + at, path) == 0) return;
    if (length == 1 || length > RND_MOST_FILES_BYTES - files->size) return;
    char *text = realloc(files->text, files->size + length);
    if (!text) return;
    memcpy(text + files->size, path, length);
    files->text = text;
    files->size += length;
}

void rnd_files_finish(struct rnd_files *files)
{
    free(files->text);
    *files = (struct rnd_files){0};
}

bool rnd_files_are_whole(const char *text, size_t size)
{
    if (size > RND_MOST_FILES_BYTES || (size > 0 && (text[0] == 0 || text[size - 1] != 0))) return false;
    return size < 2 || !memmem(text, size, "\0", 2);
}
