/* ctl: foveactl, the command-line client. One file a command; the table of them is in foveactl.c. */
#ifndef FOVEAD_CTL_H
#define FOVEAD_CTL_H

#include <jansson.h>

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
    CTL_STOP = 1 << 9,
    CTL_REPLACE = 1 << 10,
    CTL_PPD = 1 << 11,
    CTL_LDR = 1 << 12,
    CTL_MAP = 1 << 13,
    CTL_BY = 1 << 14,
    CTL_WITHIN = 1 << 15,
    CTL_LOG_FORMAT = 1 << 16, /* what is told about a gaze log */
    CTL_LOG_TIME_UNIT = 1 << 17,
    CTL_LOG_FRAME = 1 << 18,
    CTL_LOG_SCREEN = 1 << 19,
    CTL_LOG_RECORDING = 1 << 20,
    CTL_LOG = CTL_LOG_FORMAT | CTL_LOG_TIME_UNIT | CTL_LOG_FRAME | CTL_LOG_SCREEN | CTL_LOG_RECORDING,
};

enum { CTL_PATH_SIZE = 4096 };

/* How long a daemon may take to answer, s: a machine that does other work is slow. */
enum { CTL_PATIENCE_S = 30, CTL_START_S = 600 /* to come up, with --wait */ };

struct ctl {
    const char *command;
    unsigned given;   /* CTL_* bits */
    bool has_address; /* else the default */
    struct pro_address address;
    bool wait, json, until_finished, stop;
    double seconds, settle, within;
    bool view_gaze; /* the view's middle is the gaze */
    double view[3]; /* yaw, pitch, horizontal field of view: deg */
    int width, height;
    bool exposure_auto;
    double exposure; /* stops */
    const char *gaze;
    double ppd; /* pixels per degree */
    bool ldr;
    const char *map;
    struct trk_log_options log;
    char **operand;   /* ends with NULL */
    char **arguments; /* all, as they were given */
};

struct ctl_command {
    const char *name, *operands, *summary; /* a name may be two words */
    int count;                             /* of operands; one in brackets may be missing */
    unsigned options;
    int (*run)(const struct ctl *ctl); /* exit status */
};

int ctl_watch(const struct ctl *ctl);
int ctl_snapshot(const struct ctl *ctl);
int ctl_stats(const struct ctl *ctl);
int ctl_freeze(const struct ctl *ctl);
int ctl_unfreeze(const struct ctl *ctl);
int ctl_look(const struct ctl *ctl);
int ctl_move(const struct ctl *ctl);
int ctl_save(const struct ctl *ctl);
int ctl_record(const struct ctl *ctl);
int ctl_recentre(const struct ctl *ctl);
int ctl_samples(const struct ctl *ctl);
int ctl_compare(const struct ctl *ctl);
int ctl_gaze_info(const struct ctl *ctl);
int ctl_gaze_convert(const struct ctl *ctl);
int ctl_gaze_plot(const struct ctl *ctl);

/* --- for the commands
 * ---------------------------------------------------------------------------------------- */

/* One line on stderr; returns false. */
bool ctl_fail(const char *format, ...) __attribute__((format(printf, 1, 2)));

/* Connect to the daemon. NULL after a line on stderr. */
struct pro_client *ctl_connect(const struct ctl *ctl, Fovea__Encoding tiles, bool gaze, bool stats);

/* Send a message, and wait until the daemon has acted on it. */
bool ctl_tell(struct pro_client *client, const Fovea__Message *message);

/* The next message of that kind, within seconds of from_ns (CLOCK_MONOTONIC); others are let go. NULL after a
 * line on stderr. */
Fovea__Message *ctl_await(struct pro_client *client, Fovea__Message__BodyCase body, uint64_t from_ns,
                          double seconds);

/* Send a request and print what its Done says was done; false after the line on stderr that says why not. */
bool ctl_request(struct pro_client *client, const Fovea__Message *message, double seconds);

/* The daemon may run elsewhere, so names must be whole: the folder is made absolute, the file need not exist.
 * False after a line on stderr. */
bool ctl_make_absolute(const char *path, char out_path[CTL_PATH_SIZE]);

/* What Stats says of an eye tracker, in at least 160 bytes. */
void ctl_tracker_line(const Fovea__Tracker *tracker, char *out_line, size_t size);
/* The same; it may be NULL; a new reference. */
json_t *ctl_tracker_json(const Fovea__Tracker *tracker);

/* Where the eye is, m; null if count, of its numbers, is 0; a new reference. */
json_t *ctl_eye_json(const float *eye, size_t count);

/* Keys of the terminal, as they are pressed, from now until the end, or exit(). False if there is no
 * terminal. */
bool ctl_keys_begin(void);
void ctl_keys_end(void);
char ctl_key(void); /* '\0': none; an arrow: the letter that lies so, w, a, s or d */

/* The log that the first operand names, by what the options say of it; false after a line on stderr. The
 * caller frees it. */
bool ctl_read_log(const struct ctl *ctl, struct trk_log *out_log);

/* Degrees to the right of forward, and up from the horizon, of a direction. */
double ctl_yaw_deg(const float v[3]);
double ctl_pitch_deg(const float v[3]);

enum ctl_colours { CTL_INFERNO, CTL_MAGMA };

/* The colour of a number from 0 to 1, linear Rec.709. */
void ctl_colour(enum ctl_colours colours, float t, float out_rgb[3]);

bool ctl_ends_with(const char *text, const char *end);

#endif
