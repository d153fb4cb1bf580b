/* Logs of Pupil Labs: Core (gaze_positions.csv of Pupil Player) and Cloud (gaze.csv of Invisible and Neon).
 *
 * Core. gaze_timestamp (older: timestamp) is in seconds of a monotonic clock with an arbitrary zero. In a few
 * rows of a thousand it goes back; the reader sorts the rows. gaze_normal0 and eye_center0 (in mm) belong to
 * the right eye, ...1 to the left eye, in the frame of the scene camera: +X right, +Y down, +Z forward. How
 * this is known: in real rows eye centre 0 has x = +18 mm and eye centre 1 has x = -39 mm; and the row of a
 * gaze point with x = -25, y = -31, z = 268 mm, which is to the left and up, has norm_pos (0.438, 0.573),
 * which counts from the picture's bottom left corner. The direction of gaze is from the scene camera to
 * gaze_point_3d, the point that Pupil computes. Rows of one eye, which leave the other eye's fields empty and
 * may alternate, have that point too, but their normals belong to one eye each and differ by the angle of
 * vergence. Rows that were mapped in 2-D have only norm_pos; the reader converts it with a pinhole camera,
 * fitted to the rows that have both, or else with the camera's usual picture of 1280 x 720, 77.7 degrees
 * wide. A sample with confidence below 0.6, Pupil's own threshold, is lost. We had no complete file; the rows
 * of the tests follow the documentation and two quoted rows.
 *
 * Cloud. timestamp [ns] counts from the Unix epoch; azimuth and elevation are degrees from the scene camera's
 * axis, to the right and up. In the real recording, azimuth grows with gaze x [px] and elevation falls as
 * gaze y [px] grows; these count from the picture's top left corner. And while the head turns to the right,
 * according to the gyroscope of the same recording, azimuth falls, because the eye stays behind (the test
 * measures both). Samples with a blink id are of a closed eye, and count as lost; so do samples of glasses
 * that are not worn. */
#include "error.h"
#include "log/formats.h"
#include "log/samples.h"

#include <math.h>
#include <string.h>
#include <strings.h>

/* --- Core --- */

enum {
    TIME,
    CONFIDENCE,
    NORM,
    POINT = NORM + 2,
    CENTRES = POINT + 3,
    NORMALS = CENTRES + 6,
    CORE_COLUMNS = NORMALS + 6
};

/* clang-format off */
static const char *const core_names[CORE_COLUMNS] = {
    "gaze_timestamp", "confidence", "norm_pos_x", "norm_pos_y",
    "gaze_point_3d_x", "gaze_point_3d_y", "gaze_point_3d_z",
    "eye_center0_3d_x", "eye_center0_3d_y", "eye_center0_3d_z",
    "eye_center1_3d_x", "eye_center1_3d_y", "eye_center1_3d_z",
    "gaze_normal0_x", "gaze_normal0_y", "gaze_normal0_z",
    "gaze_normal1_x", "gaze_normal1_y", "gaze_normal1_z",
};
/* clang-format on */

#define SCENE_FOV_DEG  77.7
#define MIN_CONFIDENCE 0.6

/* Sums for fitting a straight line along one axis of the picture, over the rows that have both a place in the
 * picture and a direction. */
struct fit {
    double x, y, xx, xy; /* x: offset / distance ahead; y: fraction of the picture */
};

struct core {
    struct trk_table table;
    struct trk_frame frame;
    struct trk_log_clock clock;
    int place[CORE_COLUMNS]; /* -1 for the columns of an eye in recordings without 3-D */
    int base_data;
    struct fit fits[2];
    size_t fitted, flat; /* rows in fits; rows with only norm_pos */
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
    for (int i = POINT; i < CORE_COLUMNS; i++)
        core->place[i] = trk_header_find(&reading->header, core_names[i]);
    core->base_data = trk_header_find(&reading->header, "base_data");
    core->frame = trk_reading_frame(reading, "RDF");
    reading->clock_names[0] = names[TIME];
    trk_assume(reading, "the head is the scene camera");
    return true;
}

/* Which eye a row was made from, or -1 if from both, or if that is not known. base_data lists "TIME-EYE",
 * with EYE 0 for the right eye. */
static int eye_of(const struct core *core)
{
    const char *at = core->base_data >= 0 ? core->table.fields[core->base_data] : "";
    bool seen[2] = {false, false};
    for (; *at; at++) {
        bool ends = at[0] == '-' && (at[1] == '0' || at[1] == '1') && (at[2] == ' ' || at[2] == '\0');
        if (ends) seen['1' - at[1]] = true;
    }
    return seen[0] == seen[1] ? -1 : seen[1] ? 1 : 0;
}

/* The direction of gaze is the vector to the point. If the row has norm_pos as well, it also counts for the
 * fit of the camera. */
static void take_point(struct core *core, const float point[3], const double norm[2],
                       struct trk_sample *sample)
{
    trk_set_direction(sample, 2, point, &core->frame);
    trk_set_origin(sample, 2, (const float[3]){0}, 1, &core->frame);
    if (!isfinite(norm[0]) || !isfinite(norm[1])) return;
    for (int i = 0; i < 2; i++) {
        const double x = (double)point[i] / (double)point[2], y = i ? 1 - norm[i] : norm[i];
        struct fit *fit = &core->fits[i];
        *fit = (struct fit){fit->x + x, fit->y + y, fit->xx + x * x, fit->xy + x * y};
    }
    core->fitted++;
}

/* Keep a place in the picture; it is converted to a direction after all rows are read. */
static void take_norm_pos(struct core *core, const double norm[2], struct trk_sample *sample)
{
    const int eye = eye_of(core);
    sample->screen[0] = (float)norm[0];
    sample->screen[1] = (float)(1 - norm[1]);
    if (eye >= 0 && !(sample->valid & (TRK_LEFT_DIRECTION | TRK_RIGHT_DIRECTION))) {
        sample->eye[eye].direction[0] = NAN; /* turn_norm_pos() sets it */
        sample->valid |= TRK_LEFT_DIRECTION << 4 * eye;
    }
    sample->valid |= TRK_SCREEN;
    core->flat++;
}

static bool read_times(struct core *core, struct trk_sample *sample, char out_error[TRK_ERROR_SIZE])
{
    struct trk_table *table = &core->table;
    int64_t time_ns;
    if (!trk_table_time(table, core->place[TIME], trk_time_unit(table->reading, 1e9), &time_ns, out_error))
        return false;
    if (!core->clock.started) core->clock = (struct trk_log_clock){.started = true, .first_ns = time_ns};
    int64_t ns = time_ns - core->clock.first_ns + (int64_t)TRK_MAX_DISORDER_NS;
    if (ns < 0)
        return trk_lines_fail(&table->reading->lines, out_error,
                              "is %g s before the first row, expected less", 1 - (double)ns / 1e9);
    sample->sequence = ++core->sequence;
    sample->device_ns = sample->arrival_ns = (uint64_t)ns;
    return true;
}

static bool read_core_row(void *context, struct trk_sample *sample, char out_error[TRK_ERROR_SIZE])
{
    struct core *core = context;
    struct trk_table *table = &core->table;
    double confidence, norm[2];
    float point[3];
    if (!read_times(core, sample, out_error) ||
        !trk_table_number(table, core->place[CONFIDENCE], &confidence, out_error) ||
        !trk_table_number(table, core->place[NORM], &norm[0], out_error) ||
        !trk_table_number(table, core->place[NORM + 1], &norm[1], out_error) ||
        !trk_table_numbers(table, &core->place[POINT], 3, point, out_error))
        return false;
    bool sure = confidence >= MIN_CONFIDENCE; /* false if it is NaN */
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
    if (!sure) return true;
    if (point[2] > 0 && isfinite(point[0]) && isfinite(point[1]))
        take_point(core, point, norm, sample);
    else if (fabs(norm[0]) < 100 && fabs(norm[1]) < 100)
        take_norm_pos(core, norm, sample);
    else
        table->reading->eyes_mean += trk_combine(sample);
    return true;
}

/* Fit the middle and the focal length of one axis of the picture from the rows that have both a place and a
 * direction. False if these rows do not determine them. If gaze hardly moves along the axis, the middle
 * cannot be fitted, and 0.5 is assumed. */
static bool solve(const struct core *core, int axis, double *out_middle, double *out_focal)
{
    const struct fit *fit = &core->fits[axis];
    const double n = (double)core->fitted, variance = fit->xx / n - fit->x / n * (fit->x / n);
    const double slight = 0.05 * 0.05; /* 3 degrees */
    if (core->fitted < 8 || fit->xx / n < slight) return false;
    *out_focal = variance > slight ? (fit->xy / n - fit->x / n * (fit->y / n)) / variance
                                   : (fit->xy - 0.5 * fit->x) / fit->xx;
    *out_middle = variance > slight ? fit->y / n - *out_focal * fit->x / n : 0.5;
    return *out_focal > 0.1 && *out_focal < 10;
}

static bool init_camera(struct core *core, struct trk_plane *out_camera, char out_error[TRK_ERROR_SIZE])
{
    struct trk_reading *reading = core->table.reading;
    const struct trk_log_options *options = reading->options;
    const bool is_told = options->screen_fov_deg > 0 || options->screen_width_m > 0;
    double middle[2], focal[2];
    bool is_known = !is_told && solve(core, 0, &middle[0], &focal[0]);
    if (!trk_plane_init(out_camera, reading, (double[]){1, 1}, 16.0 / 9, SCENE_FOV_DEG,
                        is_known ? NULL : "no 3-D gaze: norm_pos through a scene camera", out_error))
        return false;
    if (!is_known) return true;
    if (!solve(core, 1, &middle[1], &focal[1])) {
        middle[1] = 0.5;
        focal[1] = focal[0] * 16 / 9;
    }
    memcpy(out_camera->middle, middle, sizeof middle);
    memcpy(out_camera->focal, focal, sizeof focal);
    trk_assume(
        reading,
        "samples without 3-D gaze: %zu, from norm_pos through a scene camera %.1f degrees wide, fitted to "
        "the other rows",
        core->flat, 2 * atan(0.5 / focal[0]) * 180 / M_PI);
    return true;
}

static bool turn_norm_pos(struct core *core, char out_error[TRK_ERROR_SIZE])
{
    struct trk_log *log = core->table.reading->log;
    struct trk_plane camera;
    if (core->flat == 0) return true;
    if (!init_camera(core, &camera, out_error)) return false;
    for (size_t i = 0; i < log->count; i++) {
        struct trk_sample sample;
        trk_log_sample(log, i, &sample);
        if (!(sample.valid & TRK_SCREEN)) continue;
        trk_plane_direction(&camera, sample.screen[0], sample.screen[1], sample.direction);
        sample.valid = (sample.valid & ~(uint32_t)TRK_SCREEN) | TRK_DIRECTION;
        for (int eye = 0; eye < 2; eye++)
            if (sample.valid & TRK_LEFT_DIRECTION << 4 * eye && isnan(sample.eye[eye].direction[0]))
                memcpy(sample.eye[eye].direction, sample.direction, sizeof sample.direction);
        if (!trk_samples_put(log, i, &sample))
            return trk_fail(out_error, "%s: no memory", core->table.reading->lines.path);
    }
    return true;
}

static bool read_core(struct trk_reading *reading, char out_error[TRK_ERROR_SIZE])
{
    struct core core = {0};
    reading->disordered = true;
    if (!begin_core(&core, reading, out_error)) return false;
    if (!trk_table_read(&core.table, read_core_row, &core, out_error) || !turn_norm_pos(&core, out_error))
        return false;
    if (core.fitted) trk_assume(reading, "gaze is the direction from the scene camera to gaze_point_3d");
    if (core.doubtful)
        trk_assume(reading, "samples of confidence below %g, counted as lost: %zu", MIN_CONFIDENCE,
                   core.doubtful);
    return true;
}

const struct trk_log_format trk_log_pupil_core = {
    .id = "pupil-core",
    .name = "Pupil Core",
    .takes = TRK_TAKES_TIME_UNIT | TRK_TAKES_FRAME | TRK_TAKES_SCREEN | TRK_TAKES_RECORDING,
    .columns = {"confidence", "norm_pos_x", "norm_pos_y", "base_data"},
    .read = read_core,
};

/* --- Cloud --- */

enum { STAMP, AZIMUTH, ELEVATION, CLOUD_COLUMNS };
static const char *const cloud_names[CLOUD_COLUMNS] = {"timestamp", "azimuth", "elevation"};

static bool is_worn(const char *field)
{
    double number;
    if (trk_parse_double(field, &number)) return number > 0;
    return strcasecmp(field, "false") != 0; /* empty: not known, so worn */
}

struct cloud {
    struct trk_table table;
    struct trk_log_clock clock;
    int place[CLOUD_COLUMNS], worn, blink; /* worn, blink: -1 if the column is absent */
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
        !trk_log_clock_count(&cloud->clock, time_ns, table->reading, &sample->device_ns, out_error) ||
        !trk_table_number(table, cloud->place[AZIMUTH], &azimuth, out_error) ||
        !trk_table_number(table, cloud->place[ELEVATION], &elevation, out_error))
        return false;
    sample->sequence = ++cloud->sequence;
    sample->arrival_ns = sample->device_ns;
    if (cloud->blink >= 0 && !trk_is_missing(table->fields[cloud->blink])) {
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
    reading->clock_names[0] = reading->header.names[cloud.place[STAMP]];
    trk_assume(reading, "the head is the scene camera");
    if (!trk_table_read(&cloud.table, read_cloud_row, &cloud, out_error)) return false;
    if (cloud.blinks) trk_assume(reading, "samples in blinks, counted as lost: %zu", cloud.blinks);
    return true;
}

const struct trk_log_format trk_log_pupil_cloud = {
    .id = "pupil-cloud",
    .name = "Pupil Cloud",
    .takes = TRK_TAKES_TIME_UNIT | TRK_TAKES_FRAME | TRK_TAKES_RECORDING,
    .columns = {"recording id", "gaze x", "azimuth", "elevation"},
    .read = read_cloud,
};
