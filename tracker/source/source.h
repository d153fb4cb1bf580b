/* What a gaze source is made of, for the files of tracker/source/ and the table in tracker.c.
 *
 * A source is one file with a `const struct trk_source_type`, and one line in the table. Its own struct
 * begins with a struct trk_source, which carries what all sources share: the clock, and the wait that
 * trk_interrupt() ends.
 */
#ifndef FOVEAD_TRACKER_SOURCE_H
#define FOVEAD_TRACKER_SOURCE_H

#include "tracker.h"

#include <pthread.h>

struct trk_source_type {
    const char *name;  /* what trk_source_options.spec says before the colon */
    const char *usage; /* "name:ARGUMENT" as a user writes it */
    /* argument is what follows the colon, or NULL. NULL and a line in out_error if it cannot be opened. */
    struct trk_source *(*open)(const char *argument, const struct trk_source_options *options,
                               char out_error[TRK_ERROR_SIZE]);
    enum trk_result (*read)(struct trk_source *source, uint64_t until_ns, struct trk_sample *out_sample,
                            char out_error[TRK_ERROR_SIZE]);
    /* direction is finite and of unit length. NULL: this source takes none. */
    void (*push)(struct trk_source *source, const float direction[3], uint64_t time_ns);
    void (*interrupt)(struct trk_source *source); /* NULL: what waits in trk_source_sleep() wakes */
    void (*status)(struct trk_source *source, struct trk_status *out_status); /* NULL: nothing changes */
    void (*close)(struct trk_source *source);                                 /* and free */
};

extern const struct trk_source_type trk_replay, trk_synthetic, trk_pointer;

struct trk_source {
    const struct trk_source_type *type;
    char description[TRK_ERROR_SIZE];
    bool virtual_clock;
    double speed;      /* as trk_status has it; 1 to begin with */
    bool started;      /* only the reader's */
    uint64_t start_ns; /* of the first read: the reader's */
    pthread_mutex_t lock;
    pthread_cond_t changed; /* on CLOCK_MONOTONIC */
    bool interrupted;       /* under lock: trk_interrupt() was called and no read has answered yet */
};

/* A zeroed struct of size bytes that begins with a struct trk_source, made ready. NULL when memory is short.
 */
void *trk_source_create(size_t size, const struct trk_source_type *type, bool virtual_clock);
void trk_source_destroy(struct trk_source *source);

/* With source->lock held: wait until something changes, or until wake_ns. False if the read should rather
 * return TRK_TIMEOUT: until_ns has come, it was interrupted, or time is virtual and nothing can change by
 * waiting. */
bool trk_source_sleep(struct trk_source *source, uint64_t wake_ns, uint64_t until_ns);

/* For a source that knows when its next sample is due: wait for offset_ns after the first read. TRK_SAMPLE
 * when it is time, with the time itself in out_due_ns; else TRK_TIMEOUT. */
enum trk_result trk_source_pace(struct trk_source *source, uint64_t offset_ns, uint64_t until_ns,
                                uint64_t *out_due_ns);

/* CLOCK_MONOTONIC in nanoseconds. */
uint64_t trk_now_ns(void);

#endif
