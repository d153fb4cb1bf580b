/* file: files that appear whole or not at all, whatever the disk does and whenever the program is killed.
 *
 * What is written goes to a file without a name in the folder of the path, or, where the file system has no
 * such files, to one called PATH.fovead-<8 hex digits>.part. It gets its name when every byte of it is on
 * the disk; a file of that name stays as it was until then. A part that a killed program left behind is
 * removed when anything is written to the same folder. */
#ifndef FOVEAD_DAEMON_FILE_H
#define FOVEAD_DAEMON_FILE_H

#include <stdbool.h>
#include <stdio.h>
#include <sys/types.h>

enum { DMN_FILE_ERROR_SIZE = 512 };

struct dmn_file {
    FILE *file; /* to write to, at any place */
    char *path;
    char *part; /* its own name */
    bool named; /* it has that name; else, as yet, none */
    bool replace;
};

/* Can a file be written there? Removes what killed programs have left in its folder. False with a line in
 * out_error: the folder cannot be written; what is there is no regular file, is being recorded, or may not
 * go. */
bool dmn_file_check(const char *path, bool replace, char out_error[DMN_FILE_ERROR_SIZE]);

/* Begin a file with this mode, but for the umask. replace: a file that is there may go. False with a line in
 * out_error, and nothing to end, on failure. */
bool dmn_file_begin(struct dmn_file *file, const char *path, mode_t mode, bool replace,
                    char out_error[DMN_FILE_ERROR_SIZE]);

/* Give it its name, once it is on the disk. False with a line in out_error if it is not whole: it is then
 * gone, and what was there before is still there. Also false if only the folder could not be synced: the new
 * file is then in its place, but may not outlast a crash of the machine. A symbolic link is replaced, not
 * followed. */
bool dmn_file_end(struct dmn_file *file, char out_error[DMN_FILE_ERROR_SIZE]);

/* The same, but leave it open for what is still to come, at its end: the descriptor, locked (flock(2)) so
 * that the file is not replaced meanwhile; the caller closes. -1 on failure. */
int dmn_file_keep(struct dmn_file *file, char out_error[DMN_FILE_ERROR_SIZE]);

/* Was all that was printed to a file written? Else errno says why not. */
bool dmn_file_is_written(FILE *file);

/* Leave it; nothing of it remains. */
void dmn_file_drop(struct dmn_file *file);

#endif
