/* foveactl snapshot: saves the picture as a client has it, as a panorama or a view into it. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <jansson.h>

#include "ctl.h"
#include "image.h"
#include "image_options.h"

/* How often to check how much of the picture has come. */
static const uint64_t CHECK_NS = 50000000;

struct snapshot {
    const struct ctl *ctl;
    struct pro_client *client;
    bool has_gaze;
    float gaze[3];
    uint64_t tiles, generation;
    double coverage;
};

/* Receive until the picture is whole, then --settle seconds longer for finer tiles. If the picture begins
 * anew meanwhile, because the camera moves, the seconds still count from the first whole picture; after them
 * the next whole picture is taken. */
static bool gather(struct snapshot *snapshot)
{
    const struct ctl *ctl = snapshot->ctl;
    uint64_t began_ns = dmn_now_ns(), checked_ns = 0, first_ns = 0;
    bool whole = false;

    for (;;) {
        char error[PRO_ERROR_SIZE];
        Fovea__Message *message;
        enum pro_result result = pro_receive(snapshot->client, 50, &message, error);
        uint64_t now_ns = dmn_now_ns();

        /* A whole picture is kept even if the daemon has ended. */
        if (result == PRO_BROKEN) return whole || ctl_fail("%s", error);
        if (result == PRO_MESSAGE && message->body_case == FOVEA__MESSAGE__BODY_TILE) {
            snapshot->tiles++;
            /* The old picture is gone: the camera has moved, or the scene was edited. */
            if (message->tile->generation > snapshot->generation) {
                snapshot->generation = message->tile->generation;
                whole = false;
                checked_ns = 0;
            }
        }
        /* Before the first gaze sample there is an aim, but no gaze. */
        if (result == PRO_MESSAGE && message->body_case == FOVEA__MESSAGE__BODY_GAZE &&
            message->gaze->sequence) {
            memcpy(snapshot->gaze, message->gaze->n_aim ? message->gaze->aim : message->gaze->direction,
                   sizeof(snapshot->gaze));
            snapshot->has_gaze = true;
        }
        if (result == PRO_MESSAGE) fovea__message__free_unpacked(message, NULL);
        if (!whole && now_ns - checked_ns >= CHECK_NS) {
            snapshot->coverage = pro_picture_coverage(pro_picture(snapshot->client));
            checked_ns = now_ns;
            whole = snapshot->coverage >= 1;
            if (whole && !first_ns) first_ns = now_ns;
        }
        if (whole && (double)(now_ns - first_ns) * 1e-9 >= ctl->settle) return true;
        if (!whole && (double)(now_ns - began_ns) * 1e-9 >= ctl->within + (first_ns ? ctl->settle : 0))
            return ctl_fail("after %.0f s only %.0f %% of the picture is there",
                            (double)(now_ns - began_ns) * 1e-9, snapshot->coverage * 100);
    }
}

static bool write_panorama(const struct snapshot *snapshot, const float *rgb)
{
    const Fovea__Welcome *film = pro_welcome(snapshot->client);
    char error[RND_ERROR_SIZE];

    return dmn_image_write(snapshot->ctl->operand[0], 0666, (int)film->width, (int)film->height, rgb, true,
                           error) ||
           ctl_fail("%s", error);
}

static bool write_view(const struct snapshot *snapshot, const float *rgb, const double view[3])
{
    const Fovea__Welcome *film = pro_welcome(snapshot->client);
    const struct ctl *ctl = snapshot->ctl;
    float *pixels = malloc((size_t)ctl->width * (size_t)ctl->height * 3 * sizeof(*pixels));
    struct rnd_view shown = {
        .fov_x = (float)(view[2] * M_PI / 180), .width = ctl->width, .height = ctl->height};
    float direction[3];
    char error[RND_ERROR_SIZE];
    bool good;

    rnd_direction((float)(view[0] * M_PI / 180), (float)(view[1] * M_PI / 180), direction);
    dmn_orientation(direction, shown.orientation);
    good = (pixels && rnd_image_view(rgb, (int)film->width, (int)film->height, &shown, pixels)) ||
           ctl_fail("out of memory");
    good = good && (dmn_image_write(ctl->operand[0], 0666, ctl->width, ctl->height, pixels, false, error) ||
                    ctl_fail("%s", error));
    free(pixels);
    return good;
}

static void tell(const struct snapshot *snapshot, const double view[3])
{
    const Fovea__Welcome *film = pro_welcome(snapshot->client);
    const struct ctl *ctl = snapshot->ctl;
    bool is_view = ctl->has_view;
    int width = is_view ? ctl->width : (int)film->width, height = is_view ? ctl->height : (int)film->height;
    json_t *object;

    if (!ctl->json) {
        dmn_print(stdout, "%s: %dx%d, ", ctl->operand[0], width, height);
        if (is_view)
            printf("%.1f degrees right and %.1f up, %.4g wide\n", view[0], view[1], view[2]);
        else
            printf("panorama\n");
        return;
    }
    object = json_pack("{s:s, s:[i,i], s:I}", "file", ctl->operand[0], "size", width, height, "tiles",
                       (json_int_t)snapshot->tiles);
    if (is_view) json_object_set_new(object, "view_deg", json_pack("[f,f,f]", view[0], view[1], view[2]));
    if (object) json_dumpf(object, stdout, JSON_INDENT(2) | JSON_REAL_PRECISION(9));
    if (object) putchar('\n');
    json_decref(object);
}

static bool make(struct snapshot *snapshot)
{
    const struct ctl *ctl = snapshot->ctl;
    const Fovea__Welcome *film = pro_welcome(snapshot->client);
    double view[3] = {ctl->view[0], ctl->view[1], ctl->view[2]};
    float *rgb;
    bool good;

    if (!gather(snapshot)) return false;
    if (ctl->view_gaze && !snapshot->has_gaze) return ctl_fail("there is no gaze to look along");
    if (ctl->view_gaze) dmn_angles(snapshot->gaze, &view[0], &view[1]);
    rgb = malloc((size_t)film->width * film->height * 3 * sizeof(*rgb));
    if (!rgb) return ctl_fail("out of memory");
    pro_picture_resolve(pro_picture(snapshot->client), rgb);
    if (!dmn_image_is_exr(ctl->operand[0]))
        rnd_expose(&ctl->exposure, rgb, (int)film->width, (int)film->height);
    good = ctl->has_view ? write_view(snapshot, rgb, view) : write_panorama(snapshot, rgb);
    if (good) tell(snapshot, view);
    free(rgb);
    return good;
}

static int run(const struct ctl *ctl)
{
    struct snapshot snapshot = {.ctl = ctl};
    bool good;

    if (!ctl_is_picture(ctl, ctl->operand[0])) return 2;
    snapshot.client = ctl_connect(ctl, FOVEA__ENCODING__ENCODING_HALF_ZSTD, ctl->view_gaze, false);
    if (!snapshot.client) return 1;
    good = make(&snapshot);
    pro_disconnect(snapshot.client);
    return good ? 0 : 1;
}

const struct ctl_command ctl_snapshot = {
    .name = "snapshot",
    .operands = "FILE",
    .summary = "save the picture as received: .exr, .png or .jpg; the panorama, or a --view",
    .options = CTL_CONNECTION "json view size exposure settle within",
    .run = CTL_NEEDS_IMAGES(run),
};
