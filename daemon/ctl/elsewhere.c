/* foveactl's commands for pictures: they run foveactl-image, which lies beside foveactl. Only foveactl-image
 * is linked with OpenImageIO, whose many shared libraries take longer to load than most commands take to run.
 */
#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "ctl.h"

int ctl_run_elsewhere(const struct ctl *ctl)
{
    static const char name[] = "foveactl-image";
    char path[CTL_PATH_SIZE + sizeof(name)] = "";
    ssize_t length = readlink("/proc/self/exe", path, CTL_PATH_SIZE);
    char *slash = length > 0 ? strrchr(path, '/') : NULL;

    if (slash) {
        strcpy(slash + 1, name);
        execv(path, ctl->arguments);
    }
    ctl_fail("%s: %s: %s, expected it beside foveactl", ctl->command, slash ? path : name, strerror(errno));
    return 1;
}
