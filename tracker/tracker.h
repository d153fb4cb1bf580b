/* tracker: where the eye looks.
 *
 * A source delivers gaze samples: an eye tracker on HID or USB, a recorded log, a synthetic observer, a
 * pointer moved by a client. This folder knows nothing of pixels or sockets.
 *
 * Conventions
 * - Frames follow OpenXR and glTF: right-handed, +X right, +Y up, -Z forward; metres, radians; quaternions
 *   are (x, y, z, w). A source converts its device's frame before anything leaves it.
 * - Gaze directions and origins are in the head frame. The head pose takes head to world. A source without
 *   a head pose leaves TRK_HEAD unset, and head and world are then the same frame.
 * - Time is nanoseconds of CLOCK_MONOTONIC, or of the virtual clock (which starts at 0). The device's own
 *   clock is kept beside it, unwrapped, and never mixed with it.
 * - Errors are one line of text in a caller's buffer of TRK_ERROR_SIZE bytes, without a trailing newline,
 *   that names the file and line (or the option) and what was expected.
 * - Threads: a source belongs to one thread at a time, except trk_push() and trk_interrupt(), which any
 *   thread may call while another one reads. */
#ifndef FOVEAD_TRACKER_H
#define FOVEAD_TRACKER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

enum { TRK_ERROR_SIZE = 512 };

/* What a sample really carries; a field whose bit is unset holds nothing of meaning. */
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
    /* When the device took it, on the clock of arrival_ns: device time mapped, late by the least delay there
     * is, never after arrival_ns. 0 if the source has no device clock. */
    uint64_t sensor_ns;
};

/* Where a sample's eyes look, in the head (unit): the combined direction if there is one, else the mean of
 * both eyes, else that of one eye whose lid is not down. Only a sample for which this is true has a gaze,
 * that steers and is reported as valid. False, with out_head left alone, if there is no direction, or if the
 * lids are down: what a device reports then is the eye that rolls under its lid. out_source, which may be
 * NULL, tells whose direction it is: "both eyes", "left eye", "right eye"; static. */
bool trk_gaze_direction(const struct trk_sample *sample, float out_head[3], const char **out_source);

/* The same in the world: turned by the head pose if there is one. */
bool trk_world_direction(const struct trk_sample *sample, float out_world[3]);

/* --- logs ----------------------------------------------------------------------------------------------- */

/* A recorded log, whole in memory, where its samples are packed: trk_log_sample() reads them. They are
 * ordered by device_ns, which never goes back. arrival_ns of a log's samples is the time of the recording's
 * own host clock where the format has one, else equal to device_ns. */
enum { TRK_ASSUMED_SIZE = 1024, TRK_MAX_SOURCES = 32 };

struct trk_samples;

struct trk_log {
    const char *format;             /* name of the format it was read as: static storage */
    size_t count;                   /* of samples */
    struct trk_samples *samples;    /* owned by the log; NULL if there are none */
    char assumed[TRK_ASSUMED_SIZE]; /* what the reader took for granted, one line, "; " between; may be "" */
    /* The files that it was read from, which are not written over: stat()'s st_dev and st_ino. */
    struct {
        uint64_t device, inode;
    } sources[TRK_MAX_SOURCES];
    size_t source_count;
};

/* What a log does not say of itself, or says wrongly. Zero or NULL everywhere is what trk_log_read() does. */
struct trk_log_options {
    const char *format;    /* "fovead", "sranipal", "eyelink", ... instead of telling it by the content */
    const char *time_unit; /* "s", "ms", "us" or "ns": of the log's own times */
    /* Where the log's +X, +Y and +Z point: three letters, of L or R, U or D, F or B; "RUF" is Unity's frame,
     * "LUF" HTC's and Tobii's, "RDF" a camera's, "RUB" ours. Of the gaze, not of a head pose. */
    const char *frame;
    /* The screen of a log in screen coordinates: its width and distance, or its angle across. */
    double screen_width_m, screen_distance_m;
    double screen_fov_deg;
    /* Which one, where a file holds several recordings: its name, or its participant's, or PARTICIPANT/NAME.
     */
    const char *recording;
};

/* Read a log of any known format, told by what it begins with; gzip is unpacked; "-" is standard input. On
 * failure returns false with a line in out_error and leaves *out_log empty. Refused: what is no regular file,
 * no rows, a header that is unknown or may be of several formats, several recordings, time or sequence going
 * back, a clock that stands, infinite numbers, directions that are not of unit length where they should be,
 * more than 64 Mi rows or 104 days, more than 2 GiB unpacked. A last row that was cut off is left out, with a
 * word in assumed. Samples that the tracker lost are in the log, without a direction. The caller frees with
 * trk_log_finish(). */
bool trk_log_read(const char *path, struct trk_log *out_log, char out_error[TRK_ERROR_SIZE]);

/* The same, helped by options, which need to live only during the call. Options that are impossible, or that
 * this format has no use for, are refused. */
bool trk_log_read_with(const char *path, const struct trk_log_options *options, struct trk_log *out_log,
                       char out_error[TRK_ERROR_SIZE]);

/* Write a log in the project's own format (log/own.h), from the beginning of a file. What could not be
 * written is told by ferror(file) alone. */
void trk_log_print(const struct trk_log *log, FILE *file);

/* The same as BIDS eye tracking (log/bids_write.c): a table, in gzip, and the sidecar that belongs to it.
 * False with a line in out_error, which names no file. */
bool trk_log_print_bids(const struct trk_log *log, FILE *table, FILE *sidecar,
                        char out_error[TRK_ERROR_SIZE]);

/* Was the log read from that file, by whatever name? */
bool trk_log_is_from(const struct trk_log *log, const char *path);

/* Sample i, from 0, of log->count: just as it was recorded, and 0 in fields whose valid bit is unset. Several
 * threads may read the same log. */
void trk_log_sample(const struct trk_log *log, size_t i, struct trk_sample *out_sample);

/* Its device_ns alone. */
uint64_t trk_log_time(const struct trk_log *log, size_t i);

/* The TRK_* bits that any sample has. */
uint32_t trk_log_seen(const struct trk_log *log);

#define TRK_GAP_STEPS 2.5 /* a gap is longer than this many steps */

/* How fast samples follow each other in a log, apart from its gaps: pauses of the recording and losses. */
struct trk_rate {
    double hz;          /* 0: there are no two samples, or no time passes */
    uint64_t step_ns;   /* the mean of the steps that are no gaps */
    uint64_t middle_ns; /* the middle one of all steps: where they are uneven it says little */
    size_t gaps; /* steps of more than TRK_GAP_STEPS times step_ns for which the steps beside them do not make
                    up */
    uint64_t longest_ns; /* of the gaps */
    bool in_bursts;      /* samples come several at once, all the time */
};

void trk_log_rate(const struct trk_log *log, struct trk_rate *out_rate);

/* Is the step to sample i, from 1, a gap? */
bool trk_log_is_gap(const struct trk_log *log, const struct trk_rate *rate, size_t i);

void trk_log_finish(struct trk_log *log);

/* --- sources -------------------------------------------------------------------------------------------- */

struct trk_source;

/* A kind of gaze source, and what it can do. */
struct trk_source_kind {
    const char *name;       /* what trk_source_options.spec says, before the colon if it has one */
    const char *usage;      /* how a user writes it: NAME, NAME:ARGUMENT or NAME[:ARGUMENT] */
    const char *summary;    /* what it is, for --help */
    bool is_device;         /* it is an eye tracker that is plugged in, or becomes one */
    bool takes_screen;      /* trk_source_options.screen is for it */
    bool takes_calibration; /* trk_source_options.calibration is for it */
    bool follows_eye;       /* its samples are those of an eye, and not of a hand that points */
    bool rests_when_silent; /* it speaks only when gaze moves: silence is no loss */
    bool needs_real_clock;  /* its samples come from outside, when they happen */
    bool ends;              /* unless trk_source_options.loop is set, it comes to an end */
    bool waits_after_end;   /* for an eye tracker: trk_read() may deliver samples after TRK_END */
};

/* The kinds that there are, by index from 0: NULL after the last one; and the one that a spec names: NULL if
 * there is none. Static. */
const struct trk_source_kind *trk_source_kind_at(size_t index);
const struct trk_source_kind *trk_source_kind_find(const char *spec);

/* The screen that an eye tracker on a desk looks from; 0 is unknown. */
struct trk_screen {
    float width_m, height_m; /* of the calibrated area */
    float distance_m;        /* of the eyes from its middle */
};

struct trk_source_options {
    const char *spec; /* NAME or NAME:ARGUMENT of a kind */
    /* What is known here goes before what the device says; what neither knows is that of a usual desk:
     * 0.531 x 0.299 m (24 inches) at 0.65 m. Sizes from 0.01 to 20 m. */
    struct trk_screen screen;
    /* A file with the user's calibration, as the device gave it once, which is sent to the device;
     * NULL: none. */
    const char *calibration;
    /* auto: the recording to replay when no device is present. */
    const char *fallback_log;
    /* replay: pace against the log's own timestamps; 1 real time, 2 twice as fast, 0 as fast as it is read.
     * From 0.01 to 1000. */
    double speed;
    /* replay: start again at the end, on a clock that goes on. */
    bool loop;
    /* Time is what the reader says it is (until_ns of trk_read), and nothing ever waits. */
    bool virtual_clock;
};

enum trk_result {
    TRK_SAMPLE,  /* *out_sample holds the next sample */
    TRK_TIMEOUT, /* nothing until until_ns, or trk_interrupt() was called */
    TRK_END,     /* the source has ended and will deliver nothing more */
    TRK_FAILED,  /* the source broke: one line in out_error */
};

/* Open a source. NULL and a line in out_error on failure. The caller closes it with trk_close().
 *
 * Devices are read by a thread of their own. One that is not there is waited for, one that is unplugged is
 * looked for again: reads then time out, after one sample without TRK_DIRECTION that says that gaze was lost;
 * so does one when a device falls silent. Time and sequence go on from one plugging to the next. One that is
 * there and cannot be opened is an error, which says what to do.
 *
 * auto takes the first device that opens. Without one it replays the recording, and says so, until a device
 * is plugged in and sees an eye: from then on it is that device's, and never goes back to the recording. When
 * the recording ends before, trk_read() returns TRK_END once; read on to wait for a device. On the virtual
 * clock there are no devices. */
struct trk_source *trk_open(const struct trk_source_options *options, char out_error[TRK_ERROR_SIZE]);
void trk_close(struct trk_source *source); /* accepts NULL */

/* What a source is doing. */
struct trk_status {
    /* One line on what the source is. For example "replay of fixtures/hall.gaze: 2400 samples, 20.0 s, 120
     * Hz, head pose (no eye tracker found)". Of a device: which one it is, or what is waited for and why. */
    char description[TRK_ERROR_SIZE];
    bool is_device;   /* this is of an eye tracker */
    bool present;     /* it is plugged in and open */
    double speed;     /* how fast device_ns goes against arrival_ns: 1, or a replay's pace; 0 without pace */
    unsigned changes; /* counts whenever description does: a reader that has seen it need not look again */
    unsigned connections; /* how often a device was opened */
    uint64_t losses;      /* how often it fell silent or went */
    double rate_hz;       /* of its samples, lately; 0 is unknown */
    bool has_clock;       /* the device stamps its samples; then: */
    double jitter_ms;     /* standard deviation of their delay */
    double drift_ppm;     /* how much faster than ours its clock runs */
};

/* Any thread may ask, while another one reads. */
void trk_get_status(struct trk_source *source, struct trk_status *out_status);

/* An eye tracker that is plugged in. */
struct trk_device_info {
    char source[288];             /* what trk_source_options.spec would be for it */
    char name[160];               /* maker and product, and their numbers as udev rules have them */
    char abilities[256];          /* what it can do; "" if that cannot be known before it is open */
    char problem[TRK_ERROR_SIZE]; /* why it cannot be opened, and what to do; "" if it can */
};

/* What eye trackers there are. Fills up to room of out_devices; returns how many there are. Takes some tens
 * of milliseconds. Any thread may ask. */
size_t trk_list(struct trk_device_info *out_devices, size_t room);

/* The next sample. With the real clock, waits until a sample arrives or CLOCK_MONOTONIC reaches until_ns.
 * With the virtual clock returns at once: the next sample whose time is at or before until_ns, else
 * TRK_TIMEOUT. The clock of a replay or synthetic observer starts at the first call; arrival_ns is when a
 * sample was due, however late the reader is, or without pace (speed 0) when it was read. */
enum trk_result trk_read(struct trk_source *source, uint64_t until_ns, struct trk_sample *out_sample,
                         char out_error[TRK_ERROR_SIZE]);

/* A gaze direction (unit, world frame) from outside, at time_ns. True if this source takes it (pointer
 * does), and false with no effect otherwise. Non-finite or zero directions are refused with false.
 * Directions are delivered in the order they came; when a reader is more than 1024 behind, the oldest are
 * dropped and their sequence numbers with them. A time before the last one counts as the last one. */
bool trk_push(struct trk_source *source, const float direction[3], uint64_t time_ns);

/* Ask the system to run the calling thread soon after it is woken, even while others compute: for one that
 * mostly waits, for gaze or for messages, and passes on what came. It needs no rights, and where it is not
 * known (Linux before 6.12) nothing changes. */
void trk_be_prompt(void);

/* Wake a trk_read() that waits in another thread; it returns TRK_TIMEOUT. When none waits, the next one
 * that would wait returns at once instead. */
void trk_interrupt(struct trk_source *source);

/* Make the log of a synthetic observer: seconds long at 120 Hz; its format is "synthetic". False when memory
 * is short, or if seconds hold no sample or more than a log may. The caller frees with trk_log_finish(). */
bool trk_synthesise(uint64_t seed, double seconds, struct trk_log *out_log);

/* --- what the eye does ---------------------------------------------------------------------------------- */

enum trk_state {
    TRK_FIXATION, /* gaze rests, also while the head turns under it */
    TRK_PURSUIT,  /* gaze moves on smoothly */
    TRK_SACCADE,  /* gaze jumps */
    TRK_BLINK, /* no eye is seen, for its lid or for so short that it may be one; or it has just reopened */
    TRK_LOST,  /* no eye is seen */
    TRK_FALLBACK, /* no gaze was ever seen, or so long ago that the view's centre is the better guess */
    TRK_FROZEN,   /* a user wants it to stay */
};

/* "fixation", "pursuit", ...: one lower-case word. */
const char *trk_state_name(enum trk_state state);

struct trk_event {
    enum trk_state type;       /* TRK_FIXATION to TRK_LOST */
    uint64_t start_ns, end_ns; /* device time of its first and last sample */
    size_t first, last;        /* those samples, by their place in the log */
    float direction[3];        /* world, unit: the mean of a fixation, else where gaze is at the end of it */
    float amplitude_deg;       /* from start to end */
    float peak_deg_s;          /* highest speed of gaze in the world; 0 for blink and loss */
};

struct trk_events {
    size_t count;
    struct trk_event *events;    /* count of them, in order of time, never overlapping; owned by this */
    size_t counts[TRK_LOST + 1]; /* of each type */
    double noise_deg; /* of the measured directions while gaze rests: standard deviation of an axis */
};

/* What happens in a log, by the classifier of trk_attend(): fixations of at least 100 ms, saccades, pursuit,
 * blinks (the lid is down, or nothing is seen for 75 to 900 ms) and losses. Gaps shorter than 75 ms are
 * bridged; a blink takes 75 ms before and 150 ms after it with it. False when memory is short. The caller
 * frees with trk_events_finish(). */
bool trk_events_find(const struct trk_log *log, struct trk_events *out_events);
void trk_events_finish(struct trk_events *events);

/* --- from samples to a gaze to render for --------------------------------------------------------------- */

struct trk_attention;

struct trk_attention_options {
    bool raw;             /* no filter and no dead zone: the direction as measured */
    bool predict;         /* during a saccade, aim at where it will land */
    bool silence_is_rest; /* the source speaks only when gaze moves (a pointer): silence is no loss */
};

struct trk_gaze {
    uint64_t sequence;                         /* of the newest sample it answers; 0 before the first */
    uint64_t device_ns, sensor_ns, arrival_ns; /* of that sample */
    uint64_t time_ns;                          /* now_ns of the call that decided it */
    float direction[3];                        /* what to render for: unit, world */
    float spread; /* how many times wider than usual the fovea should be: 1 to 4 */
    enum trk_state state;
    const char *source; /* where the direction comes from: "both eyes", "left eye", "right eye", "prediction",
                         * "last gaze", "view centre" */
    const char *why;    /* a few words on the decision; static */
    bool moved;         /* direction or spread are others than before this call */
    float noise_deg;    /* of the tracker: standard deviation of an axis, measured while gaze rests */
};

/* NULL when memory is short. The caller frees with trk_attention_destroy(), which accepts NULL. It belongs to
 * one thread at a time. */
struct trk_attention *trk_attention_create(const struct trk_attention_options *options);
void trk_attention_destroy(struct trk_attention *attention);

/* Decide what to render for. Call it with every sample, in order, and with NULL from time to time (every 50
 * ms will do) while none comes: only so is silence noticed. now_ns is on the clock of arrival_ns and never
 * goes back. The same calls give the same answers. Takes no lock and no memory. */
void trk_attend(struct trk_attention *attention, const struct trk_sample *sample_or_null, uint64_t now_ns,
                struct trk_gaze *out_gaze);

/* While frozen the direction stays as it is, whatever the eye does. */
void trk_attention_freeze(struct trk_attention *attention, bool frozen);

/* How fast the source's clock goes against the one of now_ns (trk_status.speed): 1 to begin with, 0 where no
 * time passes between samples. */
void trk_attention_pace(struct trk_attention *attention, double speed);

/* Where the view's centre is when no head pose says so: an orientation (x, y, z, w), view to world. */
void trk_attention_view(struct trk_attention *attention, const float orientation[4]);

/* --- recentring ----------------------------------------------------------------------------------------- */

/* Declare that the eye looks at target now (unit, world; NULL: the view's centre), for a headset that has
 * slipped. The rotation that takes the measured gaze there is applied, in the head frame, to all gaze from
 * now on; it replaces the one before. False with a line in out_error, and nothing changed: gaze is not at
 * rest, or it would be a turn by more than 20 degrees. */
bool trk_recentre(struct trk_attention *attention, const float *target_or_null,
                  char out_error[TRK_ERROR_SIZE]);
/* The rotation in use (x, y, z, w), identity without one. */
void trk_recentre_get(const struct trk_attention *attention, float out_rotation[4]);
/* Use this rotation; false, with no effect, if it is no unit quaternion of at most 20 degrees. */
bool trk_recentre_set(struct trk_attention *attention, const float rotation[4]);

/* The rotation as it is kept in a file. What could not be written is told by ferror(file) alone. */
void trk_recentre_print(const float rotation[4], FILE *file);
bool trk_recentre_load(const char *path, float out_rotation[4], char out_error[TRK_ERROR_SIZE]);

/* --- recording ------------------------------------------------------------------------------------------ */

struct trk_recorder;

struct trk_recorder_status {
    uint64_t written; /* samples in the file */
    uint64_t lost;    /* samples that the disk did not take, or that came while the queue was full */
    uint64_t refused; /* samples that no log can hold: time or sequence going back, directions of no length */
    bool failing;     /* the disk takes nothing now; the recorder goes on trying */
    char error[TRK_ERROR_SIZE]; /* why the last failed write failed; "": none has failed */
};

/* What a file must hold before it is recorded to. */
void trk_recorder_print_head(FILE *file);

/* Record samples in the project's own log format, every field that is valid and both clocks, at the end of a
 * regular file that is open for writing: fd, which is the recorder's from now on, also on failure; path is
 * for messages. Every row is in the file within a tenth of a second and on the disk within a second or so;
 * after a crash trk_log_read() reads what there is. A disk that takes no more is tried again: what waits
 * meanwhile waits in a queue of 4096 samples, and what does not fit into that is lost. NULL and a line in
 * out_error on failure. */
struct trk_recorder *trk_recorder_start(int fd, const char *path, char out_error[TRK_ERROR_SIZE]);

/* Hand over a sample. Never waits for the disk: a thread of the recorder's own writes. Any thread may call.
 */
void trk_recorder_append(struct trk_recorder *recorder, const struct trk_sample *sample);

void trk_recorder_get_status(struct trk_recorder *recorder, struct trk_recorder_status *out_status);

/* Write what is left, to the disk, and free. False if samples were lost: out_status tells how many, and why.
 * Accepts NULL, which leaves out_status alone. */
bool trk_recorder_close(struct trk_recorder *recorder, struct trk_recorder_status *out_status);

#endif
