/* ctl: foveactl, the command-line client. One file per command. */
#ifndef FOVEAD_CTL_H
#define FOVEAD_CTL_H

#include <jansson.h>

#include "daemon.h"

enum { CTL_PATH_SIZE = 4096 };

/* How long a daemon may take to answer, s: a machine that does other work is slow. */
enum { CTL_PATIENCE_S = 30, CTL_START_S = 600 /* to come up, with --wait */ };

/* What a command line says. */
struct ctl {
    const char *command; /* its name */
    bool has_address;    /* else the default */
    struct pro_address address;
    bool wait, json, until_finished, stop, replace, by, ldr;
    double seconds; /* of --for; infinite: not given */
    double settle, within;
    bool has_view, view_gaze; /* view_gaze: the view's middle is the gaze */
    double view[3];           /* yaw, pitch, horizontal field of view: deg */
    int width, height;
    bool exposure_auto;
    double exposure; /* stops */
    const char *gaze;
    double ppd; /* pixels per degree */
    const char *map;
    struct trk_log_options log;
    char **operand;   /* ends with NULL */
    char **arguments; /* all, as they were given */
};

/* A command is one file, which ends with its row, and one line here, where --help lists them in this order.
 */
#define CTL_COMMANDS(ROW)                                                                                    \
    ROW(ctl_watch)                                                                                           \
    ROW(ctl_snapshot)                                                                                        \
    ROW(ctl_stats)                                                                                           \
    ROW(ctl_freeze)                                                                                          \
    ROW(ctl_unfreeze)                                                                                        \
    ROW(ctl_look)                                                                                            \
    ROW(ctl_move)                                                                                            \
    ROW(ctl_save)                                                                                            \
    ROW(ctl_record)                                                                                          \
    ROW(ctl_recentre)                                                                                        \
    ROW(ctl_samples)                                                                                         \
    ROW(ctl_compare)                                                                                         \
    ROW(ctl_gaze_info)                                                                                       \
    ROW(ctl_gaze_convert)                                                                                    \
    ROW(ctl_gaze_plot)

struct ctl_command {
    const char *name;     /* may be two words */
    const char *operands; /* as --help calls them, one word each; one in brackets may be missing */
    const char *summary;
    const char *options;               /* names of the options that it takes, with blanks between them */
    int (*run)(const struct ctl *ctl); /* exit status */
};

#define CTL_DECLARE(command) extern const struct ctl_command command;
CTL_COMMANDS(CTL_DECLARE)

/* Options of every command that connects to the daemon, and of every command that reads a gaze log. */
#define CTL_CONNECTION "connect wait "
#define CTL_LOG        "format time-unit frame screen recording "

/* How the row of a command that needs OpenImageIO names its function. The file is compiled twice: whole for
 * foveactl-image; and for foveactl, which has the row alone, and runs foveactl-image instead (elsewhere.c).
 */
#ifdef CTL_ELSEWHERE
int ctl_run_elsewhere(const struct ctl *ctl);
#define CTL_NEEDS_IMAGES(run) ctl_run_elsewhere
#else
#define CTL_NEEDS_IMAGES(run) run
#endif

/* --- for the commands --- */

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

/* Where the camera is, m; null if count, of its numbers, is 0; a new reference. */
json_t *ctl_camera_json(const float *camera, size_t count);

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
