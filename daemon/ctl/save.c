/* foveactl save: the daemon writes its film to a file. */
#include <errno.h>
#include <libgen.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ctl.h"

/* The daemon may run elsewhere, so the name must be whole: the folder is made absolute, the file need not
 * exist. */
static bool make_absolute(const char *path, char out_path[PATH_MAX])
{
    char folder[PATH_MAX], name[PATH_MAX], real[PATH_MAX];

    if (strlen(path) >= PATH_MAX) return ctl_fail("%.40s...: the name is too long", path);
    strcpy(folder, path);
    strcpy(name, path);
    if (!realpath(dirname(folder), real)) return ctl_fail("%s: %s", path, strerror(errno));
    if (snprintf(out_path, PATH_MAX, "%s/%s", strcmp(real, "/") ? real : "", basename(name)) >= PATH_MAX)
        return ctl_fail("%.40s...: the name is too long", path);
    return true;
}

int ctl_save(const struct ctl *ctl)
{
    Fovea__Message message = FOVEA__MESSAGE__INIT, *answer;
    Fovea__Save save = FOVEA__SAVE__INIT;
    char path[PATH_MAX], error[PRO_ERROR_SIZE];
    struct pro_client *client;
    bool good = false;

    if (!make_absolute(ctl->operand[0], path)) return 1;
    client = ctl_connect(ctl, FOVEA__ENCODING__ENCODING_NONE, false, false);
    if (!client) return 1;
    save.request = 1;
    save.path = path;
    message.body_case = FOVEA__MESSAGE__BODY_SAVE;
    message.save = &save;
    if (!pro_send(client, &message, error)) {
        ctl_fail("%s", error);
    } else if ((answer = ctl_await(client, FOVEA__MESSAGE__BODY_DONE, 120))) {
        good = answer->done->ok;
        if (good)
            printf("%s\n", answer->done->text);
        else
            ctl_fail("%s", answer->done->text);
        fovea__message__free_unpacked(answer, NULL);
    }
    pro_disconnect(client);
    return good ? 0 : 1;
}
