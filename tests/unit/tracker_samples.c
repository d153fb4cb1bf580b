/* The samples of a log in memory: they come out as they went in, and take little memory. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>

#include "gaze.h"
#include "log/samples.h"
#include "tracker.h"
#include "tracker_samples.h"
#include "tracker_write.h"

#include <malloc.h>
#include <math.h>
#include <stdio.h>
#include <unistd.h>

/* --- every bit --- */

static uint32_t draw(void)
{
    static uint64_t noise = 1;
    noise = noise * 6364136223846793005u + 1442695040888963407u;
    return (uint32_t)(noise >> 32);
}

/* The sample as it is read back: fields whose bit is unset are 0. */
static struct trk_sample without_unset(const struct trk_sample *sample)
{
    struct trk_sample out = {.sequence = sample->sequence,
                             .device_ns = sample->device_ns,
                             .arrival_ns = sample->arrival_ns,
                             .sensor_ns = sample->sensor_ns,
                             .valid = sample->valid};
#define KEEP(member, bit)                                                                                    \
    if (sample->valid & (uint32_t)(bit)) memcpy(&out.member, &sample->member, sizeof out.member)
    KEEP(direction, TRK_DIRECTION);
    KEEP(origin, TRK_ORIGIN);
    KEEP(head, TRK_HEAD);
    KEEP(screen, TRK_SCREEN);
    for (int eye = 0; eye < 2; eye++) {
        KEEP(eye[eye].direction, TRK_LEFT_DIRECTION << 4 * eye);
        KEEP(eye[eye].origin, TRK_LEFT_ORIGIN << 4 * eye);
        KEEP(eye[eye].openness, TRK_LEFT_OPENNESS << 4 * eye);
        KEEP(eye[eye].pupil_mm, TRK_LEFT_PUPIL << 4 * eye);
    }
    return out;
}

enum { KINDS = 8, EACH = 1100, MOST = EACH * KINDS + 300 };

/* Eight kinds of samples take turns, each for at least a block. They range from samples that are all alike to
 * random bits. */
static struct trk_sample make(size_t i)
{
    static uint32_t mask, bits[31];
    struct trk_sample sample = {.sequence = i + 1};
    const unsigned kind = i / EACH % KINDS;
    if (i % EACH == 0) {
        mask = draw() & 0xfff;
        for (int k = 0; k < 31; k++) bits[k] = draw();
    }
    sample.valid = kind < 3 ? mask : draw() & 0xfff;
    sample.device_ns = kind == 6 ? (uint64_t)draw() << 32 | draw() : i * 500000 + (kind ? draw() % 999 : 0);
    sample.arrival_ns = kind == 5 ? UINT64_MAX - draw() : sample.device_ns + (kind > 2) * 1234567;
    sample.sensor_ns = kind == 4 ? draw() : 0;
    if (kind == 6) sample.sequence = (uint64_t)draw() << 31;
    float *const floats[] = {sample.direction, sample.origin, sample.eye[0].direction, sample.head,
                             sample.screen};
    const int counts[] = {3, 3, 16, 7, 2};
    for (int f = 0, k = 0; f < 5; f++)
        for (int n = 0; n < counts[f]; n++, k++) {
            uint32_t word = kind == 0 ? bits[k] : kind < 5 ? bits[k] ^ (draw() >> (4 * k % 32)) : draw();
            memcpy(&floats[f][n], &word, sizeof word);
            if (kind == 7) floats[f][n] = (float)(int32_t)word * 0x1p-31f;
        }
    if (kind == 7) { /* the combined gaze, if present, is that of the eyes */
        const uint32_t both = TRK_DIRECTION | TRK_ORIGIN, lost = draw() % 4 ? 0 : draw() & both;
        sample.valid &= ~both;
        trk_combine(&sample);
        sample.valid &= ~lost;
    }
    return sample;
}

static void every_bit(void **state)
{
    (void)state;
    static struct trk_sample expected[MOST];
    struct trk_log log = {0};
    uint32_t seen = 0;
    assert_int_equal(trk_log_seen(&log), 0);
    for (size_t i = 0; i < MOST; i++) {
        const struct trk_sample sample = make(i);
        assert_true(trk_samples_add(&log, &sample));
        assert_int_equal(log.count, i + 1);
        expected[i] = without_unset(&sample);
        seen |= sample.valid;
        if (i % 611 == 0) assert_true(trk_samples_pack(&log)); /* more samples may be added after packing */
    }
    assert_int_equal(trk_log_seen(&log), seen);
    for (int round = 0; round < 2; round++) {
        assert_true(trk_samples_pack(&log));
        for (size_t i = 0; i < MOST; i++) {
            assert_memory_equal(sample_at(&log, i), &expected[i], sizeof *expected);
            assert_true(trk_log_time(&log, i) == expected[i].device_ns);
        }
        for (size_t i = 0; i < MOST; i += 1 + draw() % 300) {
            const struct trk_sample sample = make(draw() % MOST);
            assert_true(trk_samples_put(&log, i, &sample));
            expected[i] = without_unset(&sample);
        }
    }
    assert_int_equal(log.count, MOST);
    trk_log_finish(&log);
}

/* --- memory --- */

/* How much memory the whole program has allocated, now and at most. The functions below replace malloc() and
 * its like, which sanitizers replace too. */
#if defined __SANITIZE_ADDRESS__ || defined __SANITIZE_THREAD__ || !defined __GLIBC__
enum { COUNTS = 0 };
static size_t allocated, most;
#else
enum { COUNTS = 1 };
static size_t allocated, most;
void *__libc_malloc(size_t size);
void *__libc_calloc(size_t count, size_t size);
void *__libc_realloc(void *old, size_t size);
void __libc_free(void *block);

static void *note(void *block)
{
    allocated += malloc_usable_size(block);
    if (allocated > most) most = allocated;
    return block;
}

void *malloc(size_t size)
{
    return note(__libc_malloc(size));
}

void *calloc(size_t count, size_t size)
{
    return note(__libc_calloc(count, size));
}

/* Counted as if the old and the new block never existed together, because large blocks are moved by remapping
 * their pages. */
void *realloc(void *old, size_t size)
{
    const size_t before = malloc_usable_size(old);
    void *block = __libc_realloc(old, size);
    if (block || size == 0) allocated -= before;
    return note(block);
}

void free(void *block)
{
    allocated -= malloc_usable_size(block);
    __libc_free(block);
}
#endif

static const char *path = "tracker_samples.asc", *converted = "tracker_samples.gaze";

enum { ROWS = 200000 };

static FILE *create(const char *head)
{
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    assert_true(fputs(head, file) >= 0);
    return file;
}

static double noise(double size)
{
    return size * draw() / UINT32_MAX;
}

/* A recording of an EyeLink at 1000 Hz, with one eye or two, with blinks, and divided into trials. */
static void make_eyelink(int rows, bool is_binocular)
{
    FILE *file = create("** CONVERTED FROM x.edf\n** VERSION: EYELINK II 1\n");
    const char *eyes = is_binocular ? "LEFT\tRIGHT" : "RIGHT";
    double x = 0, y = 0;
    for (int i = 0; i < rows; i++) {
        if (i % 5000 == 0)
            fprintf(file,
                    "MSG\t%d GAZE_COORDS 0.00 0.00 1023.00 767.00\nSTART\t%d \t%s\tSAMPLES\tEVENTS\n"
                    "SAMPLES\tGAZE\t%s\tRATE\t1000.00\tTRACKING\tCR\tFILTER\t2\n",
                    i, i, eyes, eyes);
        if (i % 250 == 0) x = 20 + noise(980), y = 20 + noise(720);
        if (i % 5000 == 3000) fprintf(file, "SBLINK R %d\n", i);
        if (i % 5000 == 3100) fprintf(file, "EBLINK R %d\t%d\t100\n", i - 100, i);
        fprintf(file, "%d", i);
        for (int eye = 0; eye < 1 + is_binocular; eye++)
            if (i % 5000 >= 3000 && i % 5000 < 3100)
                fputs("\t   .\t   .\t    0.0", file);
            else
                fprintf(file, "\t %6.1f\t %6.1f\t %6.1f", x + noise(4), y + noise(4), 1100 + noise(9));
        fputs("\t.....\n", file);
        if (i % 5000 == 4999) fprintf(file, "END\t%d \tSAMPLES\tEVENTS\tRES\t   26.44\t   27.01\n", i);
    }
    assert_int_equal(fclose(file), 0);
}

static void make_binocular(int rows)
{
    make_eyelink(rows, true);
}

static void make_monocular(int rows)
{
    make_eyelink(rows, false);
}

/* An export of Pupil Core, whose rows have to be sorted. */
static void make_unsorted(int rows)
{
    FILE *file =
        create("gaze_timestamp,world_index,confidence,norm_pos_x,norm_pos_y,base_data,gaze_point_3d_x,"
               "gaze_point_3d_y,gaze_point_3d_z\n");
    for (int i = 0; i < rows; i++)
        fprintf(file, "%.6f,%d,0.95,0.5,0.5,1-0,%.6f,%.6f,500\n", (i ^ 1) * 0.005 + noise(0.001), i / 8,
                noise(200), noise(100));
    assert_int_equal(fclose(file), 0);
}

/* A headset that measures everything: eyes, lids, pupils and head. */
static void make_headset(int rows)
{
    struct trk_log log;
    assert_true(trk_synthesise(3, rows / 120.0, &log));
    assert_true(written(&log, path));
    trk_log_finish(&log);
}

/* The most memory (bytes) that it takes to convert a log with this many rows, and to open it as a source. */
static void measure(void (*make_log)(int rows), int rows, size_t *out_convert, size_t *out_replay)
{
    char error[TRK_ERROR_SIZE];
    struct trk_log log;
    make_log(rows);
    size_t before = most = allocated;
    if (!trk_log_read(path, &log, error)) fail_msg("%s", error);
    assert_int_equal(log.count, rows);
    assert_true(written(&log, converted));
    trk_log_finish(&log);
    *out_convert = most - before;
    char spec[64];
    snprintf(spec, sizeof spec, "replay:%s", path);
    before = most = allocated;
    struct trk_source *source = trk_open(&(const struct trk_source_options){.spec = spec}, error);
    if (!source) fail_msg("%s", error);
    *out_replay = most - before;
    trk_close(source);
    unlink(path);
    unlink(converted);
}

/* An array of struct trk_sample would take 160 bytes per sample. The memory for a log of a few rows is
 * subtracted: it is for the lines and tables that all reading needs. */
static void little_room(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        void (*make_log)(int rows);
        double most; /* bytes per sample */
    } logs[] = {{"EyeLink, two eyes", make_binocular, 28},
                {"EyeLink, one eye", make_monocular, 18},
                {"Pupil Core, unsorted", make_unsorted, 52},
                {"headset", make_headset, 80}};
    if (!COUNTS) {
        print_message("allocations are not counted under a sanitizer\n");
        skip();
    }
    for (size_t i = 0; i < sizeof logs / sizeof *logs; i++) {
        size_t few[2], many[2];
        measure(logs[i].make_log, 20, &few[0], &few[1]);
        measure(logs[i].make_log, ROWS, &many[0], &many[1]);
        for (int k = 0; k < 2; k++) {
            const double bytes = ((double)many[k] - (double)few[k]) / ROWS;
            print_message("%-24s %-10s %5.1f bytes per sample\n", logs[i].name,
                          k ? "to replay" : "to convert", bytes);
            if (bytes > logs[i].most)
                fail_msg("%.1f bytes per sample, expected %g at most", bytes, logs[i].most);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_bit),
        cmocka_unit_test(little_room),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
