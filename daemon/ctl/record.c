/* foveactl record: has the daemon record the gaze samples as they come from the source. */
#include <math.h>

#include "ctl.h"

static bool request(struct pro_client *client, bool on, const char *path, bool replace)
{
    Fovea__Message message = FOVEA__MESSAGE__INIT;
    Fovea__Record record = FOVEA__RECORD__INIT;

    record.request = 1;
    record.on = on;
    record.path = (char *)path;
    record.replace = replace;
    message.body_case = FOVEA__MESSAGE__BODY_RECORD;
    message.record = &record;
    return ctl_request(client, &message, CTL_PATIENCE_S);
}

/* Tell at once that the recording fails. The daemon goes on trying. */
static void tell(const Fovea__Stats *stats, bool *told)
{
    if (*stats->recording_error && !*told)
        ctl_fail("%s; %llu samples are lost", stats->recording_error,
                 (unsigned long long)stats->recording_lost);
    *told |= *stats->recording_error;
}

/* Wait until the time is up, or for Ctrl-C. */
static bool wait_for(struct pro_client *client, double seconds)
{
    uint64_t end_ns = dmn_now_ns() + (uint64_t)(seconds * 1e9);
    char error[PRO_ERROR_SIZE];
    bool told = false;

    while (!ctl_interrupted && dmn_now_ns() < end_ns) {
        uint64_t left_ms = (end_ns - dmn_now_ns()) / 1000000 + 1;
        Fovea__Message *message;
        enum pro_result result = pro_receive(client, left_ms < 50 ? (int)left_ms : 50, &message, error);

        if (result == PRO_BROKEN) return ctl_fail("%s", error);
        if (result == PRO_MESSAGE && message->body_case == FOVEA__MESSAGE__BODY_STATS)
            tell(message->stats, &told);
        if (result == PRO_MESSAGE) fovea__message__free_unpacked(message, NULL);
    }
    return true;
}

static int run(const struct ctl *ctl)
{
    const char *file = ctl->operand[0];
    char path[CTL_PATH_SIZE] = "";
    struct pro_client *client;
    bool good;

    if (!file == !ctl->stop) {
        ctl_fail("usage: foveactl record FILE [--for SECONDS] [--replace], or foveactl record --stop");
        return 2;
    }
    if (file && !ctl_make_absolute(file, path)) return 1;
    client = ctl_connect(ctl, FOVEA__ENCODING__ENCODING_NONE, false, isfinite(ctl->seconds));
    if (!client) return 1;
    if (isfinite(ctl->seconds)) ctl_catch_signals();
    good = request(client, !ctl->stop, path, ctl->replace);
    if (good && isfinite(ctl->seconds))
        good = wait_for(client, ctl->seconds) && request(client, false, "", false);
    pro_disconnect(client);
    return good ? 0 : 1;
}

const struct ctl_command ctl_record = {
    .name = "record",
    .operands = "[FILE]",
    .summary = "have the daemon record the gaze samples as a log, until record --stop",
    .options = CTL_CONNECTION "for stop replace",
    .run = run,
};
