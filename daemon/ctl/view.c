/* foveactl view: tell fovead what another program shows on the screen. */
#include <math.h>
#include <stdio.h>

#include "ctl.h"

/* Read yaw, pitch, width and height, in degrees. False after a line on stderr. */
static bool parse(const struct ctl *ctl, float out_orientation[4], Fovea__View *out_view)
{
    double deg[4], half[2];

    if (!dmn_parse_numbers(ctl->operand[0], 4, deg) || deg[1] < -90 || deg[1] > 90 || deg[2] <= 0 ||
        deg[2] >= 180 || deg[3] <= 0 || deg[3] >= 180)
        return ctl_fail("view wants YAW,PITCH,WIDTH,HEIGHT in degrees, not '%s'", ctl->operand[0]);
    for (int i = 0; i < 2; i++) half[i] = deg[i] * M_PI / 360;
    /* yaw to the right about Y, after pitch upwards about X */
    out_orientation[0] = (float)(cos(half[0]) * sin(half[1]));
    out_orientation[1] = (float)(-sin(half[0]) * cos(half[1]));
    out_orientation[2] = (float)(sin(half[0]) * sin(half[1]));
    out_orientation[3] = (float)(cos(half[0]) * cos(half[1]));
    out_view->orientation = out_orientation;
    out_view->n_orientation = 4;
    out_view->fov_x = (float)(deg[2] * M_PI / 180);
    out_view->fov_y = (float)(deg[3] * M_PI / 180);
    return true;
}

/* Say whose view steers whenever that changes, until the time is up, Ctrl-C, or the daemon has ended. False
 * after a line on stderr. */
static bool stay(const struct ctl *ctl, struct pro_client *client)
{
    uint64_t began_ns = dmn_now_ns();
    bool ended = false;

    while (!ctl_interrupted && !ended && (double)(dmn_now_ns() - began_ns) * 1e-9 < ctl->seconds) {
        char error[PRO_ERROR_SIZE];
        Fovea__Message *message;
        enum pro_result result = pro_receive(client, 50, &message, error);

        if (result == PRO_BROKEN) return ctl_fail("%s", error);
        if (result != PRO_MESSAGE) continue;
        if (message->body_case == FOVEA__MESSAGE__BODY_VIEWING) {
            const Fovea__Viewing *viewing = message->viewing;

            if (viewing->yours || !*viewing->who)
                puts(viewing->yours ? "this view steers" : "no view steers");
            else
                dmn_print(stdout, "the view is steered by %s\n", viewing->who);
            fflush(stdout);
        }
        ended = message->body_case == FOVEA__MESSAGE__BODY_BYE;
        fovea__message__free_unpacked(message, NULL);
    }
    return true;
}

static int run(const struct ctl *ctl)
{
    Fovea__Message message = FOVEA__MESSAGE__INIT;
    Fovea__View view = FOVEA__VIEW__INIT;
    char error[PRO_ERROR_SIZE];
    float orientation[4], screen[4];
    struct pro_client *client;
    bool good;

    if (!parse(ctl, orientation, &view)) return 2;
    for (int i = 0; i < 4; i++) screen[i] = (float)ctl->at[i];
    view.n_screen = ctl->has_at ? 4 : 0;
    view.screen = screen;
    message.body_case = FOVEA__MESSAGE__BODY_VIEW;
    message.view = &view;
    client = ctl_connect(ctl, FOVEA__ENCODING__ENCODING_NONE, false, false);
    if (!client) return 1;
    ctl_catch_signals();
    good = (pro_send(client, &message, error) || ctl_fail("%s", error)) && stay(ctl, client);
    pro_disconnect(client);
    return good ? 0 : 1;
}

const struct ctl_command ctl_view = {
    .name = "view",
    .operands = "YAW,PITCH,WIDTH,HEIGHT",
    .summary = "tell fovead which view, in degrees, a program of your own shows, until Ctrl-C",
    .options = CTL_CONNECTION "for at",
    .run = run,
};
