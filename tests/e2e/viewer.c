/* viewer ADDRESS window|headset YAW: shows a view that is turned to the right by so many degrees, 90 wide and
 * 60 high, and prints whose view steers, until its standard input ends or the daemon goes. */
#include <math.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "protocol.h"

int main(int argc, char **argv)
{
    struct pollfd input = {.fd = STDIN_FILENO, .events = POLLIN};
    Fovea__Message message = FOVEA__MESSAGE__INIT, *received;
    Fovea__Hello hello = FOVEA__HELLO__INIT;
    Fovea__View view = FOVEA__VIEW__INIT;
    char error[PRO_ERROR_SIZE] = "usage";
    enum pro_result result = PRO_MORE;
    struct pro_address address;
    struct pro_client *client;
    double yaw;

    if (argc != 4 || !pro_address_parse(argv[1], &address, error)) return fprintf(stderr, "%s\n", error), 2;
    hello.client = argv[2];
    hello.viewing = true;
    client = pro_connect(&address, &hello, 600000, false, error);
    if (!client) return fprintf(stderr, "%s\n", error), 1;
    yaw = atof(argv[3]) * M_PI / 180;
    view.n_orientation = 4;
    view.orientation = (float[4]){0, (float)-sin(yaw / 2), 0, (float)cos(yaw / 2)};
    view.fov_x = (float)(M_PI / 2);
    view.fov_y = (float)(M_PI / 3);
    view.headset = !strcmp(argv[2], "headset");
    message.body_case = FOVEA__MESSAGE__BODY_VIEW;
    message.view = &view;
    if (!pro_send(client, &message, error)) result = PRO_BROKEN;
    while (result != PRO_BROKEN && poll(&input, 1, 0) == 0) {
        result = pro_receive(client, 50, &received, error);
        if (result != PRO_MESSAGE) continue;
        if (received->body_case == FOVEA__MESSAGE__BODY_VIEWING) {
            printf("%s%s\n", received->viewing->yours ? "mine" : received->viewing->who,
                   received->viewing->headset ? " headset" : "");
            fflush(stdout);
        }
        fovea__message__free_unpacked(received, NULL);
    }
    if (result == PRO_BROKEN) fprintf(stderr, "%s\n", error);
    pro_disconnect(client);
    return result == PRO_BROKEN;
}
