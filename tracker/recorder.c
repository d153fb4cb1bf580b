/* The recorder: samples go into a queue, and a thread of the recorder's own writes them to the disk.
 *
 * The thread writes several whole rows at a time, so that a crash of the program leaves whole rows. Only a
 * crash of the machine can cut the last row; the reader leaves such a row out. trk_recorder_append() never
 * waits for a write. Samples that the disk does not take stay in the queue and are written later. */
#include "tracker.h"

#include "error.h"
#include "log/own.h"
#include "log/rows.h"
#include "system.h"

#include <errno.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* Four seconds at a kilohertz: a disk may be busy for that long. */
enum { QUEUE = 4096, BATCH = 64 };

static const uint64_t write_period_ns = 100000000, sync_period_ns = 1000000000;

struct trk_recorder {
    /* Only the writing thread uses these until it has ended. */
    int fd;
    char *path;
    off_t size;        /* bytes of whole rows in the file */
    uint64_t unsynced; /* rows in the file that may not be on the disk */
    uint64_t sync_ns;  /* when all rows were last on the disk */
    char text[BATCH * TRK_OWN_SIZE];

    pthread_t thread;
    pthread_cond_t changed; /* on CLOCK_MONOTONIC */
    pthread_mutex_t lock;   /* of all that follows */
    bool closing;
    struct trk_recorder_status status;
    struct trk_sample newest; /* the last accepted sample; sequence 0: none yet */
    uint64_t accepted;
    size_t first, count; /* of the queue */
    struct trk_sample queue[QUEUE];
};

/* --- the writer's thread --- */

/* With the lock held. */
static void fail(struct trk_recorder *r, const char *what, int error)
{
    trk_fail(r->status.error, "%s: cannot %s: %s", r->path, what, strerror(error));
    r->status.failing = true;
}

/* Write all of the text or nothing: half a row on a full disk is removed again. */
static bool write_text(struct trk_recorder *r, size_t length)
{
    size_t done = 0;
    while (done < length) {
        ssize_t n = pwrite(r->fd, r->text + done, length - done, r->size + (off_t)done);
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) {
            int error = n < 0 ? errno : ENOSPC;
            if (done > 0) (void)!ftruncate(r->fd, r->size);
            errno = error;
            return false;
        }
        done += (size_t)n;
    }
    r->size += (off_t)length;
    return true;
}

/* Flush the file to the disk. If that fails, the rows since the last time may be lost, even if the file seems
 * to hold them. */
static void sync_to_disk(struct trk_recorder *r)
{
    if (r->unsynced > 0 && fdatasync(r->fd) != 0) {
        int error = errno;
        pthread_mutex_lock(&r->lock);
        fail(r, "write to the disk", error);
        r->status.written -= r->unsynced;
        r->status.lost += r->unsynced;
        pthread_mutex_unlock(&r->lock);
    }
    r->unsynced = 0;
    r->sync_ns = trk_now_ns();
}

/* Wait until there is enough to write, and turn a batch of samples into text. The samples stay in the queue.
 * Returns false when the recorder is being closed and the queue is empty. */
static bool take_batch(struct trk_recorder *r, bool again, size_t *out_count, size_t *out_length)
{
    uint64_t wake_ns = trk_now_ns() + write_period_ns;
    size_t length = 0;
    pthread_mutex_lock(&r->lock);
    while (!r->closing && !again && (r->status.failing || r->count < QUEUE / 2))
        if (!trk_condition_wait(&r->changed, &r->lock, wake_ns)) break;
    size_t n = r->count < BATCH ? r->count : BATCH, first = r->first;
    bool more = n > 0 || !r->closing;
    pthread_mutex_unlock(&r->lock);
    /* No lock is needed, because only this thread removes samples from the queue. */
    for (size_t i = 0; i < n; i++)
        length += trk_own_row(&r->queue[(first + i) % QUEUE], true, r->text + length);
    *out_count = n;
    *out_length = length;
    return more;
}

/* Remove a written batch from the queue. When the recorder is being closed, also give up what cannot be
 * written. Returns true if there is another full batch. */
static bool settle_batch(struct trk_recorder *r, size_t count, int error)
{
    pthread_mutex_lock(&r->lock);
    if (error) {
        fail(r, "write", error);
        if (r->closing) {
            r->status.lost += r->count;
            r->count = 0;
        }
    } else {
        r->first = (r->first + count) % QUEUE;
        r->count -= count;
        r->status.written += count;
        r->status.failing = false;
    }
    bool again = !error && r->count >= BATCH;
    pthread_mutex_unlock(&r->lock);
    return again;
}

static void *write_all(void *argument)
{
    struct trk_recorder *r = argument;
    size_t count, length;
    bool again = false; /* the queue still holds a full batch */
    while (take_batch(r, again, &count, &length)) {
        again = false;
        if (count > 0) {
            bool ok = write_text(r, length);
            again = settle_batch(r, count, ok ? 0 : errno);
            if (ok) r->unsynced += count;
        }
        if (trk_now_ns() - r->sync_ns >= sync_period_ns) sync_to_disk(r);
    }
    sync_to_disk(r);
    return NULL;
}

/* --- the caller's side --- */

/* Start the thread with all signals blocked: the program's other threads handle signals. */
static bool start(struct trk_recorder *r)
{
    sigset_t all, before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    bool ok = pthread_create(&r->thread, NULL, write_all, r) == 0;
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    return ok;
}

void trk_recorder_print_head(FILE *file)
{
    char text[TRK_OWN_SIZE];
    fwrite(text, 1, trk_own_header(true, text), file);
}

static void destroy(struct trk_recorder *r)
{
    pthread_cond_destroy(&r->changed);
    pthread_mutex_destroy(&r->lock);
    close(r->fd);
    free(r->path);
    free(r);
}

struct trk_recorder *trk_recorder_start(int fd, const char *path, char out_error[TRK_ERROR_SIZE])
{
    struct trk_recorder *r = calloc(1, sizeof *r);
    struct stat file;
    if (!r || !(r->path = strdup(path))) {
        trk_fail(out_error, "%s: no memory to record", path);
        free(r);
        close(fd);
        return NULL;
    }
    r->fd = fd;
    pthread_mutex_init(&r->lock, NULL);
    trk_condition_init(&r->changed);
    r->sync_ns = trk_now_ns();
    if (fstat(fd, &file) != 0) {
        trk_fail(out_error, "%s: cannot record: %s", path, strerror(errno));
    } else {
        r->size = file.st_size;
        if (start(r)) return r;
        trk_fail(out_error, "%s: cannot record: no thread", path);
    }
    destroy(r);
    return NULL;
}

/* Would trk_log_append() accept the sample? */
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
        r->status.refused++;
    } else if (r->count == QUEUE) {
        r->status.lost++;
        if (!r->status.error[0]) trk_fail(r->status.error, "%s: the disk is too slow", r->path);
    } else {
        r->queue[(r->first + r->count++) % QUEUE] = *sample;
        r->newest = *sample;
        r->accepted++;
        if (r->count == QUEUE / 2) pthread_cond_signal(&r->changed);
    }
    pthread_mutex_unlock(&r->lock);
}

void trk_recorder_get_status(struct trk_recorder *r, struct trk_recorder_status *out_status)
{
    pthread_mutex_lock(&r->lock);
    *out_status = r->status;
    pthread_mutex_unlock(&r->lock);
}

bool trk_recorder_close(struct trk_recorder *r, struct trk_recorder_status *out_status)
{
    if (!r) return true;
    pthread_mutex_lock(&r->lock);
    r->closing = true;
    pthread_cond_signal(&r->changed);
    pthread_mutex_unlock(&r->lock);
    pthread_join(r->thread, NULL);
    bool ok = r->status.lost == 0;
    if (out_status) *out_status = r->status;
    destroy(r);
    return ok;
}
