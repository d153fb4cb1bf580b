/* foveactl move: moves the camera, and tells which generation of the picture begins, and how soon its first
 * tile came. */
#include <stdio.h>

#include "ctl.h"

/* Wait for the next tile of that generation or a newer one. False after a line on stderr. */
static bool await_tile(struct pro_client *client, uint64_t generation, uint64_t sent_ns)
{
    for (;;) {
        Fovea__Message *message = ctl_await(client, FOVEA__MESSAGE__BODY_TILE, sent_ns, CTL_PATIENCE_S);
        bool there;

        if (!message) return false;
        there = message->tile->generation >= generation;
        fovea__message__free_unpacked(message, NULL);
        if (there) return true;
    }
}

static bool tell(const struct ctl *ctl, struct pro_client *client, const Fovea__Message *message)
{
    uint64_t sent_ns = dmn_now_ns();
    char error[PRO_ERROR_SIZE];
    Fovea__Message *answer;
    bool good;

    if (!pro_send(client, message, error)) return ctl_fail("%s", error);
    if (!(answer = ctl_await(client, FOVEA__MESSAGE__BODY_DONE, sent_ns, CTL_PATIENCE_S))) return false;
    good = answer->done->ok || ctl_fail("%s", answer->done->text);
    if (good && (good = await_tile(client, answer->done->generation, dmn_now_ns()))) {
        double passed_ms = (double)(dmn_now_ns() - sent_ns) * 1e-6;

        if (ctl->json) {
            json_t *object = json_pack(
                "{s:I, s:o, s:f}", "generation", (json_int_t)answer->done->generation, "camera",
                ctl_camera_json(answer->done->camera, answer->done->n_camera), "first_tile_ms", passed_ms);

            if (object) json_dumpf(object, stdout, JSON_INDENT(2) | JSON_REAL_PRECISION(9));
            if (object) putchar('\n');
            json_decref(object);
        } else {
            dmn_print(stdout, "%s; first tile after %.1f ms\n", answer->done->text, passed_ms);
        }
    }
    fovea__message__free_unpacked(answer, NULL);
    return good;
}

static int run(const struct ctl *ctl)
{
    Fovea__Message message = FOVEA__MESSAGE__INIT;
    Fovea__Move move = FOVEA__MOVE__INIT;
    struct pro_client *client;
    double number[3];
    float camera[3] = {0};
    bool good = dmn_parse_numbers(ctl->operand[0], 3, number) && dmn_camera_is_in_range(number);

    for (int i = 0; good && i < 3; i++) camera[i] = (float)number[i];
    if (!good) {
        ctl_fail("move wants X,Y,Z in metres, each %d at most, not '%s'", DMN_FARTHEST, ctl->operand[0]);
        return 2;
    }
    /* Only the arrival of a tile counts, so the small encoding is enough. */
    client = ctl_connect(ctl, FOVEA__ENCODING__ENCODING_JPEG, false, false);
    if (!client) return 1;
    move.request = 1;
    move.n_camera = 3;
    move.camera = camera;
    move.relative = ctl->by;
    message.body_case = FOVEA__MESSAGE__BODY_MOVE;
    message.move = &move;
    good = tell(ctl, client, &message);
    pro_disconnect(client);
    return good ? 0 : 1;
}

const struct ctl_command ctl_move = {
    .name = "move",
    .operands = "X,Y,Z",
    .summary = "move the camera there, or with --by so far, metres; the picture begins anew",
    .options = CTL_CONNECTION "json by",
    .run = run,
};
