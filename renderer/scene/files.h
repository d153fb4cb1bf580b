/* The files that a scene's own file names: what it is made of, and what it asks for and does not find. */
#ifndef FOVEAD_RENDERER_FILES_H
#define FOVEAD_RENDERER_FILES_H

#include <stdbool.h>
#include <stddef.h>

/* Bytes of all their paths: beyond, files are not kept. */
enum { RND_MOST_FILES_BYTES = 4 << 20 };

struct rnd_files {
    char *text; /* paths, each with its NUL; NULL: none */
    size_t size;
};

/* Keep a path, once. */
void rnd_files_add(struct rnd_files *files, const char *path);
void rnd_files_finish(struct rnd_files *files);

/* Are these bytes paths, each of one byte or more and its NUL? */
bool rnd_files_are_whole(const char *text, size_t size);

#endif
