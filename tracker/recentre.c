/* The file that keeps the rotation of recentring: two lines of text. */
#include "tracker.h"

#include "error.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#define MAGIC "fovead-recentre 1"

void trk_recentre_print(const float rotation[4], FILE *file)
{
    fprintf(file, MAGIC "\n%.9g %.9g %.9g %.9g\n", (double)rotation[0], (double)rotation[1],
            (double)rotation[2], (double)rotation[3]);
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
