/* Logs of HTC headsets: columns with the eye data of the SRanipal SDK, and the head pose from Unity.
 *
 * The reader finds the columns by their names in the header, and ignores others. Every laboratory writes
 * these files with its own script, modelled on HTC's example. Fields are separated by `;`, by commas or by
 * tabs; some headers have runs of spaces above rows with tabs. Some files have helmet_* columns and some do
 * not. We had real rows only of the kind with `;`; the tests' rows of the other kinds are made from what is
 * known of them.
 *
 * Time. time_stamp(ms) is the tracker's own clock, a signed 32-bit count that starts at any value and wraps;
 * its steps are the 8 or 9 ms of a 120 Hz camera. Unwrapped, it becomes device_ns. time(100ns) is the host's
 * clock, in .NET ticks, when the program fetched the sample; its steps vary by 2 ms. Counted from the first
 * row, it becomes arrival_ns. Rows with equal times hold the same frame, fetched twice; they are accepted. A
 * time that goes back is refused.
 *
 * Eyes. SRanipal's frame is right-handed, in mm, +Y up and +Z forward, so +X points to the wearer's left. Two
 * facts in real recordings confirm it. The left eye's origin has x = +38 mm and the right eye's -32 mm. And
 * while the head turns and the eye holds its target (vestibulo-ocular reflex), the eye must turn against the
 * head: if x is read as left, the slope of eye yaw velocity against head yaw velocity is -0.8; if x is read
 * as right, it is +0.8, and gaze moves 3 times as much in the world. Half a turn about Y converts this frame
 * to the project's: (-x, y, -z). Some scripts turn the gaze to Unity's frame before they write it; for such
 * files, set the frame option to RUF.
 *
 * Validity is a mask for each eye: bit 0 origin, 1 direction, 2 pupil, 3 openness, 4 place in the camera's
 * picture; 31 means that all are valid. When lost, a direction is (0,0,0), a pupil is -1, and an origin keeps
 * its last value.
 *
 * Head. Unity's frame is left-handed, +X right, +Y up, +Z forward, in metres. Its Euler angles are degrees,
 * wrap at 360 and are applied about Z, then X, then Y. Mirroring Z converts it to the project's frame: the
 * position's z and the angles about X and Y change sign; the angle about Z does not. */
#include "log/formats.h"

#include <cglm/cglm.h>
#include <math.h>
#include <string.h>

/* The columns that the reader uses, in an order of its own: three of the row, nine of each eye, six of the
 * head. */
enum {
    TICKS,
    STAMP,
    FRAME,
    EYES,
    HELMET_POSITION = EYES + 2 * 9,
    HELMET_ROTATION = HELMET_POSITION + 3,
    COLUMNS = HELMET_ROTATION + 3,
};
enum { EYE_VALID, EYE_OPENNESS, EYE_PUPIL, EYE_ORIGIN, EYE_DIRECTION = EYE_ORIGIN + 3 };

/* clang-format off */
static const char *const names[COLUMNS] = {
    "time(100ns)", "time_stamp(ms)", "frame",
    "eye_valid_L", "openness_L", "pupil_diameter_L(mm)",
    "gaze_origin_L.x(mm)", "gaze_origin_L.y(mm)", "gaze_origin_L.z(mm)",
    "gaze_direct_L.x", "gaze_direct_L.y", "gaze_direct_L.z",
    "eye_valid_R", "openness_R", "pupil_diameter_R(mm)",
    "gaze_origin_R.x(mm)", "gaze_origin_R.y(mm)", "gaze_origin_R.z(mm)",
    "gaze_direct_R.x", "gaze_direct_R.y", "gaze_direct_R.z",
    "helmet_pos_x", "helmet_pos_y", "helmet_pos_z",
    "helmet_rot_x", "helmet_rot_y", "helmet_rot_z",
};
/* clang-format on */

/* Bits of SRanipal's validity mask of an eye. */
enum { HAS_ORIGIN = 1, HAS_DIRECTION = 2, HAS_PUPIL = 4, HAS_OPENNESS = 8 };

/* The state while a file is read. */
struct reader {
    struct trk_reading *reading;
    struct trk_table table;
    struct trk_frame frame;
    int place[COLUMNS]; /* position of each column in the header; -1 if the head is absent */
    bool started;
    int64_t first_tick, first_frame;
    uint32_t last_stamp;
    uint64_t device_ms, sequence;
};

static bool read_header(struct reader *reader, char out_error[TRK_ERROR_SIZE])
{
    const struct trk_header *header = &reader->reading->header;
    trk_table_init(&reader->table, reader->reading);
    if (!trk_table_need(&reader->table, names, HELMET_POSITION, reader->place, out_error)) return false;
    for (int i = HELMET_POSITION; i < COLUMNS; i++) reader->place[i] = -1;
    if (trk_header_find(header, names[HELMET_ROTATION]) < 0) {
        trk_assume(reader->reading, "no head pose: gaze is relative to the head");
        return true;
    }
    if (!trk_table_need(&reader->table, &names[HELMET_ROTATION], 3, &reader->place[HELMET_ROTATION],
                        out_error))
        return false;
    if (trk_header_find(header, names[HELMET_POSITION]) < 0) return true;
    return trk_table_need(&reader->table, &names[HELMET_POSITION], 3, &reader->place[HELMET_POSITION],
                          out_error);
}

/* Read both clocks, and find the sequence number. */
static bool read_time(struct reader *reader, struct trk_sample *out_sample, char out_error[TRK_ERROR_SIZE])
{
    struct trk_table *table = &reader->table;
    int64_t tick, stamp, frame;
    if (!trk_table_time(table, reader->place[TICKS], 1, &tick, out_error) ||
        !trk_table_integer(table, reader->place[STAMP], &stamp, out_error) ||
        !trk_table_integer(table, reader->place[FRAME], &frame, out_error))
        return false;
    if (stamp < INT32_MIN || stamp > UINT32_MAX || frame < INT32_MIN || frame > UINT32_MAX)
        return trk_lines_fail(&reader->reading->lines, out_error,
                              "%s is %lld and %s is %lld, expected 32-bit counts", names[STAMP],
                              (long long)stamp, names[FRAME], (long long)frame);
    if (!reader->started) {
        reader->started = true;
        reader->first_tick = tick;
        reader->first_frame = frame;
        reader->last_stamp = (uint32_t)stamp;
    }
    /* The step is modulo 2^32: a step of more than half the range is a step back. */
    uint32_t step = (uint32_t)stamp - reader->last_stamp;
    if (step > INT32_MAX)
        return trk_lines_fail(&reader->reading->lines, out_error,
                              "%s goes back by %u ms, expected times in order", names[STAMP], -step);
    const int64_t ticks = tick - reader->first_tick; /* cannot overflow: see trk_table_time() */
    if (ticks < 0 || ticks > INT64_MAX / 100)
        return trk_lines_fail(&reader->reading->lines, out_error,
                              "%s is %lld, expected %lld or a little later", names[TICKS], (long long)tick,
                              (long long)reader->first_tick);
    reader->last_stamp = (uint32_t)stamp;
    reader->device_ms += step;
    /* Frames that were skipped count as lost samples. A frame that was fetched twice, or a counter that
     * restarts, loses no sample. */
    uint64_t counted = frame < reader->first_frame ? 0 : (uint64_t)(frame - reader->first_frame) + 1;
    reader->sequence = counted > reader->sequence ? counted : reader->sequence + 1;

    out_sample->sequence = reader->sequence;
    out_sample->device_ns = reader->device_ms * 1000000; /* trk_log_append() refuses it before it wraps */
    out_sample->arrival_ns = (uint64_t)ticks * 100;
    return true;
}

/* Read n numbers from successive columns in the reader's order; NaN if one is missing. If they are not valid,
 * their text is not checked. */
static bool read_floats(struct reader *reader, int column, int n, bool valid, float *out_values,
                        char out_error[TRK_ERROR_SIZE])
{
    for (int i = 0; i < n; i++) out_values[i] = NAN;
    return !valid || trk_table_numbers(&reader->table, &reader->place[column], n, out_values, out_error);
}

static bool read_eye(struct reader *reader, int index, struct trk_sample *sample,
                     char out_error[TRK_ERROR_SIZE])
{
    int column = EYES + 9 * index;
    float direction[3], origin[3], openness, pupil;
    int64_t mask = 0;
    if (!trk_is_missing(reader->table.fields[reader->place[column + EYE_VALID]]) &&
        !trk_table_integer(&reader->table, reader->place[column + EYE_VALID], &mask, out_error))
        return false;
    if (!read_floats(reader, column + EYE_DIRECTION, 3, mask & HAS_DIRECTION, direction, out_error) ||
        !read_floats(reader, column + EYE_ORIGIN, 3, mask & HAS_ORIGIN, origin, out_error) ||
        !read_floats(reader, column + EYE_OPENNESS, 1, mask & HAS_OPENNESS, &openness, out_error) ||
        !read_floats(reader, column + EYE_PUPIL, 1, mask & HAS_PUPIL, &pupil, out_error))
        return false;
    bool is_seen = !isnan(direction[0] + direction[1] + direction[2]) && !glm_vec3_eq(direction, 0);
    if (is_seen && !trk_is_unit(direction, 3))
        return trk_lines_fail(&reader->reading->lines, out_error,
                              "%s and the next two are not of unit length, expected a length of 1",
                              names[column + EYE_DIRECTION]);
    if (is_seen) trk_set_direction(sample, index, direction, &reader->frame);
    trk_set_origin(sample, index, origin, 1e-3f, &reader->frame);
    trk_set_openness(sample, index, openness);
    trk_set_pupil(sample, index, pupil);
    return true;
}

static bool read_head(struct reader *reader, struct trk_sample *sample, char out_error[TRK_ERROR_SIZE])
{
    float position[3] = {0}, angles[3], rotation[4];
    if (reader->place[HELMET_ROTATION] < 0) return true;
    if (reader->place[HELMET_POSITION] >= 0 &&
        !trk_table_numbers(&reader->table, &reader->place[HELMET_POSITION], 3, position, out_error))
        return false;
    if (!trk_table_numbers(&reader->table, &reader->place[HELMET_ROTATION], 3, angles, out_error))
        return false;
    trk_unity_euler(angles, rotation);
    trk_set_unity_head(sample, position, rotation);
    return true;
}

static bool read_row(void *context, struct trk_sample *sample, char out_error[TRK_ERROR_SIZE])
{
    struct reader *reader = context;
    if (!read_time(reader, sample, out_error) || !read_eye(reader, 0, sample, out_error) ||
        !read_eye(reader, 1, sample, out_error) || !read_head(reader, sample, out_error))
        return false;
    reader->reading->eyes_mean += trk_combine(sample);
    return true;
}

static bool read_sranipal(struct trk_reading *reading, char out_error[TRK_ERROR_SIZE])
{
    struct reader reader = {.reading = reading, .frame = trk_reading_frame(reading, "LUF")};
    if (!read_header(&reader, out_error)) return false;
    reading->clock_names[0] = names[STAMP];
    reading->clock_names[1] = names[TICKS];
    if (!reading->options->frame)
        trk_assume(reading, "gaze is in SRanipal's frame (LUF), not turned to Unity's (RUF)");
    return trk_table_read(&reader.table, read_row, &reader, out_error);
}

const struct trk_log_format trk_log_sranipal = {
    .id = "sranipal",
    .name = "HTC SRanipal",
    .takes = TRK_TAKES_FRAME | TRK_TAKES_RECORDING,
    .columns = {"time(100ns)", "gaze_direct_L.x"},
    .read = read_sranipal,
};
