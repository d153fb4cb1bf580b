/* What every gaze source must do: order, time, waiting, interrupts, status, the end, and being closed while
 * it is read. The tests run over all sources of the table.
 *
 * Without arguments no tracker is present, and devices are tested as sources that wait. Among fake trackers,
 * the arguments name the kinds that are plugged in; these must deliver like all other sources. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "tracker.h"

#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

struct kind {
    const struct trk_source_kind *row;
    char spec[sizeof "replay:" FIXTURES "/hall.gaze"];
    bool waits, is_pushed; /* delivers nothing without a device; delivers what is pushed */
    bool present;          /* of devices: it is plugged in */
};

/* Every row of the table, so that a new kind of source is tested without a change here. */
static struct kind kinds[32];
static int kinds_count;

static void find_kinds(void)
{
    const struct trk_source_kind *row;
    for (; (row = trk_source_kind_at((size_t)kinds_count)); kinds_count++) {
        struct kind *kind = &kinds[kinds_count];
        assert_true(kinds_count < (int)(sizeof kinds / sizeof *kinds));
        *kind = (struct kind){.row = row, .is_pushed = !row->follows_eye};
        kind->waits = row->is_device && !row->ends;
        snprintf(kind->spec, sizeof kind->spec, "%s%s", row->name,
                 strchr(row->usage, ':') && !strchr(row->usage, '[') ? ":" FIXTURES "/hall.gaze" : "");
    }
}

static struct kind *kind_of(const char *name)
{
    for (int i = 0; i < kinds_count; i++)
        if (strcmp(kinds[i].row->name, name) == 0) return &kinds[i];
    return NULL;
}

static uint64_t now_ns(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * 1000000000 + (uint64_t)now.tv_nsec;
}

static void pause_ms(int ms)
{
    nanosleep(&(struct timespec){.tv_nsec = ms * 1000000L}, NULL);
}

/* Does it deliver samples without trk_push()? */
static bool delivers(const struct kind *kind)
{
    return !kind->is_pushed && (!kind->waits || kind->present);
}

static struct trk_source *open_kind(const struct kind *kind)
{
    char error[TRK_ERROR_SIZE] = "";
    struct trk_source_options options = {
        .spec = kind->spec, .fallback_log = FIXTURES "/hall.gaze", .speed = 1, .loop = true};
    struct trk_source *source = trk_open(&options, error);
    if (!source) fail_msg("%s: %s", kind->spec, error);
    return source;
}

static void refused(const char *spec, const char *expected)
{
    char error[TRK_ERROR_SIZE] = "";
    struct trk_source_options options = {.spec = spec, .speed = 1};
    assert_null(trk_open(&options, error));
    if (!strstr(error, expected)) fail_msg("%s: %s", spec, error);
}

/* A user may write what the rows say, and the message about an unknown name lists all of them. */
static void rows_say_how_to_write_them(void **state)
{
    (void)state;
    char unknown[512] = "unknown gaze source '?', expected one of ";
    for (int i = 0; i < kinds_count; i++) {
        const struct trk_source_kind *row = kinds[i].row;
        size_t end = strlen(unknown);
        char spec[64];
        snprintf(unknown + end, sizeof unknown - end, "%s%s", i ? ", " : "", row->usage);
        assert_ptr_equal(trk_source_kind_find(kinds[i].spec), row);
        assert_true(*row->summary && !strchr(row->summary, '\n'));
        snprintf(spec, sizeof spec, "%.50sx", row->name);
        assert_null(trk_source_kind_find(spec));
        snprintf(spec, sizeof spec, "%.50s:x", row->name);
        assert_true(strncmp(row->usage, row->name, strlen(row->name)) == 0);
        if (!strchr(row->usage, ':')) refused(spec, "which takes no argument");
        if (strcmp(kinds[i].spec, row->name) != 0) refused(row->name, row->usage);
    }
    refused("?", unknown);
    assert_null(trk_source_kind_find(""));
}

/* What a row says of devices is true of the open source. Whether a rotation of recentring is kept and used
 * depends on it. */
static void rows_tell_devices(void **state)
{
    (void)state;
    for (int i = 0; i < kinds_count; i++) {
        const struct trk_source_kind *row = kinds[i].row;
        struct trk_source *source = open_kind(&kinds[i]);
        struct trk_status status;
        trk_get_status(source, &status);
        assert_true(!status.is_device || row->is_device);
        if (row->is_device && !row->ends) assert_true(status.is_device);
        assert_true(row->is_device || !(row->takes_screen || row->takes_calibration || row->waits_after_end));
        assert_true(!row->is_device || row->follows_eye);
        trk_close(source);
    }
}

static void check_order(const struct kind *kind, const struct trk_sample *last,
                        const struct trk_sample *sample)
{
    const float *d = sample->direction;
    bool ok = sample->sequence > last->sequence && sample->device_ns >= last->device_ns &&
              sample->arrival_ns >= last->arrival_ns && sample->arrival_ns <= now_ns() &&
              sample->sensor_ns <= sample->arrival_ns;
    if (sample->valid & TRK_DIRECTION) ok &= fabsf(d[0] * d[0] + d[1] * d[1] + d[2] * d[2] - 1) < 1e-3f;
    if (!ok)
        fail_msg("%s: sample %llu at %llu follows %llu at %llu", kind->spec,
                 (unsigned long long)sample->sequence, (unsigned long long)sample->arrival_ns,
                 (unsigned long long)last->sequence, (unsigned long long)last->arrival_ns);
}

static void samples_are_in_order(void **state)
{
    (void)state;
    for (int i = 0; i < kinds_count; i++) {
        const struct kind *kind = &kinds[i];
        struct trk_source *source = open_kind(kind);
        struct trk_sample last = {0}, sample;
        char error[TRK_ERROR_SIZE] = "";
        const bool many = delivers(kind) || kind->is_pushed;
        int samples = 0;
        for (int reads = 0; many ? samples < 50 : reads < 50; reads++) {
            if (kind->is_pushed) assert_true(trk_push(source, (float[3]){0, 0, -1}, now_ns()));
            enum trk_result result = trk_read(source, now_ns() + 10000000, &sample, error);
            if (result != TRK_SAMPLE && result != TRK_TIMEOUT)
                fail_msg("%s: %d %s", kind->spec, result, error);
            if (result != TRK_SAMPLE) continue;
            check_order(kind, &last, &sample);
            last = sample;
            samples++;
        }
        if (!many && samples > 0) fail_msg("%s: %d samples of nothing", kind->spec, samples);
        trk_close(source);
    }
}

/* When nothing is due, a read returns at until_ns and not before. It also returns when until_ns has passed.
 */
static void reads_end_in_time(void **state)
{
    (void)state;
    for (int i = 0; i < kinds_count; i++) {
        struct trk_source *source = open_kind(&kinds[i]);
        struct trk_sample sample;
        char error[TRK_ERROR_SIZE];
        for (int k = 0; k < 20; k++) {
            uint64_t start_ns = now_ns(), until_ns = k % 2 ? start_ns + 3000000 : 0;
            enum trk_result result = trk_read(source, until_ns, &sample, error);
            uint64_t took_ns = now_ns() - start_ns;
            assert_true(result == TRK_SAMPLE || result == TRK_TIMEOUT);
            if (result == TRK_TIMEOUT) assert_true(start_ns + took_ns >= until_ns);
        }
        trk_close(source);
    }
}

struct reader {
    struct trk_source *source;
    atomic_bool stop;
    enum trk_result last;
};

static void *read_until_stopped(void *argument)
{
    struct reader *reader = argument;
    struct trk_sample sample;
    char error[TRK_ERROR_SIZE];
    while (!atomic_load(&reader->stop)) reader->last = trk_read(reader->source, UINT64_MAX, &sample, error);
    return NULL;
}

/* A program stops a reader this way: set a flag, interrupt, join, close. That works at any moment. Reads have
 * no time limit here, so a lost interrupt would hang the test. */
static void interrupt_ends_any_wait(void **state)
{
    (void)state;
    for (int i = 0; i < kinds_count; i++)
        for (int k = 0; k < 8; k++) {
            struct reader reader = {.source = open_kind(&kinds[i])};
            pthread_t thread;
            if (k == 0) trk_interrupt(reader.source);
            assert_int_equal(pthread_create(&thread, NULL, read_until_stopped, &reader), 0);
            if (k > 1) pause_ms(k);
            atomic_store(&reader.stop, true);
            trk_interrupt(reader.source);
            pthread_join(thread, NULL);
            assert_true(reader.last == TRK_TIMEOUT || reader.last == TRK_SAMPLE);
            trk_close(reader.source);
        }
}

static void interrupt_before_a_read(void **state)
{
    (void)state;
    for (int i = 0; i < kinds_count; i++) {
        struct trk_source *source = open_kind(&kinds[i]);
        struct trk_sample sample;
        char error[TRK_ERROR_SIZE];
        trk_interrupt(source);
        trk_interrupt(source);
        enum trk_result result = TRK_SAMPLE;
        while (result == TRK_SAMPLE) result = trk_read(source, UINT64_MAX, &sample, error);
        assert_int_equal(result, TRK_TIMEOUT);
        trk_close(source);
    }
}

/* Any thread may ask for the status while another one reads. The description is one line, and does not change
 * unless the source is a device. */
static void status_while_reading(void **state)
{
    (void)state;
    for (int i = 0; i < kinds_count; i++) {
        struct reader reader = {.source = open_kind(&kinds[i])};
        char first[TRK_ERROR_SIZE];
        struct trk_status status;
        pthread_t thread;
        trk_get_status(reader.source, &status);
        memcpy(first, status.description, sizeof first);
        assert_true(*first && !strchr(first, '\n'));
        assert_int_equal(pthread_create(&thread, NULL, read_until_stopped, &reader), 0);
        for (int k = 0; k < 20; k++) {
            trk_get_status(reader.source, &status);
            assert_true(*status.description && !strchr(status.description, '\n'));
            assert_true(!status.present || status.connections > 0);
            pause_ms(1);
        }
        if (kinds[i].waits) {
            assert_true(status.is_device);
            assert_int_equal(status.present, kinds[i].present);
        }
        atomic_store(&reader.stop, true);
        trk_interrupt(reader.source);
        pthread_join(thread, NULL);
        if (!kinds[i].row->is_device) assert_string_equal(status.description, first);
        trk_close(reader.source);
    }
}

static void only_a_pointer_is_pushed(void **state)
{
    (void)state;
    for (int i = 0; i < kinds_count; i++) {
        struct trk_source *source = open_kind(&kinds[i]);
        assert_int_equal(trk_push(source, (float[3]){0, 0, -1}, now_ns()), kinds[i].is_pushed);
        assert_false(trk_push(source, (float[3]){NAN, 0, -1}, now_ns()));
        trk_close(source);
    }
}

/* Reads at the same times give the same samples, bit for bit. Sources whose samples come from outside refuse
 * the virtual clock. */
static void virtual_clock_is_repeatable(void **state)
{
    (void)state;
    for (int i = 0; i < kinds_count; i++) {
        char error[TRK_ERROR_SIZE] = "";
        struct trk_source *source[2];
        struct trk_source_options options = {
            .spec = kinds[i].spec, .fallback_log = FIXTURES "/hall.gaze", .speed = 1, .virtual_clock = true};
        source[0] = trk_open(&options, error);
        assert_true(!source[0] == kinds[i].row->needs_real_clock);
        if (!source[0]) continue;
        assert_non_null(source[1] = trk_open(&options, error));
        for (uint64_t time_ns = 0; time_ns < 2000000000; time_ns += 3000000) {
            struct trk_sample sample[2];
            memset(sample, 0, sizeof sample);
            enum trk_result result = trk_read(source[0], time_ns, &sample[0], error);
            assert_int_equal(trk_read(source[1], time_ns, &sample[1], error), result);
            if (result == TRK_SAMPLE) assert_memory_equal(&sample[0], &sample[1], sizeof *sample);
            assert_true(result != TRK_SAMPLE || sample[0].arrival_ns <= time_ns);
        }
        trk_close(source[0]);
        trk_close(source[1]);
    }
}

/* A source that ends says so, and delivers nothing afterwards; auto then waits for a tracker. */
static void the_end(void **state)
{
    (void)state;
    static const char *const ending[] = {"replay:" FIXTURES "/hall.gaze", "auto"};
    for (int i = 0; i < 2; i++) {
        char error[TRK_ERROR_SIZE] = "";
        struct trk_source_options options = {.spec = ending[i], .fallback_log = FIXTURES "/hall.gaze"};
        bool is_auto = strcmp(ending[i], "auto") == 0;
        assert_true(trk_source_kind_find(ending[i])->waits_after_end == is_auto);
        if (is_auto && (kind_of("hid")->present || kind_of("psvr2")->present)) continue;
        struct trk_source *source = trk_open(&options, error);
        assert_non_null(source);
        struct trk_sample sample;
        int samples = 0;
        enum trk_result result;
        while ((result = trk_read(source, UINT64_MAX, &sample, error)) == TRK_SAMPLE) samples++;
        assert_int_equal(result, TRK_END);
        assert_true(samples >= 12);
        result = trk_read(source, now_ns() + 5000000, &sample, error);
        assert_int_equal(result, is_auto ? TRK_TIMEOUT : TRK_END);
        trk_close(source);
    }
}

static void opened_and_closed(void **state)
{
    (void)state;
    for (int i = 0; i < kinds_count; i++)
        for (int k = 0; k < 20; k++) trk_close(open_kind(&kinds[i]));
}

int main(int count, char **arguments)
{
    find_kinds();
    for (int a = 1; a < count; a++)
        if (kind_of(arguments[a])) kind_of(arguments[a])->present = true;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rows_say_how_to_write_them),  cmocka_unit_test(rows_tell_devices),
        cmocka_unit_test(samples_are_in_order),        cmocka_unit_test(reads_end_in_time),
        cmocka_unit_test(interrupt_ends_any_wait),     cmocka_unit_test(interrupt_before_a_read),
        cmocka_unit_test(status_while_reading),        cmocka_unit_test(only_a_pointer_is_pushed),
        cmocka_unit_test(virtual_clock_is_repeatable), cmocka_unit_test(the_end),
        cmocka_unit_test(opened_and_closed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
