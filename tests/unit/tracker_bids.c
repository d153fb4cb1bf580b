/* Logs are written as BIDS, and read back. */
#include "tracker_corpus.h"

#include "tracker.h"
#include "tracker_samples.h"

#include <jansson.h>

static bool write_bids(const struct trk_log *log, char error[TRK_ERROR_SIZE])
{
    FILE *table = fopen(path, "wb"), *beside = fopen(sidecar, "w");
    assert_true(table && beside);
    bool ok = trk_log_print_bids(log, table, beside, error);
    return fclose(table) == 0 && fclose(beside) == 0 && ok;
}

static void bids_reads_back(void **state)
{
    (void)state;
    char error[TRK_ERROR_SIZE] = "";
    struct trk_log log, back;
    float a[3], b[3];
    assert_true(trk_synthesise(11, 5, &log));
    if (!write_bids(&log, error)) fail_msg("%s", error);
    if (!trk_log_read(path, &back, error)) fail_msg("%s", error);
    assert_string_equal(back.format, "BIDS eye tracking");
    assert_string_equal(back.assumed, "");
    assert_int_equal(back.count, log.count);
    for (size_t i = 0; i < log.count; i++) {
        bool valid = trk_world_direction(sample_at(&log, i), a);
        assert_int_equal(sample_at(&back, i)->device_ns,
                         sample_at(&log, i)->device_ns - sample_at(&log, 0)->device_ns);
        assert_int_equal(trk_world_direction(sample_at(&back, i), b), valid);
        for (int k = 0; k < 3 && valid; k++) assert_float_equal(a[k], b[k], 1e-6);
    }
    trk_log_finish(&back);

    json_t *root = json_load_file(sidecar, 0, NULL);
    assert_non_null(root);
    assert_string_equal(json_string_value(json_object_get(root, "PhysioType")), "eyetrack");
    assert_string_equal(json_string_value(json_object_get(root, "SampleCoordinateSystem")), "gaze-in-world");
    assert_string_equal(json_string_value(json_object_get(root, "RecordedEye")), "cyclopean");
    assert_float_equal(json_number_value(json_object_get(root, "SamplingFrequency")), 120, 1e-3);
    assert_int_equal(json_array_size(json_object_get(root, "Columns")), 4);
    json_decref(root);
    trk_log_finish(&log);
}

static void bids_not_written(void **state)
{
    (void)state;
    char error[TRK_ERROR_SIZE] = "";
    struct trk_log log;
    assert_true(trk_synthesise(11, 1, &log));
    FILE *full = fopen("/dev/full", "w"), *file = fopen(sidecar, "w");
    assert_true(full && file);
    assert_false(trk_log_print_bids(&log, full, file, error));
    assert_non_null(strstr(error, "No space left"));
    fclose(full);
    fclose(file);
    log.count = 0;
    assert_false(write_bids(&log, error));
    assert_non_null(strstr(error, "no samples"));
    trk_log_finish(&log);
}

int main(void)
{
#define TEST(f) cmocka_unit_test_setup_teardown(f, enter, leave)
    const struct CMUnitTest tests[] = {
        TEST(bids_reads_back),
        TEST(bids_not_written),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
