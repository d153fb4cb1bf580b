/* probe: read a gaze source as a program would, check its samples, and print a summary.
 *
 *   probe SPEC [FALLBACK_LOG [CALIBRATION]]
 *
 * Reads until SIGTERM comes. Sequence numbers and all times of samples must be in order, directions of unit
 * length, and arrivals not in the future. Prints one line "name=value ..." for scripts. Whenever the
 * description of the source changes, it is printed to stderr with the heap in use. Descriptors and threads
 * are counted when a device is opened for the second and for the last time. If a check fails, prints one line
 * and exits with 1. */
#include "tracker.h"

#include <dirent.h>
#include <malloc.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static volatile sig_atomic_t stopped;

static void on_signal(int number)
{
    stopped = number;
}

static uint64_t now_ns(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * 1000000000 + (uint64_t)now.tv_nsec;
}

struct use { /* of what can leak */
    int descriptors, threads;
    size_t heap;
};

static int entries(const char *path)
{
    int count = -2; /* . and .. */
    DIR *folder = opendir(path);
    if (!folder) return -1;
    while (readdir(folder)) count++;
    closedir(folder);
    return count;
}

static struct use look(void)
{
    return (struct use){entries("/proc/self/fd"), entries("/proc/self/task"), mallinfo2().uordblks};
}

struct tally {
    uint64_t samples, valid, gaps, backlog_ns;
    struct trk_sample last;
};

static void fail(const char *what, const struct tally *tally, const struct trk_sample *sample)
{
    printf("FAIL: %s: sample %llu after %llu, device %llu after %llu ns\n", what,
           (unsigned long long)sample->sequence, (unsigned long long)tally->last.sequence,
           (unsigned long long)sample->device_ns, (unsigned long long)tally->last.device_ns);
    exit(1);
}

static void check(struct tally *tally, const struct trk_sample *sample)
{
    const struct trk_sample *last = &tally->last;
    const float *d = sample->direction;
    uint64_t age_ns = now_ns() - sample->arrival_ns;
    if (sample->sequence <= last->sequence) fail("sequence", tally, sample);
    if (sample->device_ns < last->device_ns) fail("device time", tally, sample);
    if (sample->arrival_ns < last->arrival_ns || age_ns >> 63) fail("arrival", tally, sample);
    if (sample->sensor_ns > sample->arrival_ns) fail("sensor time", tally, sample);
    if ((sample->valid & TRK_DIRECTION) && !(fabsf(d[0] * d[0] + d[1] * d[1] + d[2] * d[2] - 1) < 1e-4f))
        fail("direction", tally, sample);
    tally->samples++;
    tally->valid += (sample->valid & TRK_DIRECTION) != 0;
    tally->gaps += sample->sequence - last->sequence - 1;
    if (age_ns > tally->backlog_ns) tally->backlog_ns = age_ns;
    tally->last = *sample;
}

struct seen { /* what the source has said of itself */
    struct trk_status status;
    unsigned changes;
    struct use first, last; /* when a device was opened for the second and for the last time */
};

static void tell_status(struct trk_source *source, struct seen *seen)
{
    struct trk_status *status = &seen->status;
    trk_get_status(source, status);
    if (status->changes == seen->changes) return;
    fprintf(stderr, "probe: %s [heap %zu]\n", status->description, look().heap);
    seen->changes = status->changes;
    if (status->present) seen->last = look();
    if (status->present && status->connections == 2) seen->first = seen->last;
}

int main(int count, char **arguments)
{
    if (count < 2 || count > 4) {
        fprintf(stderr, "usage: probe SPEC [FALLBACK_LOG [CALIBRATION]]\n");
        return 2;
    }
    struct trk_source_options options = {.spec = arguments[1],
                                         .speed = 1,
                                         .fallback_log = count > 2 ? arguments[2] : NULL,
                                         .calibration = count > 3 ? arguments[3] : NULL,
                                         .loop = true};
    char error[TRK_ERROR_SIZE] = "";
    struct tally tally = {0};
    struct seen seen = {.changes = (unsigned)-1};
    signal(SIGTERM, on_signal);
    struct trk_source *source = trk_open(&options, error);
    if (!source) {
        printf("FAIL: %s\n", error);
        return 1;
    }
    enum trk_result result = TRK_TIMEOUT;
    /* After SIGTERM, read the samples that have already arrived. */
    while (result != TRK_FAILED && !(stopped && result != TRK_SAMPLE)) {
        struct trk_sample sample;
        result = trk_read(source, stopped ? 0 : now_ns() + 50000000, &sample, error);
        if (result == TRK_SAMPLE) check(&tally, &sample);
        tell_status(source, &seen);
    }
    const struct trk_status status = seen.status;
    const struct use first = seen.first, last = seen.last;
    if (result == TRK_FAILED) printf("FAIL: %s\n", error);
    trk_close(source);
    printf("samples=%llu valid=%llu gaps=%llu losses=%llu connections=%u rate=%.0f jitter_ms=%.3f "
           "drift_ppm=%.1f "
           "worst_wait_ms=%.1f",
           (unsigned long long)tally.samples, (unsigned long long)tally.valid, (unsigned long long)tally.gaps,
           (unsigned long long)status.losses, status.connections, status.rate_hz, status.jitter_ms,
           status.drift_ppm, (double)tally.backlog_ns * 1e-6);
    if (first.threads)
        printf(" descriptors=%d->%d threads=%d->%d", first.descriptors, last.descriptors, first.threads,
               last.threads);
    printf("\n");
    return result == TRK_FAILED;
}
