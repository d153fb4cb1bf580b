/* tracker: where the eye looks.
 *
 * A source delivers gaze samples: a recorded log, a synthetic observer, a pointer moved by a client; eye
 * trackers on HID and USB take their place in the same table. This folder knows nothing of pixels or
 * sockets.
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

enum { TRK_ERROR_SIZE = 512 };

/* What a sample really carries; a field whose bit is unset holds nothing of meaning. */
enum {
    TRK_DIRECTION = 1 << 0,      /* combined gaze direction */
    TRK_ORIGIN = 1 << 1,         /* combined gaze origin */
    TRK_HEAD = 1 << 2,           /* head pose */
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
};

/* The gaze direction in the world: direction rotated by the head pose if there is one.
 * Returns false, and leaves out_direction alone, if the sample has no valid direction. */
bool trk_world_direction(const struct trk_sample *sample, float out_direction[3]);

/* --- logs ----------------------------------------------------------------------------------------------- */

/* A recorded log, whole in memory. Samples are ordered by device_ns, which never goes back. arrival_ns of
 * a log's samples is the time of the recording's own host clock where the format has one, else equal to
 * device_ns. */
struct trk_log {
    const char *format; /* name of the format it was read as: static storage */
    size_t count;
    struct trk_sample *samples; /* count of them; owned by the log */
};

/* Read a log of any known format, told by its first line. On failure returns false with a line in
 * out_error and leaves *out_log empty. Refused: what is no regular file, no rows, unknown header, time or
 * sequence going back, non-finite numbers, directions that are not of unit length, a last line that is cut
 * off, more than 64 Mi rows or 104 days. The caller frees with trk_log_finish(). */
bool trk_log_read(const char *path, struct trk_log *out_log, char out_error[TRK_ERROR_SIZE]);

/* Write a log in the project's own format (documented in log/own.h); it appears whole or not at all. */
bool trk_log_write(const char *path, const struct trk_log *log, char out_error[TRK_ERROR_SIZE]);

void trk_log_finish(struct trk_log *log);

/* --- sources -------------------------------------------------------------------------------------------- */

struct trk_source;

struct trk_source_options {
    /* "auto", "replay:FILE", "synthetic", "synthetic:SEED" or "pointer". */
    const char *spec;
    /* auto: the recording to replay when no device is present. */
    const char *fallback_log;
    /* replay: pace against the log's own timestamps; 1 real time, 2 twice as fast, 0 as fast as it is read.
     * From 0.01 to 1000. */
    double speed;
    /* replay, synthetic: start again at the end, on a clock that goes on. */
    bool loop;
    /* synthetic: length in seconds; 0 is without end. */
    double seconds;
    /* Time is what the reader says it is (until_ns of trk_read), and nothing ever waits. */
    bool virtual_clock;
};

enum trk_result {
    TRK_SAMPLE,  /* *out_sample holds the next sample */
    TRK_TIMEOUT, /* nothing until until_ns, or trk_interrupt() was called */
    TRK_END,     /* the source has ended and will deliver nothing more */
    TRK_FAILED,  /* the source broke: one line in out_error */
};

/* Open a source. NULL and a line in out_error on failure. The caller closes it with trk_close(). */
struct trk_source *trk_open(const struct trk_source_options *options, char out_error[TRK_ERROR_SIZE]);
void trk_close(struct trk_source *source); /* accepts NULL */

/* One line on what this source is and, for "auto", why: static for the source's life. For example
 * "replay of fixtures/hall.gaze: 2400 samples, 20.0 s, 120 Hz, head pose (no eye tracker found)". */
const char *trk_describe(const struct trk_source *source);

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

/* Wake a trk_read() that waits in another thread; it returns TRK_TIMEOUT. When none waits, the next one
 * that would wait returns at once instead. */
void trk_interrupt(struct trk_source *source);

/* Fill out_log with a synthetic observer's recording: seconds long at 120 Hz; format "synthetic". False
 * when memory is short or seconds hold no sample or more than a log may. The caller frees with
 * trk_log_finish(). */
bool trk_synthesise(uint64_t seed, double seconds, struct trk_log *out_log);

#endif
