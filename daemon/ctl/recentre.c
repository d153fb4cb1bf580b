/* foveactl recentre: tells the daemon that the eyes look at the view's centre, or in a given direction, now;
 * all gaze is turned accordingly. */
#include <math.h>

#include "ctl.h"

static int run(const struct ctl *ctl)
{
    Fovea__Message message = FOVEA__MESSAGE__INIT;
    Fovea__Recentre recentre = FOVEA__RECENTRE__INIT;
    struct pro_client *client;
    float direction[3];
    double angle[2];
    bool good;

    if (ctl->operand[0]) {
        if (!dmn_parse_numbers(ctl->operand[0], 2, angle) || angle[1] < -90 || angle[1] > 90) {
            ctl_fail("recentre wants YAW,PITCH in degrees, not '%s'", ctl->operand[0]);
            return 2;
        }
        rnd_direction((float)(angle[0] * M_PI / 180), (float)(angle[1] * M_PI / 180), direction);
        recentre.n_direction = 3;
        recentre.direction = direction;
    }
    client = ctl_connect(ctl, FOVEA__ENCODING__ENCODING_NONE, false, false);
    if (!client) return 1;
    recentre.request = 1;
    message.body_case = FOVEA__MESSAGE__BODY_RECENTRE;
    message.recentre = &recentre;
    good = ctl_request(client, &message, CTL_PATIENCE_S);
    pro_disconnect(client);
    return good ? 0 : 1;
}

const struct ctl_command ctl_recentre = {
    .name = "recentre",
    .operands = "[YAW,PITCH]",
    .summary =
        "tell that the eye looks there now, or at the view's centre, so that all gaze is turned accordingly",
    .options = CTL_CONNECTION,
    .run = run,
};
