/* The commands that read or write pictures, as foveactl has them: foveactl-image, which lies beside it, runs
 * them. OpenImageIO comes with some 250 shared libraries, which take a quarter of a second to load; so only
 * that program is linked with it. */
#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "ctl.h"

static int run_image(const struct ctl *ctl)
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

int ctl_snapshot(const struct ctl *ctl)
{
    return run_image(ctl);
}

int ctl_samples(const struct ctl *ctl)
{
    return run_image(ctl);
}

int ctl_compare(const struct ctl *ctl)
{
    return run_image(ctl);
}
