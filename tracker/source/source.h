/* source: what a gaze source is made of.
 *
 * A kind of source is one file with a `const struct trk_source_row`, a line in the table in source/kinds.h,
 * and a line in CMakeLists.txt. An open source's own struct begins with a struct trk_source, which carries
 * what all sources share: the clock, and the wait that trk_interrupt() ends. The functions of tracker.h that
 * take an open source are in source.c; those that choose one are in sources.c. */
#ifndef FOVEAD_TRACKER_SOURCE_H
#define FOVEAD_TRACKER_SOURCE_H

#include "tracker.h"

#include <pthread.h>

struct trk_device;
struct trk_device_facts; /* both in source/device.h */

struct trk_source_row {
    struct trk_source_kind kind;

    /* Every source but a device: open it. argument is what follows the colon, or NULL. NULL and a line in
     * out_error on failure. */
    struct trk_source *(*open)(const char *argument, const struct trk_source_options *options,
                               char out_error[TRK_ERROR_SIZE]);

    /* A device, which device.c makes a source of. One thread at a time calls these for one device; any thread
     * may call list(). */
    /* The devices that are plugged in. Fills up to room of out_devices; returns how many there are. */
    size_t (*list)(struct trk_device_info *out_devices, size_t room);
    /* Open the first device that works, or the one at path if path is not NULL; returns a handle. NULL with
     * an empty out_error if there is no such device, with a line in it if there is one that cannot be opened.
     * options live as long as the device. */
    void *(*attach)(struct trk_device *device, const char *path, const struct trk_source_options *options,
                    struct trk_device_facts *out_facts, char out_error[TRK_ERROR_SIZE]);
    /* Wait for up to wait_ms and pass on what came by trk_device_deliver(). False when the device is gone. */
    bool (*step)(void *handle, int wait_ms);
    void (*detach)(void *handle);
};

/* What an open source does. */
struct trk_source_methods {
    enum trk_result (*read)(struct trk_source *source, uint64_t until_ns, struct trk_sample *out_sample,
                            char out_error[TRK_ERROR_SIZE]);
    /* direction is finite and of unit length. NULL: the source takes none. */
    void (*push)(struct trk_source *source, const float direction[3], uint64_t time_ns);
    /* NULL: it is enough to wake trk_source_sleep(). */
    void (*interrupt)(struct trk_source *source);
    /* NULL: the description never changes. */
    void (*status)(struct trk_source *source, struct trk_status *out_status);
    /* Close and free. */
    void (*close)(struct trk_source *source);
};

struct trk_source {
    const struct trk_source_methods *methods;
    char description[TRK_ERROR_SIZE];
    bool virtual_clock;
    double speed;      /* as in trk_status; 1 to begin with */
    bool started;      /* only the reader's */
    uint64_t start_ns; /* of the first read: only the reader's */
    pthread_mutex_t lock;
    pthread_cond_t changed; /* on CLOCK_MONOTONIC */
    bool interrupted;       /* under lock: trk_interrupt() was called, and no read has returned for it yet */
};

/* A zeroed struct of size bytes that begins with a struct trk_source, made ready. NULL when memory is short.
 */
void *trk_source_create(size_t size, const struct trk_source_methods *methods, bool virtual_clock);
void trk_source_destroy(struct trk_source *source);

/* With source->lock held: wait until something changes, or until wake_ns. False if the read should return
 * TRK_TIMEOUT instead: until_ns has come, the read was interrupted, or time is virtual and nothing can change
 * by waiting. */
bool trk_source_sleep(struct trk_source *source, uint64_t wake_ns, uint64_t until_ns);

/* For a source that knows when its next sample is due: wait for offset_ns after the first read. TRK_SAMPLE
 * when it is time, with the time itself in out_due_ns; else TRK_TIMEOUT. */
enum trk_result trk_source_pace(struct trk_source *source, uint64_t offset_ns, uint64_t until_ns,
                                uint64_t *out_due_ns);

#endif
