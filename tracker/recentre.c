/* The file that keeps the rotation of recentring: two lines of text, replaced as a whole. */
#include "tracker.h"

#include "error.h"

#include <errno.h>
#include <fcntl.h>
#include <libgen.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define MAGIC "fovead-recentre 1"

/* The new name is on the disk when its folder is. */
static bool sync_folder(const char *path)
{
    char *copy = strdup(path);
    int fd = copy ? open(dirname(copy), O_RDONLY | O_DIRECTORY | O_CLOEXEC) : -1;
    bool ok = fd >= 0 && fsync(fd) == 0;
    if (fd >= 0) close(fd);
    free(copy);
    return ok;
}

bool trk_recentre_save(const char *path, const float rotation[4], char out_error[TRK_ERROR_SIZE])
{
    char *part = NULL;
    if (asprintf(&part, "%s.%ld.part", path, (long)getpid()) < 0)
        return trk_fail(out_error, "%s: no memory", path);
    int fd = open(part, O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW | O_CLOEXEC, 0666);
    bool ok = fd >= 0;
    if (ok) {
        ok = dprintf(fd, MAGIC "\n%.9g %.9g %.9g %.9g\n", (double)rotation[0], (double)rotation[1],
                     (double)rotation[2], (double)rotation[3]) > 0 &&
             fsync(fd) == 0;
        ok = close(fd) == 0 && ok && rename(part, path) == 0 && sync_folder(path);
    }
    if (!ok) {
        trk_fail(out_error, "%s: cannot write: %s", path, strerror(errno));
        if (fd >= 0) unlink(part);
    }
    free(part);
    return ok;
}

bool trk_recentre_load(const char *path, float out_rotation[4], char out_error[TRK_ERROR_SIZE])
{
    char text[128] = "";
    int fd = open(path, O_RDONLY | O_NONBLOCK | O_CLOEXEC), end = -1;
    ssize_t length = fd < 0 ? -1 : read(fd, text, sizeof text - 1);
    if (length < 0) trk_fail(out_error, "%s: cannot read: %s", path, strerror(errno));
    if (fd >= 0) close(fd);
    if (length < 0) return false;
    float q[4];
    double norm = 0;
    int fields = sscanf(text, MAGIC "\n%f %f %f %f%n", &q[0], &q[1], &q[2], &q[3], &end);
    for (int i = 0; fields == 4 && i < 4; i++) norm += (double)q[i] * q[i];
    if (fields != 4 || end < 0 || strcmp(text + end, "\n") != 0 || !(fabs(norm - 1) < 1e-3))
        return trk_fail(out_error, "%s: expected '" MAGIC "' and a line of four numbers, a unit quaternion",
                        path);
    memcpy(out_rotation, q, sizeof q);
    return true;
}
