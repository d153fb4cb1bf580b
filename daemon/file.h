/* file: files that appear whole or not at all, whatever the disk does and whenever the program is killed.
 *
 * Bytes are written to a file without a name in the folder of the path or, where the file system has no such
 * files, to a part: PATH.fovead-<8 hex digits>.part. The file gets its name once all bytes are on the disk;
 * until then an older file of that name stays as it was. A part that a killed program has left is removed
 * when a file is next written to the same folder. */
#ifndef FOVEAD_DAEMON_FILE_H
#define FOVEAD_DAEMON_FILE_H

#include <stdbool.h>
#include <stdio.h>
#include <sys/types.h>

enum { DMN_FILE_ERROR_SIZE = 512 };

struct dmn_file {
    FILE *file; /* to write to, at any place */
    char *path;
    char *part; /* name of the part */
    bool named; /* the file has the name in part; else it has no name yet */
    bool replace;
};

/* Can a file be written there? Removes parts that killed programs have left in its folder. False with a line
 * in out_error if the folder cannot be written, or if what is there is not a regular file, is being recorded,
 * or may not be replaced. */
bool dmn_file_check(const char *path, bool replace, char out_error[DMN_FILE_ERROR_SIZE]);

/* Begin a file with this mode, less the umask. replace: an existing file may be replaced. False with a line
 * in out_error on failure; dmn_file_end() is then not called. */
bool dmn_file_begin(struct dmn_file *file, const char *path, mode_t mode, bool replace,
                    char out_error[DMN_FILE_ERROR_SIZE]);

/* Give the file its name, once it is on the disk. False with a line in out_error if it is not whole: it is
 * then removed, and the former file stays. Also false if only the folder could not be synced: the new file is
 * then there, but may be lost if the machine crashes. A symbolic link is replaced, not followed. */
bool dmn_file_end(struct dmn_file *file, char out_error[DMN_FILE_ERROR_SIZE]);

/* The same, but keep the file open to append to it. Returns the descriptor, locked with flock(2) so that the
 * file is not replaced meanwhile; the caller closes it. -1 on failure. */
int dmn_file_keep(struct dmn_file *file, char out_error[DMN_FILE_ERROR_SIZE]);

/* Was all that was printed to a file written? Else errno says why not. */
bool dmn_file_is_written(FILE *file);

/* Abandon the file, and remove what was written. */
void dmn_file_drop(struct dmn_file *file);

#endif
