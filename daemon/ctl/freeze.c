/* foveactl freeze, unfreeze: keep sampling where the gaze is now, or follow it again. */
#include "ctl.h"

static int tell(const struct ctl *ctl, bool frozen)
{
    Fovea__Message message = FOVEA__MESSAGE__INIT;
    Fovea__Freeze freeze = FOVEA__FREEZE__INIT;
    struct pro_client *client = ctl_connect(ctl, FOVEA__ENCODING__ENCODING_NONE, false, false);
    bool good;

    if (!client) return 1;
    freeze.frozen = frozen;
    message.body_case = FOVEA__MESSAGE__BODY_FREEZE;
    message.freeze = &freeze;
    good = ctl_tell(client, &message);
    pro_disconnect(client);
    return good ? 0 : 1;
}

static int freeze(const struct ctl *ctl)
{
    return tell(ctl, true);
}

static int unfreeze(const struct ctl *ctl)
{
    return tell(ctl, false);
}

const struct ctl_command ctl_freeze = {
    .name = "freeze",
    .operands = "",
    .summary = "keep sampling where the gaze is now",
    .options = CTL_CONNECTION,
    .run = freeze,
};

const struct ctl_command ctl_unfreeze = {
    .name = "unfreeze",
    .operands = "",
    .summary = "follow the gaze again",
    .options = CTL_CONNECTION,
    .run = unfreeze,
};
