/* The recorder: samples go into a queue, and a thread of its own writes them to the disk.
 *
 * Rows are appended whole, some at a time, so that a crash of the program leaves whole rows; only a crash of
 * the machine can tear the last one, which the reader drops. Who appends never waits for a write.
 */
#include "tracker.h"

#include "error.h"
#include "log/own.h"
#include "source/source.h"

#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

/* Four seconds at a kilohertz: a disk may be busy for that long. */
enum { QUEUE = 4096, BATCH = 64 };

static const uint64_t write_period_ns = 100000000, sync_period_ns = 1000000000;

struct trk_recorder {
    /* The writer's alone, until it has ended. */
    int fd;
    char *path;
    off_t size;       /* of whole rows that are in the file */
    bool unsynced;    /* some of them may not be on the disk */
    uint64_t sync_ns; /* when they last were */
    bool backlog;     /* a full batch was left in the queue */
    struct trk_sample batch[BATCH];
    char text[BATCH * TRK_OWN_SIZE];
    char error[TRK_ERROR_SIZE];

    pthread_t thread;
    pthread_cond_t changed; /* on CLOCK_MONOTONIC */
    pthread_mutex_t lock;   /* of all that follows */
    bool closing;
    struct trk_recorder_state state;
    struct trk_sample newest; /* the last one accepted; sequence 0: none yet */
    uint64_t accepted;
    size_t first, count; /* of the queue */
    struct trk_sample queue[QUEUE];
};

/* --- the writer's thread -------------------------------------------------------------------------------- */

static void fail(struct trk_recorder *r, const char *what)
{
    trk_fail(r->error, "%s: cannot %s: %s", r->path, what, strerror(errno));
    pthread_mutex_lock(&r->lock);
    r->state.failed = true;
    pthread_mutex_unlock(&r->lock);
}

/* All of it or nothing: half a row on a full disk is taken back. */
static bool write_text(struct trk_recorder *r, size_t length)
{
    size_t done = 0;
    while (done < length) {
        ssize_t n = write(r->fd, r->text + done, length - done);
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) {
            fail(r, "write");
            if (ftruncate(r->fd, r->size) != 0) return false; /* the reader drops what is torn */
            return false;
        }
        done += (size_t)n;
    }
    r->size += (off_t)length;
    r->unsynced = true;
    return true;
}

static void sync_to_disk(struct trk_recorder *r)
{
    if (r->unsynced && fdatasync(r->fd) != 0) fail(r, "write to the disk");
    r->unsynced = false;
    r->sync_ns = trk_now_ns();
}

/* Wait until there is something worth writing, and take it off the queue. False when there never will be. */
static bool take_batch(struct trk_recorder *r, size_t *out_count)
{
    uint64_t wake_ns = trk_now_ns() + write_period_ns;
    struct timespec wake = {.tv_sec = (time_t)(wake_ns / 1000000000),
                            .tv_nsec = (long)(wake_ns % 1000000000)};
    pthread_mutex_lock(&r->lock);
    while (!r->closing && !r->backlog && r->count < QUEUE / 2)
        if (pthread_cond_timedwait(&r->changed, &r->lock, &wake) == ETIMEDOUT) break;
    size_t n = r->count < BATCH ? r->count : BATCH;
    for (size_t i = 0; i < n; i++) r->batch[i] = r->queue[(r->first + i) % QUEUE];
    r->first = (r->first + n) % QUEUE;
    r->count -= n;
    r->backlog = r->count >= BATCH;
    if (r->state.failed) r->state.dropped += n;
    bool more = n > 0 || !r->closing;
    *out_count = r->state.failed ? 0 : n;
    pthread_mutex_unlock(&r->lock);
    return more;
}

static void *write_all(void *argument)
{
    struct trk_recorder *r = argument;
    size_t count;
    while (take_batch(r, &count)) {
        size_t length = 0;
        for (size_t i = 0; i < count; i++) length += trk_own_row(&r->batch[i], true, r->text + length);
        bool ok = write_text(r, length);
        pthread_mutex_lock(&r->lock);
        *(ok ? &r->state.written : &r->state.dropped) += count;
        pthread_mutex_unlock(&r->lock);
        if (trk_now_ns() - r->sync_ns >= sync_period_ns) sync_to_disk(r);
    }
    sync_to_disk(r);
    return NULL;
}

/* --- the caller's side ---------------------------------------------------------------------------------- */

static int open_file(const char *path, bool replace, char out_error[TRK_ERROR_SIZE])
{
    struct stat status;
    int flags = O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC | O_NONBLOCK | (replace ? 0 : O_EXCL);
    int fd = open(path, flags, 0666);
    if (fd < 0 && errno == EEXIST)
        trk_fail(out_error, "%s: exists, expected a new file to record to", path);
    else if (fd < 0)
        trk_fail(out_error, "%s: cannot record: %s", path, strerror(errno));
    else if (fstat(fd, &status) != 0 || !S_ISREG(status.st_mode))
        trk_fail(out_error, "%s: not a regular file, expected a place for a gaze log", path);
    else if (flock(fd, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) /* not every file system has locks */
        trk_fail(out_error, "%s: is being recorded already, expected another file", path);
    else if (ftruncate(fd, 0) != 0)
        trk_fail(out_error, "%s: cannot record: %s", path, strerror(errno));
    else
        return fd;
    if (fd >= 0) close(fd);
    return -1;
}

/* Signals are for the program's other threads. */
static bool start(struct trk_recorder *r)
{
    sigset_t all, before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    bool ok = pthread_create(&r->thread, NULL, write_all, r) == 0;
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    return ok;
}

struct trk_recorder *trk_recorder_open(const char *path, bool replace, char out_error[TRK_ERROR_SIZE])
{
    struct trk_recorder *r = calloc(1, sizeof *r);
    pthread_condattr_t monotonic;
    if (!r || !(r->path = strdup(path))) {
        trk_fail(out_error, "%s: no memory to record", path);
        goto no_memory;
    }
    r->fd = open_file(path, replace, out_error);
    if (r->fd < 0) goto no_file;
    pthread_mutex_init(&r->lock, NULL);
    pthread_condattr_init(&monotonic);
    pthread_condattr_setclock(&monotonic, CLOCK_MONOTONIC);
    pthread_cond_init(&r->changed, &monotonic);
    pthread_condattr_destroy(&monotonic);
    r->sync_ns = trk_now_ns();
    if (!write_text(r, trk_own_header(true, r->text))) {
        memcpy(out_error, r->error, sizeof r->error);
        goto not_started;
    }
    if (start(r)) return r;
    trk_fail(out_error, "%s: cannot record: no thread", path);
not_started:
    pthread_cond_destroy(&r->changed);
    pthread_mutex_destroy(&r->lock);
    unlink(path);
    close(r->fd);
no_file:
    free(r->path);
no_memory:
    free(r);
    return NULL;
}

/* What a log never holds: see trk_log_append(). */
static bool fits(const struct trk_recorder *r, const struct trk_sample *sample)
{
    return sample->sequence > r->newest.sequence && sample->device_ns >= r->newest.device_ns &&
           sample->arrival_ns >= r->newest.arrival_ns && sample->device_ns <= TRK_MAX_DEVICE_NS &&
           r->accepted < TRK_MAX_ROWS && trk_own_accepts(sample);
}

void trk_recorder_append(struct trk_recorder *r, const struct trk_sample *sample)
{
    pthread_mutex_lock(&r->lock);
    if (!fits(r, sample)) {
        r->state.refused++;
    } else if (r->count == QUEUE || r->state.failed) {
        r->state.dropped++;
    } else {
        r->queue[(r->first + r->count++) % QUEUE] = *sample;
        r->newest = *sample;
        r->accepted++;
        if (r->count == QUEUE / 2) pthread_cond_signal(&r->changed);
    }
    pthread_mutex_unlock(&r->lock);
}

void trk_recorder_look(struct trk_recorder *r, struct trk_recorder_state *out_state)
{
    pthread_mutex_lock(&r->lock);
    *out_state = r->state;
    pthread_mutex_unlock(&r->lock);
}

bool trk_recorder_close(struct trk_recorder *r, struct trk_recorder_state *out_state,
                        char out_error[TRK_ERROR_SIZE])
{
    if (!r) return true;
    pthread_mutex_lock(&r->lock);
    r->closing = true;
    pthread_cond_signal(&r->changed);
    pthread_mutex_unlock(&r->lock);
    pthread_join(r->thread, NULL);
    if (close(r->fd) != 0 && !r->state.failed) fail(r, "close");
    bool ok = !r->state.failed;
    if (!ok) memcpy(out_error, r->error, sizeof r->error);
    if (out_state) *out_state = r->state;
    pthread_cond_destroy(&r->changed);
    pthread_mutex_destroy(&r->lock);
    free(r->path);
    free(r);
    return ok;
}
