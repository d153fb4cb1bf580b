/* ctl: foveactl, the command-line client. One file per command. */
#ifndef FOVEAD_CTL_H
#define FOVEAD_CTL_H

#include <signal.h>

#include <jansson.h>

#include "daemon.h"

enum { CTL_PATH_SIZE = 4096 };

/* How long a daemon may take to answer, s: a machine that does other work is slow. */
enum { CTL_PATIENCE_S = 30, CTL_START_S = 600 /* for the daemon to start, with --wait */ };

/* What a command line says. */
struct ctl {
    const char *command; /* its name */
    bool has_address;    /* false: the default address */
    struct pro_address address;
    bool wait, json, until_finished, stop, replace, by, ldr;
    double seconds; /* of --for; infinite: not given */
    double settle, within;
    bool has_view, view_gaze; /* view_gaze: the view's middle is the gaze */
    double view[3];           /* yaw, pitch, horizontal field of view: deg */
    bool has_at;
    double at[4]; /* left, top, width and height of the view, shares of the screen's */
    int width, height;
    struct rnd_exposure exposure;
    const char *gaze;
    double ppd; /* pixels per degree */
    const char *map;
    struct trk_log_options log;
    char **operand;   /* ends with NULL */
    char **arguments; /* all, as they were given */
};

/* The commands, in the order of --help. A command is one file, which ends with its row, and one line here. */
#define CTL_COMMANDS(ROW)                                                                                    \
    ROW(ctl_watch)                                                                                           \
    ROW(ctl_snapshot)                                                                                        \
    ROW(ctl_stats)                                                                                           \
    ROW(ctl_freeze)                                                                                          \
    ROW(ctl_unfreeze)                                                                                        \
    ROW(ctl_look)                                                                                            \
    ROW(ctl_view)                                                                                            \
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

/* The function of a command that needs OpenImageIO, in its row. The file is compiled twice: whole, for
 * foveactl-image; and only the row, for foveactl, which runs foveactl-image instead (elsewhere.c). */
#ifdef CTL_ELSEWHERE
int ctl_run_elsewhere(const struct ctl *ctl);
#define CTL_NEEDS_IMAGES(run) ctl_run_elsewhere
#else
#define CTL_NEEDS_IMAGES(run) run
#endif

/* --- for the commands --- */

/* One line on stderr; returns false. */
bool ctl_fail(const char *format, ...) __attribute__((format(printf, 1, 2)));

/* Does the path of a picture end so that its format is known? False after a line on stderr. */
bool ctl_is_picture(const struct ctl *ctl, const char *path);

/* Connect to the daemon. NULL after a line on stderr. */
struct pro_client *ctl_connect(const struct ctl *ctl, Fovea__Encoding tiles, bool gaze, bool stats);

/* Send a message, and wait until the daemon has acted on it. */
bool ctl_tell(struct pro_client *client, const Fovea__Message *message);

/* Wait for the next message of that kind, up to seconds after from_ns (CLOCK_MONOTONIC); other messages are
 * dropped. NULL after a line on stderr. */
Fovea__Message *ctl_await(struct pro_client *client, Fovea__Message__BodyCase body, uint64_t from_ns,
                          double seconds);

/* Send a request, and print the text of its Done. False after a line on stderr if it was not done. */
bool ctl_request(struct pro_client *client, const Fovea__Message *message, double seconds);

/* From this call on SIGINT, SIGTERM and SIGHUP only set ctl_interrupted, so that the command can end in
 * order. */
void ctl_catch_signals(void);
extern volatile sig_atomic_t ctl_interrupted; /* the number of the signal; 0: none has come */

/* Make a path absolute, since the daemon may run in another folder. The file need not exist. False after a
 * line on stderr. */
bool ctl_make_absolute(const char *path, char out_path[CTL_PATH_SIZE]);

/* Write what Stats tells of an eye tracker, as text; out_line has at least 160 bytes. */
void ctl_tracker_line(const Fovea__Tracker *tracker, char *out_line, size_t size);
/* The same as JSON; tracker may be NULL. Returns a new reference. */
json_t *ctl_tracker_json(const Fovea__Tracker *tracker);

/* The position of the camera (m) as JSON; null if count is 0. Returns a new reference. */
json_t *ctl_camera_json(const float *camera, size_t count);

/* Read the terminal's keys as they are pressed, from now until ctl_keys_end() or exit(). False if there is no
 * terminal. */
bool ctl_keys_begin(void);
void ctl_keys_end(void);
char ctl_key(void); /* '\0': no key; an arrow becomes w, a, s or d */

/* Read the log that the first operand names, with the options. False after a line on stderr. The caller frees
 * the log. */
bool ctl_read_log(const struct ctl *ctl, struct trk_log *out_log);

/* Degrees to the right of forward, and up from the horizon, of a direction. */
double ctl_yaw_deg(const float v[3]);
double ctl_pitch_deg(const float v[3]);

enum ctl_colours { CTL_INFERNO, CTL_MAGMA };

/* The colour of a number from 0 to 1, linear Rec.709. */
void ctl_colour(enum ctl_colours colours, float t, float out_rgb[3]);

bool ctl_ends_with(const char *text, const char *end);

#endif
