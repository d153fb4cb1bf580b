/* foveactl look: point the gaze, if it comes from the pointer source. */
#include <math.h>

#include "ctl.h"

/* Wait until the daemon's gaze is there. It never is if gaze comes from another source than the pointer. */
static bool arrives(struct pro_client *client, const float direction[3])
{
    uint64_t end_ns = dmn_now_ns() + 2000000000u;
    bool there = false;

    while (!there && dmn_now_ns() < end_ns) {
        char error[PRO_ERROR_SIZE];
        Fovea__Message *message;
        enum pro_result result = pro_receive(client, 100, &message, error);

        if (result == PRO_BROKEN) return ctl_fail("%s", error);
        if (result != PRO_MESSAGE) continue;
        if (message->body_case == FOVEA__MESSAGE__BODY_GAZE) {
            const float *d = message->gaze->direction;

            there = d[0] * direction[0] + d[1] * direction[1] + d[2] * direction[2] > 0.9999f;
        }
        fovea__message__free_unpacked(message, NULL);
    }
    return there ||
           ctl_fail("the gaze stays where it is: it comes from %s", pro_welcome(client)->gaze_source);
}

static int run(const struct ctl *ctl)
{
    Fovea__Message message = FOVEA__MESSAGE__INIT;
    Fovea__Pointer pointer = FOVEA__POINTER__INIT;
    char error[PRO_ERROR_SIZE];
    struct pro_client *client;
    double angle[2];
    float direction[3];
    bool good;

    if (!dmn_parse_numbers(ctl->operand[0], 2, angle) || angle[1] < -90 || angle[1] > 90) {
        ctl_fail("look wants YAW,PITCH in degrees, not '%s'", ctl->operand[0]);
        return 2;
    }
    client = ctl_connect(ctl, FOVEA__ENCODING__ENCODING_NONE, true, false);
    if (!client) return 1;
    rnd_direction((float)(angle[0] * M_PI / 180), (float)(angle[1] * M_PI / 180), direction);
    pointer.n_direction = 3;
    pointer.direction = direction;
    message.body_case = FOVEA__MESSAGE__BODY_POINTER;
    message.pointer = &pointer;
    good = (pro_send(client, &message, error) || ctl_fail("%s", error)) && arrives(client, direction);
    pro_disconnect(client);
    return good ? 0 : 1;
}

const struct ctl_command ctl_look = {
    .name = "look",
    .operands = "YAW,PITCH",
    .summary = "point the gaze there, degrees (for fovead --gaze pointer)",
    .options = CTL_CONNECTION,
    .run = run,
};
