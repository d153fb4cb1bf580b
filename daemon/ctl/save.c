/* foveactl save: has the daemon write its film to a file. */
#include <errno.h>
#include <libgen.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ctl.h"

bool ctl_make_absolute(const char *path, char out_path[CTL_PATH_SIZE])
{
    char folder[CTL_PATH_SIZE], name[CTL_PATH_SIZE], real[PATH_MAX];

    if (strlen(path) >= CTL_PATH_SIZE) return ctl_fail("%.40s...: the name is too long", path);
    strcpy(folder, path);
    strcpy(name, path);
    if (!realpath(dirname(folder), real)) return ctl_fail("%s: %s", path, strerror(errno));
    if (snprintf(out_path, CTL_PATH_SIZE, "%s/%s", strcmp(real, "/") ? real : "", basename(name)) >=
        CTL_PATH_SIZE)
        return ctl_fail("%.40s...: the name is too long", path);
    return true;
}

static int run(const struct ctl *ctl)
{
    Fovea__Message message = FOVEA__MESSAGE__INIT;
    Fovea__Save save = FOVEA__SAVE__INIT;
    char path[CTL_PATH_SIZE];
    struct pro_client *client;
    bool good;

    if (!ctl_make_absolute(ctl->operand[0], path)) return 1;
    client = ctl_connect(ctl, FOVEA__ENCODING__ENCODING_NONE, false, false);
    if (!client) return 1;
    save.request = 1;
    save.path = path;
    save.exposure = (float)ctl->exposure.stops;
    save.exposure_auto = ctl->exposure.automatic;
    message.body_case = FOVEA__MESSAGE__BODY_SAVE;
    message.save = &save;
    good = ctl_request(client, &message, 120);
    pro_disconnect(client);
    return good ? 0 : 1;
}

const struct ctl_command ctl_save = {
    .name = "save",
    .operands = "FILE",
    .summary = "have the daemon write the film: an .exr with all its channels, or a .png or .jpg",
    .options = CTL_CONNECTION "exposure",
    .run = run,
};
