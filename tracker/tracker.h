/* tracker: where the eyes look.
 *
 * A source delivers gaze samples. It is an eye tracker on HID or USB, a recorded log, a synthetic observer,
 * or a pointer that a client moves. The attention decides from the samples what to render for. This folder
 * knows nothing of pixels or sockets.
 *
 * Conventions
 * - Frames follow OpenXR and glTF: right-handed, +X right, +Y up, -Z forward; metres, radians; quaternions
 *   are (x, y, z, w). A source converts the frame of its device to this one.
 * - Gaze directions and origins are in the head frame. The head pose takes head to world. A source without
 *   a head pose leaves TRK_HEAD unset, and head and world are then the same frame.
 * - Time is nanoseconds of CLOCK_MONOTONIC, or of the virtual clock (which starts at 0). A sample also keeps
 *   the time of the device's own clock, unwrapped; the two are never mixed.
 * - An error is one line of text in a caller's buffer of TRK_ERROR_SIZE bytes, without a trailing newline. It
 *   names the file and line (or the option) and what was expected.
 * - Threads: one thread at a time uses a source, but any thread may call trk_push(), trk_interrupt() and
 *   trk_get_status() while another one reads. */
#ifndef FOVEAD_TRACKER_H
#define FOVEAD_TRACKER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

enum { TRK_ERROR_SIZE = 512 };

/* Which fields of a sample are valid. A field whose bit is unset has no meaning. */
enum {
    TRK_DIRECTION = 1 << 0,      /* combined gaze direction */
    TRK_ORIGIN = 1 << 1,         /* combined gaze origin */
    TRK_HEAD = 1 << 2,           /* head pose */
    TRK_SCREEN = 1 << 3,         /* the point on a screen that the eyes look at */
    TRK_LEFT_DIRECTION = 1 << 4, /* the right eye's bits are the left eye's shifted by 4 */
    TRK_LEFT_ORIGIN = 1 << 5,
    TRK_LEFT_OPENNESS = 1 << 6,
    TRK_LEFT_PUPIL = 1 << 7,
    TRK_RIGHT_DIRECTION = 1 << 8,
    TRK_RIGHT_ORIGIN = 1 << 9,
    TRK_RIGHT_OPENNESS = 1 << 10,
    TRK_RIGHT_PUPIL = 1 << 11,
};

struct trk_eye {
    float direction[3]; /* unit, head frame */
    float origin[3];    /* m, head frame */
    float openness;     /* 0 closed .. 1 open */
    float pupil_mm;     /* diameter */
};

struct trk_sample {
    uint64_t sequence;     /* counts the samples of a source from 1; a gap is a lost sample */
    uint64_t device_ns;    /* the device's own clock, unwrapped; 0 is the log's or session's first sample */
    uint64_t arrival_ns;   /* when the sample reached us: CLOCK_MONOTONIC or virtual time */
    uint32_t valid;        /* TRK_* bits */
    float direction[3];    /* unit, head frame */
    float origin[3];       /* m, head frame */
    struct trk_eye eye[2]; /* left, right */
    float head[7];         /* position x y z (m), orientation x y z w: head to world */
    float screen[2];       /* share of the screen's width and height, from its top left corner */
    /* When the device took the sample, on the clock of arrival_ns: device_ns mapped to that clock. It is late
     * by the smallest delay between device and arrival, which nobody can measure, and never after arrival_ns.
     * 0 if the source has no device clock. */
    uint64_t sensor_ns;
};

/* The gaze of a sample, in the head frame (unit): the combined direction if the sample has one, else the mean
 * of the eyes whose lids are up, else the direction of the only such eye. This is the one rule of what a
 * valid gaze is: a sample for which it returns true steers, and is reported as valid. It returns false, and
 * leaves out_head alone, if there is no direction, or if the lids are down: a device may then report the eye
 * that rolls under its lid. out_source, which may be NULL, says whose direction it is: "both eyes", "left
 * eye" or "right eye" (static). */
bool trk_gaze_direction(const struct trk_sample *sample, float out_head[3], const char **out_source);

/* The same in the world frame: turned by the head pose if the sample has one. */
bool trk_world_direction(const struct trk_sample *sample, float out_world[3]);

/* For gaze at a screen. Its head pose says where the head is before the screen, and nothing of what the
 * screen shows. Turn the sample's directions by the head pose, into the frame in which the screen is straight
 * ahead, and drop the pose, and the origins. */
void trk_drop_head(struct trk_sample *sample);

/* --- views --- */

/* What somebody is shown: a view into the panorama, and where it is on the screen. */
struct trk_view {
    float orientation[4]; /* x y z w, view to world; unit */
    float fov[2];         /* horizontal and vertical field of view, rad, above 0 and below pi */
    float screen[4];      /* left, top, width and height, shares of the screen's from its top left corner */
};

/* The direction (unit, world) that a view shows at a point of the screen (shares of its width and height,
 * from its top left corner). False, with out_world left alone, if the point is beside the view. */
bool trk_view_direction(const struct trk_view *view, const float point[2], float out_world[3]);

/* --- logs --- */

/* A recorded log. All its samples are in memory, packed; trk_log_sample() unpacks one. They are in the order
 * of device_ns, which never goes back. Their arrival_ns is the time of the host that recorded them, where the
 * format has it; else it equals device_ns. */
enum { TRK_ASSUMED_SIZE = 1024, TRK_MAX_SOURCES = 32 };

struct trk_samples;

struct trk_log {
    const char *format;             /* name of the format that it was read as (static) */
    size_t count;                   /* of samples */
    struct trk_samples *samples;    /* owned by the log; NULL if there are none */
    char assumed[TRK_ASSUMED_SIZE]; /* what the reader took for granted: one line, "; " between; or "" */
    /* The files that it was read from: st_dev and st_ino of stat(). They must not be overwritten. */
    struct {
        uint64_t device, inode;
    } sources[TRK_MAX_SOURCES];
    size_t source_count;
};

/* What a log does not say of itself, or says wrongly. All zero: read the log as it is. */
struct trk_log_options {
    const char *format;    /* "fovead", "sranipal", "eyelink", ...; NULL: recognise it by the content */
    const char *time_unit; /* "s", "ms", "us" or "ns": of the log's own times */
    /* Where +X, +Y and +Z of the log's gaze (not of its head pose) point: three letters, of L or R, U or D, F
     * or B. "RUF" is Unity's frame, "LUF" HTC's and Tobii's, "RDF" a camera's, "RUB" ours. */
    const char *frame;
    /* Of a log in screen coordinates: the screen's width and distance, or the angle that it spans across. */
    double screen_width_m, screen_distance_m;
    double screen_fov_deg;
    /* Which of several recordings in a file: its name, its participant, or PARTICIPANT/NAME. */
    const char *recording;
};

/* Read a log of any known format, which is recognised by what the file begins with. gzip is unpacked; "-" is
 * standard input. On failure returns false with a line in out_error and leaves *out_log empty. These are
 * refused: what is not a regular file; a file without rows; a header that is unknown or fits several formats;
 * several recordings in one file; time or sequence that goes back; a clock that stands still; infinite
 * numbers; directions that should be of unit length and are not; more than 64 Mi rows, 104 days, or 2 GiB
 * unpacked. A last row that was cut off is left out, and assumed says so. Samples in which the tracker lost
 * the eyes are in the log, without a direction. The caller frees with trk_log_finish(). */
bool trk_log_read(const char *path, struct trk_log *out_log, char out_error[TRK_ERROR_SIZE]);

/* The same with options, which need to live only during the call. Options that are impossible, or that the
 * format has no use for, are refused. */
bool trk_log_read_with(const char *path, const struct trk_log_options *options, struct trk_log *out_log,
                       char out_error[TRK_ERROR_SIZE]);

/* Write a whole file in the project's own format (log/own.h). Only ferror(file) tells whether that failed. */
void trk_log_print(const struct trk_log *log, FILE *file);

/* Write BIDS eye tracking (log/bids_write.c): the table, in gzip, and its sidecar. False with a line in
 * out_error, which names no file. */
bool trk_log_print_bids(const struct trk_log *log, FILE *table, FILE *sidecar,
                        char out_error[TRK_ERROR_SIZE]);

/* Was the log read from that file, whatever its name was then? */
bool trk_log_is_from(const struct trk_log *log, const char *path);

/* Sample i, from 0 to log->count - 1, as it was recorded; fields whose valid bit is unset are 0. Several
 * threads may read the same log. */
void trk_log_sample(const struct trk_log *log, size_t i, struct trk_sample *out_sample);

/* device_ns of sample i. */
uint64_t trk_log_time(const struct trk_log *log, size_t i);

/* The TRK_* bits that at least one sample has. */
uint32_t trk_log_seen(const struct trk_log *log);

#define TRK_GAP_STEPS 2.5 /* a gap is longer than this many steps */

/* How fast samples follow each other in a log, without its gaps, which are pauses of the recording and
 * losses. */
struct trk_rate {
    double hz;          /* 0: there are fewer than two samples, or no time passes */
    uint64_t step_ns;   /* mean of the steps that are not gaps */
    uint64_t median_ns; /* of all steps: says little where they are uneven */
    /* Steps of more than TRK_GAP_STEPS times step_ns that short steps beside them do not offset. */
    size_t gaps;
    uint64_t longest_ns; /* of the gaps */
    bool in_bursts;      /* all the time, several samples come at once */
};

void trk_log_rate(const struct trk_log *log, struct trk_rate *out_rate);

/* Is the step from sample i - 1 to sample i a gap? i is at least 1. */
bool trk_log_is_gap(const struct trk_log *log, const struct trk_rate *rate, size_t i);

void trk_log_finish(struct trk_log *log);

/* --- sources --- */

struct trk_source;

/* A kind of gaze source, and what it can do. */
struct trk_source_kind {
    const char *name;       /* what trk_source_options.spec begins with */
    const char *usage;      /* how a user writes it: NAME, NAME:ARGUMENT or NAME[:ARGUMENT] */
    const char *summary;    /* what it is, for --help */
    bool is_device;         /* it is, or can become, an eye tracker that is plugged in */
    bool takes_screen;      /* trk_source_options.screen is for it */
    bool takes_calibration; /* trk_source_options.calibration is for it */
    bool follows_eye;       /* its samples are those of an eye, not of a hand that points */
    bool rests_when_silent; /* it sends samples only while gaze moves: silence is no loss */
    bool needs_real_clock;  /* its samples come from outside, in real time */
    bool ends;              /* it comes to an end, unless trk_source_options.loop is set */
    bool waits_after_end;   /* after TRK_END it waits for an eye tracker: read on */
};

/* The kind at index, from 0; NULL after the last one. Static. */
const struct trk_source_kind *trk_source_kind_at(size_t index);
/* The kind that a spec names; NULL if there is none. Static. */
const struct trk_source_kind *trk_source_kind_find(const char *spec);

/* The screen of an eye tracker that stands on a desk; 0 is unknown. */
struct trk_screen {
    float width_m, height_m; /* of the calibrated area */
    float distance_m;        /* from the eyes to the middle of the screen */
};

struct trk_source_options {
    const char *spec; /* NAME or NAME:ARGUMENT of a kind */
    /* Replaces what the device says of its screen. What is unknown here and there is taken from a usual desk:
     * 0.531 x 0.299 m (24 inches) at 0.65 m. Sizes from 0.01 to 20 m. */
    struct trk_screen screen;
    /* A file with the user's calibration, which the device gave out once and which is sent back to it; NULL:
     * none. */
    const char *calibration;
    const char *fallback_log; /* auto: the log to replay while no device is present */
    /* replay: pace relative to the log's own timestamps: 1 is real time, 2 is twice as fast, 0 is as fast as
     * the log is read. Else from 0.01 to 1000. */
    double speed;
    bool loop; /* replay: start again at the end; device_ns goes on */
    /* Time is what the reader says it is (until_ns of trk_read()), and no read waits. */
    bool virtual_clock;
};

enum trk_result {
    TRK_SAMPLE,  /* *out_sample holds the next sample */
    TRK_TIMEOUT, /* no sample came until until_ns, or trk_interrupt() was called */
    TRK_END,     /* the source has ended */
    TRK_FAILED,  /* the source is broken: one line in out_error */
};

/* Open a source. NULL and a line in out_error on failure. The caller closes it with trk_close().
 *
 * A thread of its own reads a device. The source waits for a device that is absent, and searches again for
 * one that was unplugged: reads then time out. When a device goes or falls silent, one sample without a
 * direction says that gaze was lost. Time and sequence go on when the device is plugged in again. A device
 * that is present and cannot be opened is an error, which says what to do.
 *
 * auto takes the first device that opens. If there is none, it replays fallback_log until a device is plugged
 * in and sees an eye; from then on all samples are the device's. If the log ends before that, trk_read()
 * returns TRK_END once; read on to wait for a device. On the virtual clock there are no devices. */
struct trk_source *trk_open(const struct trk_source_options *options, char out_error[TRK_ERROR_SIZE]);
void trk_close(struct trk_source *source); /* accepts NULL */

/* What a source is doing. */
struct trk_status {
    /* One line on what the source is, for example "replay of fixtures/hall.gaze: 2400 samples, 20.0 s, 120
     * Hz, head pose (no eye tracker found)". For a device: which one it is, or what it waits for, and why. */
    char description[TRK_ERROR_SIZE];
    unsigned changes;     /* how often description has changed */
    double speed;         /* of device_ns relative to arrival_ns: 1, or a replay's pace; 0: it has no pace */
    bool is_device;       /* the samples come from an eye tracker; the rest is of it */
    bool present;         /* it is plugged in and open */
    unsigned connections; /* how often it was opened */
    uint64_t losses;      /* how often it fell silent or went */
    double rate_hz;       /* of its latest samples; 0 is unknown */
    bool has_clock;       /* it stamps its samples; then: */
    double jitter_ms;     /* standard deviation of their delay */
    double drift_ppm;     /* how much faster than ours its clock runs */
    bool on_screen;       /* gaze is at a screen: trk_drop_head() */
};

/* Any thread may call this while another one reads. */
void trk_get_status(struct trk_source *source, struct trk_status *out_status);

/* An eye tracker that is plugged in. */
struct trk_device_info {
    char source[288];             /* its trk_source_options.spec */
    char name[160];               /* maker and product, and their numbers as in udev rules */
    char abilities[256];          /* what it can do; "" if only an open device tells that */
    char problem[TRK_ERROR_SIZE]; /* why it cannot be opened, and what to do; "": it can be opened */
};

/* List the eye trackers that are plugged in. Fills up to room of out_devices; returns how many there are.
 * Takes some tens of milliseconds. Any thread may call this. */
size_t trk_list(struct trk_device_info *out_devices, size_t room);

/* Take the next sample. With the real clock, waits until a sample arrives or CLOCK_MONOTONIC reaches
 * until_ns. With the virtual clock, returns at once: the next sample whose time is at or before until_ns,
 * else TRK_TIMEOUT. The clock of a replay or synthetic observer starts at the first call. Their arrival_ns is
 * when a sample was due, however late the reader is; without pace (speed 0) it is when the sample was read.
 */
enum trk_result trk_read(struct trk_source *source, uint64_t until_ns, struct trk_sample *out_sample,
                         char out_error[TRK_ERROR_SIZE]);

/* Give a gaze direction (world frame, of any length) to a source that takes one, as pointer does, at time_ns.
 * False, with no effect, if the source takes none, or if the direction is not finite or zero. Directions are
 * delivered in the order in which they came. When the reader is more than 1024 behind, the oldest are
 * dropped, and their sequence numbers with them. A time before the last one counts as the last one. */
bool trk_push(struct trk_source *source, const float direction[3], uint64_t time_ns);

/* Ask the system to run the calling thread soon after it is woken, even while other threads compute. This is
 * for a thread that mostly waits for gaze or messages and passes them on. It needs no privilege. A system
 * that does not know it (Linux before 6.12) changes nothing. */
void trk_be_prompt(void);

/* Wake a trk_read() that waits in another thread: it returns TRK_TIMEOUT. If none waits, the next one that
 * would wait returns TRK_TIMEOUT at once. */
void trk_interrupt(struct trk_source *source);

/* Make the log of a synthetic observer: seconds long at 120 Hz; its format is "synthetic". False when memory
 * is short, or if seconds hold no sample or more than a log may. The caller frees with trk_log_finish(). */
bool trk_synthesise(uint64_t seed, double seconds, struct trk_log *out_log);

/* --- what the eye does --- */

enum trk_state {
    TRK_FIXATION, /* gaze rests in the world, even if the head turns */
    TRK_PURSUIT,  /* gaze moves smoothly */
    TRK_SACCADE,  /* gaze jumps */
    TRK_BLINK, /* the lids are down or have just opened, or no eye is seen for as long as a blink may take */
    TRK_LOST,  /* no eye is seen */
    TRK_FALLBACK, /* no gaze yet, or the last one is so old that the view's centre is the better guess */
    TRK_FROZEN,   /* a user has frozen the aim */
};

/* "fixation", "pursuit", ...: one word in lower case. */
const char *trk_state_name(enum trk_state state);

struct trk_event {
    enum trk_state type;       /* TRK_FIXATION to TRK_LOST */
    uint64_t start_ns, end_ns; /* device time of its first and last sample */
    size_t first, last;        /* indices of those samples in the log */
    float direction[3]; /* world, unit: the mean of a fixation, else the gaze at the end of the event */
};

struct trk_events {
    size_t count;
    struct trk_event *events;    /* count of them, in order of time, without overlap; owned by this struct */
    size_t counts[TRK_LOST + 1]; /* of each type */
    double noise_deg;            /* standard deviation of each axis of the gaze while it rests */
};

/* Find the events of a log with the classifier of trk_attend(): fixations of at least 100 ms, saccades,
 * pursuits, blinks (the lid is down, or no eye is seen for 75 to 900 ms) and losses. Gaps shorter than 75 ms
 * are bridged. A blink includes the 75 ms before it and the 150 ms after it. False when memory is short. The
 * caller frees with trk_events_finish(). */
bool trk_events_find(const struct trk_log *log, struct trk_events *out_events);
void trk_events_finish(struct trk_events *events);

/* --- from gaze to aim --- */

struct trk_attention;

struct trk_attention_options {
    bool raw;             /* no filter and no dead zone: aim at the gaze as measured */
    bool predict;         /* during a saccade, aim at where it will land */
    bool silence_is_rest; /* trk_source_kind.rests_when_silent */
};

/* What to render for. */
struct trk_aim {
    uint64_t sequence;                         /* of the newest sample that it answers; 0 before the first */
    uint64_t device_ns, sensor_ns, arrival_ns; /* of that sample */
    uint64_t time_ns;                          /* now_ns of the call that decided it */
    float direction[3];                        /* unit, world */
    float spread;                              /* how many times wider than usual the fovea is: 1 to 4 */
    enum trk_state state;                      /* what the eye does */
    const char *source; /* what the direction was made from: "both eyes", "left eye", "right eye",
                         * "prediction", "last gaze", "view centre" (static) */
    const char *why;    /* a few words on the decision (static) */
    bool moved;         /* this call changed direction or spread */
    float noise_deg;    /* of the tracker: standard deviation of each axis, measured while gaze rests */
};

/* NULL when memory is short. The caller frees with trk_attention_destroy(), which accepts NULL. One thread at
 * a time uses an attention. */
struct trk_attention *trk_attention_create(const struct trk_attention_options *options);
void trk_attention_destroy(struct trk_attention *attention);

/* Decide what to render for. Call this with every sample, in order. While no sample comes, call it with NULL
 * every 50 ms or so; otherwise nobody notices silence. now_ns is on the clock of arrival_ns and never goes
 * back. The same calls give the same aims. Takes no lock and allocates nothing. */
void trk_attend(struct trk_attention *attention, const struct trk_sample *sample_or_null, uint64_t now_ns,
                struct trk_aim *out_aim);

/* While frozen, the aim stays where it is, whatever the eye does. */
void trk_attention_freeze(struct trk_attention *attention, bool frozen);

/* How fast device_ns goes relative to now_ns (trk_status.speed): 1 to begin with; 0: samples have no pace. */
void trk_attention_pace(struct trk_attention *attention, double speed);

/* The view that is shown now; NULL: none is known. Its centre is used while samples have no head pose.
 *
 * Gaze at a screen (TRK_SCREEN) goes through it: the aim is the direction that the view shows at that point.
 * The eye's movements are those on the screen: when the view turns, the aim turns with it, and that is no
 * saccade. While the eye looks beside the view, the aim stays where it was in the view. Without a view, gaze
 * at a screen is what trk_gaze_direction() tells: the screen is then a window into the world, seen at its
 * true angle. */
void trk_attention_view(struct trk_attention *attention, const struct trk_view *view_or_null);

/* --- recentring --- */

/* Correct the gaze of a headset that has slipped: the eyes look at target now (unit, world; NULL: the view's
 * centre). From now on all gaze is turned, in the head frame, by the rotation that takes the measured gaze
 * there. Gaze at a screen is turned in the screen's frame instead, before it goes through the view. It
 * replaces the former rotation. False with a line in out_error, and nothing is changed, if gaze does not
 * rest, if gaze goes through a view that does not show the target, or if the rotation would be larger than 20
 * degrees. */
bool trk_recentre(struct trk_attention *attention, const float *target_or_null,
                  char out_error[TRK_ERROR_SIZE]);
/* The rotation in use (x, y, z, w), identity without one. */
void trk_recentre_get(const struct trk_attention *attention, float out_rotation[4]);
/* Use this rotation. False, with no effect, if it is not a unit quaternion of at most 20 degrees. */
bool trk_recentre_set(struct trk_attention *attention, const float rotation[4]);

/* Write the file that keeps the rotation. Only ferror(file) tells whether that failed. */
void trk_recentre_print(const float rotation[4], FILE *file);
/* Read it. False with a line in out_error. */
bool trk_recentre_load(const char *path, float out_rotation[4], char out_error[TRK_ERROR_SIZE]);

/* --- recording --- */

struct trk_recorder;

struct trk_recorder_status {
    uint64_t written; /* samples in the file */
    uint64_t lost;    /* samples that the disk did not take, or that came while the queue was full */
    uint64_t refused; /* samples that no log can hold: time or sequence goes back, no unit direction */
    bool failing;     /* the last write failed; the recorder goes on trying */
    char error[TRK_ERROR_SIZE]; /* why the last failed write failed; "": none has failed */
};

/* Write what a file must hold before the recorder appends to it. */
void trk_recorder_print_head(FILE *file);

/* Record samples in the project's own log format (log/own.h) at the end of a regular file. fd is open for
 * writing and belongs to the recorder from now on, even on failure; path is for messages. Every sample is in
 * the file within a tenth of a second, and on the disk within a second or so; after a crash trk_log_read()
 * reads what there is. When the disk takes no more, the recorder keeps trying: up to 4096 samples wait
 * meanwhile, and those beyond are lost. NULL and a line in out_error on failure. */
struct trk_recorder *trk_recorder_start(int fd, const char *path, char out_error[TRK_ERROR_SIZE]);

/* Record a sample. Never waits for the disk, for a thread of the recorder's own writes. Any thread may call
 * this. */
void trk_recorder_append(struct trk_recorder *recorder, const struct trk_sample *sample);

void trk_recorder_get_status(struct trk_recorder *recorder, struct trk_recorder_status *out_status);

/* Write to the disk what is left, and free. False if samples were lost; out_status, which may be NULL, says
 * how many, and why. Accepts a recorder of NULL, and then leaves out_status alone. */
bool trk_recorder_close(struct trk_recorder *recorder, struct trk_recorder_status *out_status);

#endif
