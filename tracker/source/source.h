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

    /* For every source but a device: open it. argument is the text after the colon, or NULL. NULL and a line
     * in out_error on failure. */
    struct trk_source *(*open)(const char *argument, const struct trk_source_options *options,
                               char out_error[TRK_ERROR_SIZE]);

    /* For a device, which device.c turns into a source. One thread at a time calls these functions for one
     * device; any thread may call list(). */
    /* List the devices that are plugged in. Fills up to room of out_devices, and returns how many there are.
     */
    size_t (*list)(struct trk_device_info *out_devices, size_t room);
    /* Open the first device that works, or the one at path if path is not NULL. Returns a handle. NULL with
     * an empty out_error if there is no such device; NULL with a line in it if the device cannot be opened.
     * options live as long as the device. */
    void *(*attach)(struct trk_device *device, const char *path, const struct trk_source_options *options,
                    struct trk_device_facts *out_facts, char out_error[TRK_ERROR_SIZE]);
    /* Wait for up to wait_ms, and pass on what arrives with trk_device_deliver(). False when the device has
     * gone. */
    bool (*step)(void *handle, int wait_ms);
    void (*detach)(void *handle);
};

/* What an open source does. */
struct trk_source_methods {
    enum trk_result (*read)(struct trk_source *source, uint64_t until_ns, struct trk_sample *out_sample,
                            char out_error[TRK_ERROR_SIZE]);
    /* direction is finite and of unit length. NULL: the source takes no directions. */
    void (*push)(struct trk_source *source, const float direction[3], uint64_t time_ns);
    /* NULL: waking trk_source_sleep() is enough. */
    void (*interrupt)(struct trk_source *source);
    /* NULL: the description and on_screen never change. */
    void (*status)(struct trk_source *source, struct trk_status *out_status);
    /* Close and free. */
    void (*close)(struct trk_source *source);
};

struct trk_source {
    const struct trk_source_methods *methods;
    char description[TRK_ERROR_SIZE];
    bool virtual_clock;
    double speed;      /* as in trk_status; 1 at first */
    bool on_screen;    /* as in trk_status */
    bool started;      /* only the reader's */
    uint64_t start_ns; /* time of the first read; only the reader uses it */
    pthread_mutex_t lock;
    pthread_cond_t changed; /* on CLOCK_MONOTONIC */
    bool interrupted;       /* under lock: trk_interrupt() was called and no read has returned for it yet */
};

/* Allocate and initialise a struct of size bytes that begins with a struct trk_source; the rest is zero. NULL
 * when memory is short. */
void *trk_source_create(size_t size, const struct trk_source_methods *methods, bool virtual_clock);
void trk_source_destroy(struct trk_source *source);

/* With source->lock held, wait until something changes or wake_ns comes. Returns false if the read should
 * return TRK_TIMEOUT: until_ns has come, the read was interrupted, or time is virtual and waiting cannot
 * change anything. */
bool trk_source_sleep(struct trk_source *source, uint64_t wake_ns, uint64_t until_ns);

/* For a source that knows when its next sample is due: wait until offset_ns after the first read. Returns
 * TRK_SAMPLE when it is due, with the due time in out_due_ns; otherwise TRK_TIMEOUT. */
enum trk_result trk_source_pace(struct trk_source *source, uint64_t offset_ns, uint64_t until_ns,
                                uint64_t *out_due_ns);

#endif
