/* The recorder: it records every sample whatever happens to the program, refuses samples that no log can
 * hold, and copes with a full disk. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "tracker.h"
#include "tracker_samples.h"

#include <fcntl.h>
#include <math.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

static char dir[64], path[96];
static char error[TRK_ERROR_SIZE];

static int enter(void **state)
{
    (void)state;
    snprintf(dir, sizeof dir, "tracker_recorder.XXXXXX");
    if (!mkdtemp(dir)) return -1;
    snprintf(path, sizeof path, "%s/x.gaze", dir);
    error[0] = '\0';
    return 0;
}

static int leave(void **state)
{
    (void)state;
    unlink(path);
    return rmdir(dir);
}

static uint64_t monotonic_ns(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * 1000000000 + (uint64_t)now.tv_nsec;
}

static void sleep_ms(long ms)
{
    nanosleep(&(struct timespec){ms / 1000, ms % 1000 * 1000000}, NULL);
}

static struct trk_recorder *open_new(void)
{
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    trk_recorder_print_head(file);
    assert_int_equal(fclose(file), 0);
    struct trk_recorder *recorder = trk_recorder_start(open(path, O_WRONLY | O_APPEND), path, error);
    if (!recorder) fail_msg("%s", error);
    return recorder;
}

/* Wait until the recorder has written this many samples by itself. */
static void await_written(struct trk_recorder *recorder, uint64_t count)
{
    struct trk_recorder_status now;
    for (;;) {
        trk_recorder_get_status(recorder, &now);
        assert_false(now.failing);
        if (now.written >= count) return;
        sleep_ms(10);
    }
}

/* The same for a disk that has failed and has room again. */
static void await_recovery(struct trk_recorder *recorder, uint64_t count)
{
    struct trk_recorder_status now;
    do {
        sleep_ms(10);
        trk_recorder_get_status(recorder, &now);
    } while (now.failing || now.written < count);
    assert_int_equal(now.written, count);
}

static void reads_as(const struct trk_sample *samples, size_t count)
{
    struct trk_log back;
    if (!trk_log_read(path, &back, error)) fail_msg("%s", error);
    assert_int_equal(back.count, count);
    for (size_t i = 0; i < count; i++) assert_memory_equal(sample_at(&back, i), &samples[i], sizeof *samples);
    trk_log_finish(&back);
}

static void records_every_field(void **state)
{
    (void)state;
    struct trk_log log;
    struct trk_recorder_status after;
    assert_true(trk_synthesise(4, 20, &log));
    struct trk_sample *samples = samples_of(&log);
    assert_non_null(samples);
    samples[7].valid |= TRK_SCREEN;
    samples[7].screen[0] = 0.25f;
    samples[7].screen[1] = -0.1f;
    struct trk_recorder *recorder = open_new();
    for (size_t i = 0; i < log.count; i++) trk_recorder_append(recorder, &samples[i]);
    assert_true(trk_recorder_close(recorder, &after));
    assert_int_equal(after.written, log.count);
    assert_int_equal(after.lost + after.refused, 0);
    reads_as(samples, log.count);
    free(samples);
    trk_log_finish(&log);
}

/* Anyone can read the rows in the file while the recording goes on. */
static void is_there_soon(void **state)
{
    (void)state;
    struct trk_log log;
    assert_true(trk_synthesise(4, 1, &log));
    struct trk_sample *samples = samples_of(&log);
    assert_non_null(samples);
    struct trk_recorder *recorder = open_new();
    for (size_t i = 0; i < log.count; i++) trk_recorder_append(recorder, &samples[i]);
    await_written(recorder, log.count);
    reads_as(samples, log.count);
    assert_true(trk_recorder_close(recorder, NULL));
    free(samples);
    trk_log_finish(&log);
}

/* Samples that no log can hold are counted, and the log stays readable. */
static void refuses_impossible_samples(void **state)
{
    (void)state;
    struct trk_log log;
    struct trk_recorder_status after;
    assert_true(trk_synthesise(4, 1, &log));
    struct trk_sample *samples = samples_of(&log);
    assert_non_null(samples);
    struct trk_sample bad[7];
    for (int i = 0; i < 7; i++) bad[i] = samples[60];
    bad[0].sequence = samples[59].sequence;
    bad[1].device_ns = 0;
    bad[2].arrival_ns = 0;
    bad[3].direction[0] = NAN;
    bad[4].direction[1] = 2;
    bad[5].head[6] += 1;
    bad[6].device_ns = UINT64_MAX;
    struct trk_recorder *recorder = open_new();
    for (int i = 0; i < 60; i++) trk_recorder_append(recorder, &samples[i]);
    for (int i = 0; i < 7; i++) trk_recorder_append(recorder, &bad[i]);
    for (int i = 60; i < 120; i++) trk_recorder_append(recorder, &samples[i]);
    assert_true(trk_recorder_close(recorder, &after));
    assert_int_equal(after.refused, 7);
    assert_int_equal(after.written, 120);
    reads_as(samples, 120);
    free(samples);
    trk_log_finish(&log);
}

/* The child process of survives_a_kill(): it records at 500 Hz without end, and reports after each sample how
 * many are written. */
static void record_for_ever(int pipe_fd)
{
    struct trk_recorder_status now;
    struct trk_recorder *recorder = open_new();
    for (uint64_t i = 1;; i++) {
        struct trk_sample sample = {
            .sequence = i, .device_ns = monotonic_ns(), .valid = TRK_DIRECTION, .direction = {0, 0, -1}};
        sample.arrival_ns = sample.device_ns;
        trk_recorder_append(recorder, &sample);
        trk_recorder_get_status(recorder, &now);
        if (write(pipe_fd, &now.written, sizeof now.written) != sizeof now.written) _exit(1);
        sleep_ms(2);
    }
}

/* If the program is killed while it records, the log holds all samples that were reported as written, whole
 * and in order. */
static void survives_a_kill(void **state)
{
    (void)state;
    for (int round = 0; round < 3; round++) {
        int pipe_fd[2];
        assert_int_equal(pipe(pipe_fd), 0);
        unlink(path);
        pid_t child = fork();
        assert_true(child >= 0);
        if (child == 0) record_for_ever(pipe_fd[1]);
        close(pipe_fd[1]);
        uint64_t written = 0, appended = 0, more;
        while (written < 300 + 70 * (uint64_t)round) {
            assert_int_equal(read(pipe_fd[0], &written, sizeof written), sizeof written);
            appended++;
        }
        assert_int_equal(kill(child, SIGKILL), 0);
        for (; read(pipe_fd[0], &more, sizeof more) == sizeof more; appended++) written = more;
        close(pipe_fd[0]);
        int status;
        assert_int_equal(waitpid(child, &status, 0), child);
        assert_true(WIFSIGNALED(status));

        struct trk_log back;
        if (!trk_log_read(path, &back, error)) fail_msg("%s", error);
        const struct trk_sample *newest = sample_at(&back, back.count - 1);
        assert_int_equal(newest->sequence, back.count); /* no earlier one is missing */
        print_message("%zu of %llu samples are kept, %llu were said to be\n", back.count,
                      (unsigned long long)appended, (unsigned long long)written);
        /* The child may have been killed after it appended the last sample and before it reported it. */
        assert_in_range(back.count, written, appended + 1);
        trk_log_finish(&back);
    }
}

/* A log whose last line is cut at any byte loses that sample and no other. */
static void torn_anywhere(void **state)
{
    (void)state;
    struct trk_log log;
    struct stat whole, less;
    assert_true(trk_synthesise(4, 1, &log));
    struct trk_sample *samples = samples_of(&log);
    assert_non_null(samples);
    for (int n = 10; n <= 11; n++) {
        struct trk_recorder *recorder = open_new();
        for (int i = 0; i < n; i++) trk_recorder_append(recorder, &samples[i]);
        assert_true(trk_recorder_close(recorder, NULL));
        assert_int_equal(stat(path, n == 10 ? &less : &whole), 0);
    }
    for (off_t size = whole.st_size - 1; size >= less.st_size; size--) {
        struct trk_log back;
        assert_int_equal(truncate(path, size), 0);
        reads_as(samples, 10);
        assert_true(trk_log_read(path, &back, error));
        assert_string_equal(back.assumed, size > less.st_size ? "line 13 was cut off and is left out" : "");
        trk_log_finish(&back);
    }
    free(samples);
    trk_log_finish(&log);
}

/* The disk is full: the recorder removes a row that was half written, reports the reason at once, and keeps
 * what is in the file. When there is room again, it goes on with the samples that have waited. */
static void full_disk(void **state)
{
    (void)state;
    struct trk_log log;
    struct trk_recorder_status after;
    struct rlimit before, small;
    assert_true(trk_synthesise(4, 3, &log));
    struct trk_sample *samples = samples_of(&log);
    assert_non_null(samples);
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
    small = before;
    small.rlim_cur = 20000;
    signal(SIGXFSZ, SIG_IGN);
    for (int round = 0; round < 2; round++) {
        struct trk_recorder *recorder = open_new();
        assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
        for (size_t i = 0; i < 10; i++) trk_recorder_append(recorder, &samples[i]);
        await_written(recorder, 10);
        for (size_t i = 10; i < 300; i++) trk_recorder_append(recorder, &samples[i]);
        do {
            sleep_ms(10);
            trk_recorder_get_status(recorder, &after);
        } while (!after.failing);
        assert_true(strstr(after.error, path) && strstr(after.error, "File too large"));
        assert_true(after.written >= 10 && after.written < 300);
        assert_int_equal(after.lost, 0); /* as yet */
        reads_as(samples, after.written);
        if (round == 1) {
            assert_int_equal(setrlimit(RLIMIT_FSIZE, &before), 0);
            await_recovery(recorder, 300);
            for (size_t i = 300; i < log.count; i++) trk_recorder_append(recorder, &samples[i]);
        }
        assert_int_equal(trk_recorder_close(recorder, &after), round == 1);
        setrlimit(RLIMIT_FSIZE, &before);
        assert_int_equal(after.lost, round == 1 ? 0 : 300 - after.written);
        if (round == 1) assert_int_equal(after.written, log.count);
        reads_as(samples, after.written);
    }
    signal(SIGXFSZ, SIG_DFL);
    free(samples);
    trk_log_finish(&log);
}

/* Samples that no longer fit into the queue while the disk is full are lost and counted. The log goes on
 * after them. */
static void full_disk_for_long(void **state)
{
    (void)state;
    struct trk_recorder_status after;
    struct rlimit before, none;
    struct trk_sample sample = {.sequence = 0};
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
    none = before;
    none.rlim_cur = 0;
    struct trk_recorder *recorder = open_new();
    signal(SIGXFSZ, SIG_IGN);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &none), 0);
    do {
        sample.sequence = sample.device_ns = sample.arrival_ns = sample.sequence + 1;
        trk_recorder_append(recorder, &sample);
        trk_recorder_get_status(recorder, &after);
    } while (after.lost < 10);
    const uint64_t waiting = sample.sequence - 10;
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &before), 0);
    signal(SIGXFSZ, SIG_DFL);
    await_recovery(recorder, waiting);
    sample.sequence = sample.device_ns = sample.arrival_ns = sample.sequence + 1;
    trk_recorder_append(recorder, &sample);
    assert_false(trk_recorder_close(recorder, &after));
    assert_int_equal(after.lost, 10);
    assert_int_equal(after.written, waiting + 1);
    struct trk_log back;
    if (!trk_log_read(path, &back, error)) fail_msg("%s", error);
    assert_int_equal(back.count, waiting + 1);
    assert_int_equal(sample_at(&back, waiting)->sequence, waiting + 11);
    trk_log_finish(&back);
}

/* Samples come faster than any disk can write: those that do not fit into the queue are counted. */
static void counts_what_it_loses(void **state)
{
    (void)state;
    struct trk_recorder_status after = {0};
    struct trk_recorder *recorder = open_new();
    uint64_t count = 0;
    while (!after.lost) {
        for (int i = 0; i < 10000; i++) {
            count++;
            struct trk_sample sample = {.sequence = count, .device_ns = count, .arrival_ns = count};
            trk_recorder_append(recorder, &sample);
        }
        trk_recorder_get_status(recorder, &after);
    }
    assert_false(trk_recorder_close(recorder, &after));
    assert_non_null(strstr(after.error, "too slow"));
    print_message("%llu lost of %llu at full speed\n", (unsigned long long)after.lost,
                  (unsigned long long)count);
    assert_int_equal(after.written + after.lost, count);
    struct trk_log back;
    if (!trk_log_read(path, &back, error)) fail_msg("%s", error);
    assert_int_equal(back.count, after.written);
    trk_log_finish(&back);
}

static struct trk_recorder *shared;

static void *append_some(void *argument)
{
    struct trk_sample sample = {.sequence = 0};
    struct trk_recorder_status now;
    (void)argument;
    for (uint64_t i = 1; i <= 2000; i++) {
        sample.sequence = sample.device_ns = sample.arrival_ns = i;
        trk_recorder_append(shared, &sample);
        if (i % 100 == 0) trk_recorder_get_status(shared, &now), sleep_ms(1);
    }
    return NULL;
}

/* Two threads may append: each sequence number is recorded once. */
static void two_threads(void **state)
{
    (void)state;
    struct trk_recorder_status after;
    pthread_t threads[2];
    shared = open_new();
    for (int i = 0; i < 2; i++) assert_int_equal(pthread_create(&threads[i], NULL, append_some, NULL), 0);
    for (int i = 0; i < 2; i++) pthread_join(threads[i], NULL);
    assert_true(trk_recorder_close(shared, &after));
    assert_int_equal(after.written + after.refused + after.lost, 4000);
    assert_true(after.written <= 2000);
}

int main(void)
{
#define TEST(f) cmocka_unit_test_setup_teardown(f, enter, leave)
    const struct CMUnitTest tests[] = {
        TEST(records_every_field), TEST(is_there_soon),        TEST(refuses_impossible_samples),
        TEST(survives_a_kill),     TEST(torn_anywhere),        TEST(full_disk),
        TEST(full_disk_for_long),  TEST(counts_what_it_loses), TEST(two_threads),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
