/* Logs of Pupil Labs: Core (gaze_positions.csv of Pupil Player) and Cloud (gaze.csv of Invisible and Neon).
 *
 * Core. gaze_timestamp (older: timestamp) is in seconds of a monotonic clock with any zero; a few rows in a
 * thousand go back, and are sorted. gaze_normal0 and eye_center0 are the right eye's, ...1 the left one's, in
 * mm, in the frame of the scene camera: +X right, +Y down, +Z forward. How this is known: in real rows eye
 * centre 0 has x = +18 mm and eye centre 1 x = -39 mm; and a gaze point with x = -25, y = -31, z = 268 mm
 * stands beside norm_pos (0.438, 0.573), whose origin is the picture's bottom left corner: left and up. Rows
 * of one eye leave the other's fields empty, and those that were mapped in 2-D all of them. There, and
 * without 3-D columns, norm_pos is taken through a pinhole; the camera's usual picture of 1280 x 720 is 77.7
 * degrees wide. confidence below 0.6, Pupil's own threshold, is a lost sample. No such file was at hand
 * whole: rows of the tests are made from the documentation and two quoted rows.
 *
 * Cloud. timestamp [ns] is of the Unix epoch; azimuth and elevation are degrees from the scene camera's axis,
 * to the right and up. In the real recording azimuth grows with gaze x [px] and elevation falls as gaze y
 * [px] grows, which count from the picture's top left corner; and while the head turns to the right, by the
 * gyroscope of the same recording, azimuth falls: the eye stays behind (the test measures both). Samples that
 * have a blink id are of a closed eye and count as lost; so do those of glasses that are not worn. */
#include "log/formats.h"

#include <math.h>
#include <string.h>

/* --- Core ----------------------------------------------------------------------------------------------- */

enum { TIME, CONFIDENCE, NORM, CENTRES = NORM + 2, NORMALS = CENTRES + 6, CORE_COLUMNS = NORMALS + 6 };

/* clang-format off */
static const char *const core_names[CORE_COLUMNS] = {
    "gaze_timestamp", "confidence", "norm_pos_x", "norm_pos_y",
    "eye_center0_3d_x", "eye_center0_3d_y", "eye_center0_3d_z",
    "eye_center1_3d_x", "eye_center1_3d_y", "eye_center1_3d_z",
    "gaze_normal0_x", "gaze_normal0_y", "gaze_normal0_z",
    "gaze_normal1_x", "gaze_normal1_y", "gaze_normal1_z",
};
/* clang-format on */

#define SCENE_FOV_DEG  77.7
#define MIN_CONFIDENCE 0.6

struct core {
    struct trk_table table;
    struct trk_frame frame;
    struct trk_plane plane;
    struct trk_log_clock clock;
    int place[CORE_COLUMNS]; /* those of an eye are -1 in recordings without 3-D */
    bool has_plane;
    size_t doubtful;
    uint64_t sequence;
};

static bool begin_core(struct core *core, struct trk_reading *reading, char out_error[TRK_ERROR_SIZE])
{
    const char *names[NORM + 2];
    memcpy(names, core_names, sizeof names);
    if (trk_header_find(&reading->header, names[TIME]) < 0) names[TIME] = "timestamp";
    trk_table_init(&core->table, reading);
    if (!trk_table_need(&core->table, names, NORM + 2, core->place, out_error)) return false;
    for (int i = CENTRES; i < CORE_COLUMNS; i++)
        core->place[i] = trk_header_find(&reading->header, core_names[i]);
    core->frame = trk_reading_frame(reading, "RDF");
    trk_assume(reading, "the head is the scene camera");
    return true;
}

/* Where the point in the picture lies; only recordings that need it have a say on the camera. */
static bool take_norm_pos(struct core *core, double x, double y, struct trk_sample *sample,
                          char out_error[TRK_ERROR_SIZE])
{
    if (!core->has_plane && !trk_plane_init(&core->plane, core->table.reading, 1, 1, 16.0 / 9, SCENE_FOV_DEG,
                                            "no 3-D gaze: norm_pos through a scene camera", out_error))
        return false;
    core->has_plane = true;
    trk_plane_direction(&core->plane, x, 1 - y, sample->direction);
    sample->valid |= TRK_DIRECTION;
    return true;
}

static bool read_core_row(void *context, struct trk_sample *sample, char out_error[TRK_ERROR_SIZE])
{
    struct core *core = context;
    struct trk_table *table = &core->table;
    double confidence, x, y;
    int64_t time_ns;
    if (!trk_table_time(table, core->place[TIME], trk_time_unit(table->reading, 1e9), &time_ns, out_error) ||
        !trk_table_number(table, core->place[CONFIDENCE], &confidence, out_error) ||
        !trk_table_number(table, core->place[NORM], &x, out_error) ||
        !trk_table_number(table, core->place[NORM + 1], &y, out_error))
        return false;
    if (!core->clock.started) core->clock = (struct trk_log_clock){.started = true, .first_ns = time_ns};
    sample->sequence = ++core->sequence;
    int64_t ns = time_ns - core->clock.first_ns + (int64_t)TRK_MAX_DISORDER_NS;
    if (ns < 0)
        return trk_lines_fail(&table->reading->lines, out_error,
                              "is %g s before the first row, expected less", 1 - (double)ns / 1e9);
    sample->device_ns = sample->arrival_ns = (uint64_t)ns;
    bool sure = confidence >= MIN_CONFIDENCE; /* not if it is NaN */
    core->doubtful += !sure;
    for (int i = 0; i < 2; i++) {
        float normal[3], centre[3];
        if (!trk_table_numbers(table, &core->place[NORMALS + 3 * i], 3, normal, out_error) ||
            !trk_table_numbers(table, &core->place[CENTRES + 3 * i], 3, centre, out_error))
            return false;
        if (!sure) continue;
        trk_set_direction(sample, 1 - i, normal, &core->frame);
        trk_set_origin(sample, 1 - i, centre, 1e-3f, &core->frame);
    }
    trk_combine(sample);
    return !sure || (sample->valid & TRK_DIRECTION) || !isfinite(x) || !isfinite(y) ||
           take_norm_pos(core, x, y, sample, out_error);
}

static bool read_core(struct trk_reading *reading, char out_error[TRK_ERROR_SIZE])
{
    struct core core = {0};
    reading->disordered = true;
    if (!begin_core(&core, reading, out_error)) return false;
    if (!trk_table_read(&core.table, read_core_row, &core, out_error)) return false;
    if (core.doubtful)
        trk_assume(reading, "samples of confidence below %g, counted as lost: %zu", MIN_CONFIDENCE,
                   core.doubtful);
    return true;
}

const struct trk_log_format trk_log_pupil_core = {
    .id = "pupil-core",
    .name = "Pupil Core",
    .takes = TRK_TAKES_TIME_UNIT | TRK_TAKES_FRAME | TRK_TAKES_SCREEN,
    .columns = {"confidence", "norm_pos_x", "norm_pos_y", "base_data"},
    .read = read_core,
};

/* --- Cloud ---------------------------------------------------------------------------------------------- */

enum { STAMP, AZIMUTH, ELEVATION, CLOUD_COLUMNS };
static const char *const cloud_names[CLOUD_COLUMNS] = {"timestamp", "azimuth", "elevation"};

static bool is_worn(const char *field)
{
    double number;
    if (trk_parse_double(field, &number)) return number > 0;
    return strcmp(field, "False") != 0 && strcmp(field, "false") != 0; /* empty is not known */
}

struct cloud {
    struct trk_table table;
    struct trk_log_clock clock;
    int place[CLOUD_COLUMNS], worn, blink; /* the last two are -1 where there are none */
    double signs[2], unit_ns;
    size_t blinks;
    uint64_t sequence;
};

static bool read_cloud_row(void *context, struct trk_sample *sample, char out_error[TRK_ERROR_SIZE])
{
    struct cloud *cloud = context;
    struct trk_table *table = &cloud->table;
    double azimuth, elevation;
    int64_t time_ns;
    if (!trk_table_time(table, cloud->place[STAMP], cloud->unit_ns, &time_ns, out_error) ||
        !trk_log_clock_count(&cloud->clock, time_ns, &table->reading->lines, &sample->device_ns, out_error) ||
        !trk_table_number(table, cloud->place[AZIMUTH], &azimuth, out_error) ||
        !trk_table_number(table, cloud->place[ELEVATION], &elevation, out_error))
        return false;
    sample->sequence = ++cloud->sequence;
    sample->arrival_ns = sample->device_ns;
    if (cloud->blink >= 0 && *table->fields[cloud->blink]) {
        cloud->blinks++;
        trk_set_openness(sample, 0, 0);
        trk_set_openness(sample, 1, 0);
    } else if ((cloud->worn < 0 || is_worn(table->fields[cloud->worn])) && isfinite(azimuth) &&
               isfinite(elevation)) {
        trk_angles_direction(cloud->signs[0] * azimuth, cloud->signs[1] * elevation, sample->direction);
        sample->valid |= TRK_DIRECTION;
    }
    return true;
}

static bool read_cloud(struct trk_reading *reading, char out_error[TRK_ERROR_SIZE])
{
    struct cloud cloud = {.worn = trk_header_find(&reading->header, "worn"),
                          .blink = trk_header_find(&reading->header, "blink id"),
                          .unit_ns = trk_time_unit(reading, 1)};
    trk_table_init(&cloud.table, reading);
    if (!trk_table_need(&cloud.table, cloud_names, CLOUD_COLUMNS, cloud.place, out_error) ||
        !trk_reading_signs(reading, "RUF", cloud.signs, out_error))
        return false;
    trk_assume(reading, "the head is the scene camera");
    if (!trk_table_read(&cloud.table, read_cloud_row, &cloud, out_error)) return false;
    if (cloud.blinks) trk_assume(reading, "samples in blinks, counted as lost: %zu", cloud.blinks);
    if (cloud.clock.held) trk_assume(reading, "times that go back, held: %zu", cloud.clock.held);
    return true;
}

const struct trk_log_format trk_log_pupil_cloud = {
    .id = "pupil-cloud",
    .name = "Pupil Cloud",
    .takes = TRK_TAKES_TIME_UNIT | TRK_TAKES_FRAME,
    .columns = {"recording id", "gaze x", "azimuth", "elevation"},
    .read = read_cloud,
};
