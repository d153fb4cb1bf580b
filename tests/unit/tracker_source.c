/* Sources: how they are chosen, paced, interrupted and fed. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "log/samples.h"
#include "tracker.h"
#include "tracker_samples.h"
#include "tracker_write.h"

#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

static const char *path = "tracker_source.gaze";

/* Write a log with samples at these times. Its sequence starts at 11 and lacks one number. */
static const uint64_t times[] = {1000, 1000, 3000, 10000, 16000};
enum { COUNT = 5, LAP_NS = 15000 + 15000 / 4 };

static int write_log(void **state)
{
    (void)state;
    struct trk_log log;
    if (!trk_synthesise(3, COUNT / 120.0, &log)) return -1;
    for (size_t i = 0; i < COUNT; i++) {
        struct trk_sample sample = *sample_at(&log, i);
        sample.device_ns = sample.arrival_ns = times[i];
        sample.sequence = i < 2 ? 11 + i : 12 + i;
        if (!trk_samples_put(&log, i, &sample)) return -1;
    }
    bool ok = written(&log, path);
    trk_log_finish(&log);
    return ok ? 0 : -1;
}

static int remove_log(void **state)
{
    (void)state;
    return unlink(path);
}

static struct trk_source *open_source(struct trk_source_options options)
{
    char error[TRK_ERROR_SIZE] = "";
    struct trk_source *source = trk_open(&options, error);
    if (!source) fail_msg("%s", error);
    return source;
}

static void refused(struct trk_source_options options, const char *why)
{
    char error[TRK_ERROR_SIZE] = "";
    assert_null(trk_open(&options, error));
    if (!strstr(error, why)) fail_msg("'%s' should say '%s'", error, why);
}

/* The next sample on the virtual clock is due at time_ns, not earlier. */
static void due(struct trk_source *source, uint64_t time_ns, struct trk_sample *out_sample)
{
    char error[TRK_ERROR_SIZE];
    if (time_ns > 0) assert_int_equal(trk_read(source, time_ns - 1, out_sample, error), TRK_TIMEOUT);
    assert_int_equal(trk_read(source, time_ns, out_sample, error), TRK_SAMPLE);
    assert_int_equal(out_sample->arrival_ns, time_ns);
}

static void ended(struct trk_source *source)
{
    char error[TRK_ERROR_SIZE];
    struct trk_sample sample;
    assert_int_equal(trk_read(source, UINT64_MAX, &sample, error), TRK_END);
    assert_int_equal(trk_read(source, UINT64_MAX, &sample, error), TRK_END);
    trk_close(source);
}

static void replay_keeps_the_logs_pace(void **state)
{
    (void)state;
    static const double speeds[] = {1, 2, 0.5};
    for (int k = 0; k < 3; k++) {
        struct trk_source *source = open_source((struct trk_source_options){
            .spec = "replay:tracker_source.gaze", .speed = speeds[k], .virtual_clock = true});
        for (size_t i = 0; i < COUNT; i++) {
            struct trk_sample sample;
            if (i == 1) { /* has the same time as the first sample */
                char error[TRK_ERROR_SIZE];
                assert_int_equal(trk_read(source, 0, &sample, error), TRK_SAMPLE);
            } else {
                due(source, (uint64_t)((double)(times[i] - times[0]) / speeds[k]), &sample);
            }
            assert_int_equal(sample.device_ns, times[i]);
            assert_int_equal(sample.sequence, i < 2 ? 1 + i : 2 + i);
        }
        ended(source);
    }
}

static void replay_without_pace(void **state)
{
    (void)state;
    struct trk_source *source =
        open_source((struct trk_source_options){.spec = "replay:tracker_source.gaze", .virtual_clock = true});
    char error[TRK_ERROR_SIZE];
    struct trk_sample sample;
    for (size_t i = 0; i < COUNT; i++) {
        assert_int_equal(trk_read(source, 5, &sample, error), TRK_SAMPLE);
        assert_int_equal(sample.arrival_ns, 5);
        assert_int_equal(sample.device_ns, times[i]);
    }
    ended(source);
}

static void replay_again_and_again(void **state)
{
    (void)state;
    struct trk_source *source = open_source((struct trk_source_options){
        .spec = "replay:tracker_source.gaze", .speed = 1, .loop = true, .virtual_clock = true});
    char error[TRK_ERROR_SIZE];
    struct trk_sample sample;
    for (uint64_t lap = 0; lap < 3; lap++)
        for (size_t i = 0; i < COUNT; i++) {
            uint64_t time_ns = lap * LAP_NS + times[i] - times[0];
            if (i == 1)
                assert_int_equal(trk_read(source, time_ns, &sample, error), TRK_SAMPLE);
            else
                due(source, time_ns, &sample);
            assert_int_equal(sample.device_ns, lap * LAP_NS + times[i]);
            assert_int_equal(sample.sequence, lap * 6 + (i < 2 ? 1 + i : 2 + i));
        }
    trk_close(source);
}

/* On the real clock, samples do not arrive before they are due. How much later they arrive depends on the
 * machine. */
static void replay_on_the_real_clock(void **state)
{
    (void)state;
    struct trk_source *source =
        open_source((struct trk_source_options){.spec = "replay:tracker_source.gaze", .speed = 0.01});
    char error[TRK_ERROR_SIZE];
    struct trk_sample sample;
    uint64_t first_ns = 0;
    for (size_t i = 0; i < COUNT; i++) {
        assert_int_equal(trk_read(source, UINT64_MAX, &sample, error), TRK_SAMPLE);
        if (i == 0) first_ns = sample.arrival_ns;
        assert_int_equal(sample.arrival_ns - first_ns, (times[i] - times[0]) * 100);
        struct timespec now;
        clock_gettime(CLOCK_MONOTONIC, &now);
        assert_true((uint64_t)now.tv_sec * 1000000000 + (uint64_t)now.tv_nsec >= sample.arrival_ns);
    }
    ended(source);
}

static void real_clock_times_out(void **state)
{
    (void)state;
    struct trk_source *source = open_source((struct trk_source_options){.spec = "pointer"});
    char error[TRK_ERROR_SIZE];
    struct trk_sample sample;
    struct timespec now;
    assert_int_equal(trk_read(source, 0, &sample, error), TRK_TIMEOUT);
    clock_gettime(CLOCK_MONOTONIC, &now);
    uint64_t until_ns = (uint64_t)now.tv_sec * 1000000000 + (uint64_t)now.tv_nsec + 2000000;
    assert_int_equal(trk_read(source, until_ns, &sample, error), TRK_TIMEOUT);
    clock_gettime(CLOCK_MONOTONIC, &now);
    assert_true((uint64_t)now.tv_sec * 1000000000 + (uint64_t)now.tv_nsec >= until_ns);
    trk_close(source);
}

static void *read_for_ever(void *argument)
{
    char error[TRK_ERROR_SIZE];
    struct trk_sample sample;
    while (trk_read(argument, UINT64_MAX, &sample, error) == TRK_SAMPLE) continue;
    return argument;
}

/* Without an interrupt these reads never end. The replay waits nearly a second for each sample. */
static void interrupt_wakes(void **state)
{
    (void)state;
    static const char *const specs[] = {"pointer", "replay:" FIXTURES "/hall.gaze", "synthetic"};
    for (int k = 0; k < 3; k++) {
        struct trk_source *source =
            open_source((struct trk_source_options){.spec = specs[k], .speed = 0.01, .loop = true});
        for (int before = 0; before < 2; before++) {
            pthread_t thread;
            if (before) trk_interrupt(source); /* nobody waits yet, so the next wait ends at once */
            assert_int_equal(pthread_create(&thread, NULL, read_for_ever, source), 0);
            if (!before) {
                nanosleep(&(struct timespec){.tv_nsec = 5000000}, NULL);
                trk_interrupt(source);
            }
            void *result;
            assert_int_equal(pthread_join(thread, &result), 0);
            assert_ptr_equal(result, source);
        }
        trk_close(source);
    }
}

static void pointer_delivers_in_order(void **state)
{
    (void)state;
    struct trk_source *source = open_source((struct trk_source_options){.spec = "pointer"});
    char error[TRK_ERROR_SIZE];
    struct trk_sample sample;
    float world[3];
    assert_int_equal(trk_read(source, 0, &sample, error), TRK_TIMEOUT);
    assert_true(trk_push(source, (float[3]){0, 0, -2}, 100));
    assert_true(trk_push(source, (float[3]){1e-30f, 0, 0}, 200));
    assert_true(trk_push(source, (float[3]){0, 3e38f, 0}, 150)); /* a time that goes back is held */
    assert_int_equal(trk_read(source, 0, &sample, error), TRK_SAMPLE);
    assert_int_equal(sample.arrival_ns, 100);
    assert_int_equal(sample.device_ns, 0);
    assert_int_equal(sample.valid, TRK_DIRECTION);
    assert_true(trk_world_direction(&sample, world));
    assert_true(world[0] == 0 && world[1] == 0 && world[2] == -1);
    assert_int_equal(trk_read(source, 0, &sample, error), TRK_SAMPLE);
    assert_int_equal(sample.arrival_ns, 200);
    assert_true(sample.direction[0] == 1);
    assert_int_equal(trk_read(source, 0, &sample, error), TRK_SAMPLE);
    assert_int_equal(sample.arrival_ns, 200);
    assert_int_equal(sample.sequence, 3);
    assert_true(sample.direction[1] == 1);
    trk_close(source);
}

static void pointer_refuses_what_is_no_direction(void **state)
{
    (void)state;
    struct trk_source *source = open_source((struct trk_source_options){.spec = "pointer"});
    char error[TRK_ERROR_SIZE];
    struct trk_sample sample;
    assert_false(trk_push(source, (float[3]){0, 0, 0}, 1));
    assert_false(trk_push(source, (float[3]){0, NAN, 1}, 1));
    assert_false(trk_push(source, (float[3]){INFINITY, 0, 0}, 1));
    assert_int_equal(trk_read(source, 0, &sample, error), TRK_TIMEOUT);
    trk_close(source);
    source =
        open_source((struct trk_source_options){.spec = "replay:tracker_source.gaze", .virtual_clock = true});
    assert_false(trk_push(source, (float[3]){0, 0, -1}, 1));
    trk_close(source);
}

/* More samples than the queue holds: the oldest are dropped, and the gap in the sequence tells how many. */
static void pointer_drops_the_oldest(void **state)
{
    (void)state;
    struct trk_source *source = open_source((struct trk_source_options){.spec = "pointer"});
    char error[TRK_ERROR_SIZE];
    struct trk_sample sample;
    for (int i = 1; i <= 5000; i++) assert_true(trk_push(source, (float[3]){(float)i, 0, -1}, (uint64_t)i));
    uint64_t first = 0, last = 0;
    while (trk_read(source, 0, &sample, error) == TRK_SAMPLE) {
        if (!first) first = sample.sequence;
        if (last) assert_int_equal(sample.sequence, last + 1);
        last = sample.sequence;
        assert_int_equal(sample.arrival_ns, sample.sequence);
    }
    assert_true(first > 1000);
    assert_int_equal(last, 5000);
    trk_close(source);
}

enum { PUSHES = 2000 };

static void *push_many(void *source)
{
    for (int i = 0; i < PUSHES; i++) trk_push(source, (float[3]){0, 0, -1}, (uint64_t)i);
    return NULL;
}

static void pointer_takes_from_many_threads(void **state)
{
    (void)state;
    struct trk_source *source = open_source((struct trk_source_options){.spec = "pointer"});
    char error[TRK_ERROR_SIZE];
    struct trk_sample sample = {0};
    pthread_t threads[2];
    for (int i = 0; i < 2; i++) assert_int_equal(pthread_create(&threads[i], NULL, push_many, source), 0);
    uint64_t last = 0;
    while (last < 2 * PUSHES) {
        assert_int_equal(trk_read(source, UINT64_MAX, &sample, error), TRK_SAMPLE);
        assert_true(sample.sequence > last);
        last = sample.sequence;
    }
    for (int i = 0; i < 2; i++) pthread_join(threads[i], NULL);
    trk_close(source);
}

static void auto_replays_without_a_device(void **state)
{
    (void)state;
    struct trk_source *source = open_source(
        (struct trk_source_options){.spec = "auto", .fallback_log = path, .speed = 1, .virtual_clock = true});
    struct trk_status status;
    trk_get_status(source, &status);
    assert_string_equal(status.description, "replay of tracker_source.gaze: 5 samples, 0.0 s, 266667 Hz, "
                                            "head pose (no eye tracker on the virtual clock)");
    struct trk_sample sample;
    due(source, 0, &sample);
    trk_close(source);
    refused((struct trk_source_options){.spec = "auto"}, "no eye tracker found");
    refused((struct trk_source_options){.spec = "auto", .fallback_log = "absent.gaze"},
            "absent.gaze: No such file");
}

/* How fast a source's clock runs: a replay runs at its pace, also when it stands in for a device. */
static void status_tells_the_pace(void **state)
{
    (void)state;
    static const struct {
        const char *spec;
        double speed, told;
    } cases[] = {
        {"replay:tracker_source.gaze", 0.1, 0.1},
        {"replay:tracker_source.gaze", 0, 0},
        {"auto", 0.25, 0.25},
        {"synthetic", 0.1, 1},
        {"pointer", 0.1, 1},
        {"hid", 0.1, 1},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct trk_source *source = open_source((struct trk_source_options){
            .spec = cases[i].spec, .speed = cases[i].speed, .fallback_log = FIXTURES "/hall.gaze"});
        struct trk_status status;
        trk_get_status(source, &status);
        assert_true(status.speed == (status.is_device ? 1 : cases[i].told));
        trk_close(source);
    }
}

static void bad_specs(void **state)
{
    (void)state;
    static const struct {
        const char *spec, *why;
    } cases[] = {
        {"", "unknown gaze source '', expected one of auto, hid[:PATH], psvr2, "},
        {"hid9", "unknown gaze source 'hid9'"},
        {"replayed:x", "unknown gaze source 'replayed:x'"},
        {"auto:x", "'auto:x': expected auto, which takes no argument"},
        {"hid:", "'hid:': expected hid[:PATH], an absolute path"},
        {"hid:hidraw0", "'hid:hidraw0': expected hid[:PATH], an absolute path"},
        {"hid:/dev/null", "/dev/null: no eye tracker"},
        {"psvr2:1", "'psvr2:1': expected psvr2"},
        {"replay", "expected replay:FILE"},
        {"replay:", "expected replay:FILE"},
        {"replay:absent.gaze", "absent.gaze: No such file"},
        {"pointer:1", "takes no argument"},
        {"synthetic:", "expected a whole number"},
        {"synthetic:-1", "expected a whole number"},
        {"synthetic:1x", "expected a whole number"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        refused((struct trk_source_options){.spec = cases[i].spec, .speed = 1}, cases[i].why);
    static const double bad[] = {-1, NAN, INFINITY, 1e-9, 1e9};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        refused((struct trk_source_options){.spec = "replay:tracker_source.gaze", .speed = bad[i]},
                "replay speed");
    static const struct trk_screen screens[] = {
        {0.5f, 0, 0}, {0, 0.3f, 0}, {-1, 1, 0}, {1, 1, NAN}, {1, 1, 1e9f}};
    for (size_t i = 0; i < sizeof screens / sizeof *screens; i++)
        refused((struct trk_source_options){.spec = "pointer", .screen = screens[i]}, "screen of");
    refused((struct trk_source_options){.spec = "hid", .virtual_clock = true}, "on the real clock");
    refused((struct trk_source_options){.spec = "pointer", .virtual_clock = true}, "on the real clock");
    trk_close(NULL);
}

/* Pauses do not count in the rate. */
static void says_the_rate_apart_from_pauses(void **state)
{
    (void)state;
    struct trk_source *source = open_source((struct trk_source_options){
        .spec = "replay:" FIXTURES "/../tests/cases/gaze/eyelink_left_blocks.asc", .virtual_clock = true});
    struct trk_status status;
    trk_get_status(source, &status);
    if (!strstr(status.description, "30 samples, 2.1 s, 250 Hz")) fail_msg("%s", status.description);
    trk_close(source);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(says_the_rate_apart_from_pauses),
        cmocka_unit_test(replay_keeps_the_logs_pace),
        cmocka_unit_test(replay_without_pace),
        cmocka_unit_test(replay_again_and_again),
        cmocka_unit_test(replay_on_the_real_clock),
        cmocka_unit_test(real_clock_times_out),
        cmocka_unit_test(interrupt_wakes),
        cmocka_unit_test(pointer_delivers_in_order),
        cmocka_unit_test(pointer_refuses_what_is_no_direction),
        cmocka_unit_test(pointer_drops_the_oldest),
        cmocka_unit_test(pointer_takes_from_many_threads),
        cmocka_unit_test(auto_replays_without_a_device),
        cmocka_unit_test(status_tells_the_pace),
        cmocka_unit_test(bad_specs),
    };
    return cmocka_run_group_tests(tests, write_log, remove_log);
}
