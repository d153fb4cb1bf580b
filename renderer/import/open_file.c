/* Opening what a scene names. */
#include "import/open_file.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* What kind of file it is, as text; NULL if it is regular. */
static const char *other_kind(mode_t mode)
{
    if (S_ISREG(mode)) return NULL;
    return S_ISDIR(mode)    ? "is a directory, expected a regular file"
           : S_ISFIFO(mode) ? "is a pipe, expected a regular file"
           : S_ISSOCK(mode) ? "is a socket, expected a regular file"
                            : "is a device, expected a regular file";
}

FILE *rnd_open_file(const char *path, const char **out_why)
{
    struct stat status;
    FILE *file = NULL;
    /* Do not even open a file that is not regular: opening one can have effects. */
    if (stat(path, &status) != 0) return *out_why = strerrordesc_np(errno), NULL;
    if ((*out_why = other_kind(status.st_mode))) return NULL;
    const int fd = open(path, O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
    if (fd < 0) return *out_why = strerrordesc_np(errno), NULL;
    /* The path may name another file by now. */
    if (fstat(fd, &status) != 0)
        *out_why = strerrordesc_np(errno);
    else if (!(*out_why = other_kind(status.st_mode)) && !(file = fdopen(fd, "rb")))
        *out_why = strerrordesc_np(errno);
    if (!file) close(fd);
    return file;
}

const char *rnd_why_closed(const char *path)
{
    const char *why = NULL;
    FILE *file = rnd_open_file(path, &why);
    if (file) fclose(file);
    return why;
}
