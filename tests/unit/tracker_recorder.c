/* The recorder: every sample, whatever happens to the program; refusals; a disk that is full. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "tracker.h"

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

static struct trk_recorder *open_new(bool replace)
{
    struct trk_recorder *recorder = trk_recorder_open(path, replace, error);
    if (!recorder) fail_msg("%s", error);
    return recorder;
}

/* Until the recorder, by itself, has written so many samples. */
static void await_written(struct trk_recorder *recorder, uint64_t count)
{
    struct trk_recorder_state now;
    for (;;) {
        trk_recorder_look(recorder, &now);
        assert_false(now.failed);
        if (now.written >= count) return;
        sleep_ms(10);
    }
}

static void reads_as(const struct trk_sample *samples, size_t count)
{
    struct trk_log back;
    if (!trk_log_read(path, &back, error)) fail_msg("%s", error);
    assert_int_equal(back.count, count);
    assert_memory_equal(back.samples, samples, count * sizeof *samples);
    trk_log_finish(&back);
}

static void records_every_field(void **state)
{
    (void)state;
    struct trk_log log;
    struct trk_recorder_state after;
    assert_true(trk_synthesise(4, 20, &log));
    log.samples[7].valid |= TRK_SCREEN;
    log.samples[7].screen[0] = 0.25f;
    log.samples[7].screen[1] = -0.1f;
    struct trk_recorder *recorder = open_new(false);
    for (size_t i = 0; i < log.count; i++) trk_recorder_append(recorder, &log.samples[i]);
    assert_true(trk_recorder_close(recorder, &after, error));
    assert_int_equal(after.written, log.count);
    assert_int_equal(after.dropped + after.refused, 0);
    reads_as(log.samples, log.count);
    trk_log_finish(&log);
}

/* Rows are in the file, for anyone to read, while the recording goes on. */
static void is_there_soon(void **state)
{
    (void)state;
    struct trk_log log;
    assert_true(trk_synthesise(4, 1, &log));
    struct trk_recorder *recorder = open_new(false);
    for (size_t i = 0; i < log.count; i++) trk_recorder_append(recorder, &log.samples[i]);
    await_written(recorder, log.count);
    reads_as(log.samples, log.count);
    assert_true(trk_recorder_close(recorder, NULL, error));
    trk_log_finish(&log);
}

static void refuses_what_is_there(void **state)
{
    (void)state;
    struct trk_log log;
    assert_true(trk_synthesise(4, 1, &log));
    struct trk_recorder *recorder = open_new(false);
    trk_recorder_append(recorder, &log.samples[0]);
    assert_null(trk_recorder_open(path, true, error)); /* in use */
    assert_non_null(strstr(error, "is being recorded already"));
    assert_true(trk_recorder_close(recorder, NULL, error));
    assert_null(trk_recorder_open(path, false, error));
    assert_true(strstr(error, path) && strstr(error, "exists"));
    reads_as(log.samples, 1);
    recorder = open_new(true);
    trk_recorder_append(recorder, &log.samples[1]);
    assert_true(trk_recorder_close(recorder, NULL, error));
    reads_as(log.samples + 1, 1);
    trk_log_finish(&log);

    assert_null(trk_recorder_open(dir, true, error));
    assert_non_null(strstr(error, dir));
    assert_null(trk_recorder_open("/dev/null", true, error));
    assert_non_null(strstr(error, "not a regular file"));
    assert_null(trk_recorder_open("absent/x.gaze", false, error));
    assert_non_null(strstr(error, "No such file"));
    unlink(path);
    assert_int_equal(mkfifo(path, 0600), 0);
    assert_null(trk_recorder_open(path, true, error)); /* and does not wait for a reader */
}

/* What no log can hold is counted, and the log stays readable. */
static void refuses_impossible_samples(void **state)
{
    (void)state;
    struct trk_log log;
    struct trk_recorder_state after;
    assert_true(trk_synthesise(4, 1, &log));
    struct trk_sample bad[7];
    for (int i = 0; i < 7; i++) bad[i] = log.samples[60];
    bad[0].sequence = log.samples[59].sequence;
    bad[1].device_ns = 0;
    bad[2].arrival_ns = 0;
    bad[3].direction[0] = NAN;
    bad[4].direction[1] = 2;
    bad[5].head[6] += 1;
    bad[6].device_ns = UINT64_MAX;
    struct trk_recorder *recorder = open_new(false);
    for (int i = 0; i < 60; i++) trk_recorder_append(recorder, &log.samples[i]);
    for (int i = 0; i < 7; i++) trk_recorder_append(recorder, &bad[i]);
    for (int i = 60; i < 120; i++) trk_recorder_append(recorder, &log.samples[i]);
    assert_true(trk_recorder_close(recorder, &after, error));
    assert_int_equal(after.refused, 7);
    assert_int_equal(after.written, 120);
    reads_as(log.samples, 120);
    trk_log_finish(&log);
}

/* The child's end of survives_a_kill(): records at 500 Hz for ever, and says after each sample how many are
 * written. */
static void record_for_ever(int pipe_fd)
{
    struct trk_recorder_state now;
    struct trk_recorder *recorder = trk_recorder_open(path, false, error);
    if (!recorder) _exit(1);
    for (uint64_t i = 1;; i++) {
        struct trk_sample sample = {
            .sequence = i, .device_ns = monotonic_ns(), .valid = TRK_DIRECTION, .direction = {0, 0, -1}};
        sample.arrival_ns = sample.device_ns;
        trk_recorder_append(recorder, &sample);
        trk_recorder_look(recorder, &now);
        if (write(pipe_fd, &now.written, sizeof now.written) != sizeof now.written) _exit(1);
        sleep_ms(2);
    }
}

/* Killed in mid-recording, the log holds all that was said to be written, whole and in order. */
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
        const struct trk_sample *newest = &back.samples[back.count - 1];
        assert_int_equal(newest->sequence, back.count); /* none is missing before */
        print_message("%zu of %llu samples are kept, %llu were said to be\n", back.count,
                      (unsigned long long)appended, (unsigned long long)written);
        /* The last may have been appended and not told. */
        assert_in_range(back.count, written, appended + 1);
        trk_log_finish(&back);
    }
}

/* Torn at any byte of its last line, a log loses that sample and no other. */
static void torn_anywhere(void **state)
{
    (void)state;
    struct trk_log log;
    struct stat whole, less;
    assert_true(trk_synthesise(4, 1, &log));
    for (int n = 10; n <= 11; n++) {
        struct trk_recorder *recorder = open_new(true);
        for (int i = 0; i < n; i++) trk_recorder_append(recorder, &log.samples[i]);
        assert_true(trk_recorder_close(recorder, NULL, error));
        assert_int_equal(stat(path, n == 10 ? &less : &whole), 0);
    }
    for (off_t size = whole.st_size - 1; size >= less.st_size; size--) {
        struct trk_log back;
        assert_int_equal(truncate(path, size), 0);
        reads_as(log.samples, 10);
        assert_true(trk_log_read(path, &back, error));
        assert_string_equal(back.assumed, size > less.st_size ? "line 13 was cut off and is left out" : "");
        trk_log_finish(&back);
    }
    trk_log_finish(&log);
}

/* A disk that takes no more: half a row is taken back, the rest counted, the reason told, what was written
 * kept. */
static void full_disk(void **state)
{
    (void)state;
    struct trk_log log;
    struct trk_recorder_state after;
    struct rlimit before, small;
    assert_true(trk_synthesise(4, 2, &log));
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
    small = before;
    small.rlim_cur = 20000;
    signal(SIGXFSZ, SIG_IGN);
    struct trk_recorder *recorder = open_new(false);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
    for (size_t i = 0; i < 10; i++) trk_recorder_append(recorder, &log.samples[i]);
    await_written(recorder, 10);
    for (size_t i = 10; i < log.count; i++) trk_recorder_append(recorder, &log.samples[i]);
    bool ok = trk_recorder_close(recorder, &after, error);
    setrlimit(RLIMIT_FSIZE, &before);
    signal(SIGXFSZ, SIG_DFL);
    assert_false(ok);
    assert_true(strstr(error, path) && strstr(error, "File too large"));
    assert_true(after.failed && after.dropped > 0);
    assert_int_equal(after.written + after.dropped, log.count);
    assert_true(after.written >= 10);
    reads_as(log.samples, after.written);
    trk_log_finish(&log);
}

/* Faster than any disk: what does not fit into the queue is counted. */
static void counts_what_it_drops(void **state)
{
    (void)state;
    struct trk_recorder_state after = {0};
    struct trk_recorder *recorder = open_new(false);
    uint64_t count = 0;
    while (!after.dropped) {
        for (int i = 0; i < 10000; i++) {
            count++;
            struct trk_sample sample = {.sequence = count, .device_ns = count, .arrival_ns = count};
            trk_recorder_append(recorder, &sample);
        }
        trk_recorder_look(recorder, &after);
    }
    assert_true(trk_recorder_close(recorder, &after, error));
    print_message("%llu dropped of %llu at full speed\n", (unsigned long long)after.dropped,
                  (unsigned long long)count);
    assert_int_equal(after.written + after.dropped, count);
    struct trk_log back;
    if (!trk_log_read(path, &back, error)) fail_msg("%s", error);
    assert_int_equal(back.count, after.written);
    trk_log_finish(&back);
}

static struct trk_recorder *shared;

static void *append_some(void *argument)
{
    struct trk_sample sample = {.sequence = 0};
    struct trk_recorder_state now;
    (void)argument;
    for (uint64_t i = 1; i <= 2000; i++) {
        sample.sequence = sample.device_ns = sample.arrival_ns = i;
        trk_recorder_append(shared, &sample);
        if (i % 100 == 0) trk_recorder_look(shared, &now), sleep_ms(1);
    }
    return NULL;
}

/* Two threads may append; each number is taken once. */
static void two_threads(void **state)
{
    (void)state;
    struct trk_recorder_state after;
    pthread_t threads[2];
    shared = open_new(false);
    for (int i = 0; i < 2; i++) assert_int_equal(pthread_create(&threads[i], NULL, append_some, NULL), 0);
    for (int i = 0; i < 2; i++) pthread_join(threads[i], NULL);
    assert_true(trk_recorder_close(shared, &after, error));
    assert_int_equal(after.written + after.refused + after.dropped, 4000);
    assert_true(after.written <= 2000);
}

int main(void)
{
#define TEST(f) cmocka_unit_test_setup_teardown(f, enter, leave)
    const struct CMUnitTest tests[] = {
        TEST(records_every_field),
        TEST(is_there_soon),
        TEST(refuses_what_is_there),
        TEST(refuses_impossible_samples),
        TEST(survives_a_kill),
        TEST(torn_anywhere),
        TEST(full_disk),
        TEST(counts_what_it_drops),
        TEST(two_threads),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
