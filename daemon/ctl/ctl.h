/* ctl: foveactl, the command-line client. One file a command; the table of them is in foveactl.c. */
#ifndef FOVEAD_CTL_H
#define FOVEAD_CTL_H

#include "daemon.h"

/* Options; each command names the ones it takes. */
enum {
    CTL_DAEMON = 1 << 0, /* --connect, --wait */
    CTL_JSON = 1 << 1,
    CTL_FOR = 1 << 2,
    CTL_UNTIL_FINISHED = 1 << 3,
    CTL_VIEW = 1 << 4,
    CTL_SIZE = 1 << 5,
    CTL_SETTLE = 1 << 6,
    CTL_GAZE = 1 << 7,
    CTL_EXPOSURE = 1 << 8,
};

struct ctl {
    const char *command;
    unsigned given; /* CTL_* bits */
    struct pro_address address;
    bool wait, json, until_finished;
    double seconds, settle;
    bool view_gaze; /* the view's middle is the gaze */
    double view[3]; /* yaw, pitch, horizontal field of view: deg */
    int width, height;
    bool exposure_auto;
    double exposure; /* stops */
    const char *gaze;
    char **operand;
};

struct ctl_command {
    const char *name, *operands, *summary;
    int count; /* of operands */
    unsigned options;
    int (*run)(const struct ctl *ctl); /* exit status */
};

int ctl_watch(const struct ctl *ctl);
int ctl_snapshot(const struct ctl *ctl);
int ctl_stats(const struct ctl *ctl);
int ctl_freeze(const struct ctl *ctl);
int ctl_unfreeze(const struct ctl *ctl);
int ctl_look(const struct ctl *ctl);
int ctl_save(const struct ctl *ctl);
int ctl_samples(const struct ctl *ctl);

/* --- for the commands
 * ---------------------------------------------------------------------------------------- */

/* One line on stderr; returns false. */
bool ctl_fail(const char *format, ...) __attribute__((format(printf, 1, 2)));

/* Connect to the daemon. NULL after a line on stderr. */
struct pro_client *ctl_connect(const struct ctl *ctl, Fovea__Encoding tiles, bool gaze, bool stats);

/* Send a message, and wait until the daemon has acted on it. */
bool ctl_tell(struct pro_client *client, const Fovea__Message *message);

/* The next message of that kind, within seconds; others are let go. NULL after a line on stderr. */
Fovea__Message *ctl_await(struct pro_client *client, Fovea__Message__BodyCase body, double seconds);

#endif
