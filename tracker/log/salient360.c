/* Logs of the Salient360! toolbox (David et al.), from Unity: the head pose, and gaze in the head, while
 * people looked at panoramas in a headset. There are two families of logs.
 *
 * Static (still panoramas; Tobii at 120 Hz): OcutimeStamp is the tracker's clock in us, UnityTimeStamp the
 * host's in ms. cameraPosition and cameraRotation (x, y, z, w) are the head pose in Unity's left-handed
 * frame. leftEyeDirection and rightEyeDirection are in the head; valL and valR say whether they are valid. A
 * lost eye is NaN. meanBasePoint and meanGazeDirection are in neither frame (the direction stays near (0, -1,
 * 0) while the eyes move), so the reader computes the combined gaze from the eyes.
 *
 * Dynamic (panoramic video; SMI at 250 Hz): oculoTS is in ns, unityTS in ms. cam_pitch, cam_yaw and cam_roll
 * are Unity's Euler angles in degrees; meanGazeDir, leftGazeDir and rightGazeDir are in the head. Every row
 * lacks the comma between binPor.y and Lval ("666.5324True,True", "NaNFalse,False"), so it has one field less
 * than the header. The reader also accepts a file without that defect. sphere_yaw is the angle by which the
 * picture was turned about the viewer; the reader does not apply it, so gaze is relative to the room.
 *
 * Signs: +X is to the right, as the base points show (the left eye's x is -31 mm, the right eye's +34 mm).
 * And while the head turns and the eye holds its target, the eye must turn against the head. With these signs
 * it does, in yaw and in pitch (the test measures it); with any other signs it does not. Base points are in
 * metres. */
#include "log/formats.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* The columns of a family. The order is the same in both families. */
enum {
    DEVICE,
    HOST,
    LEFT_DIRECTION,
    RIGHT_DIRECTION = LEFT_DIRECTION + 3,
    LEFT_ORIGIN = RIGHT_DIRECTION + 3,
    RIGHT_ORIGIN = LEFT_ORIGIN + 3,
    HEAD_ROTATION = RIGHT_ORIGIN + 3, /* a quaternion (4 columns) or angles (3) */
    HEAD_POSITION = HEAD_ROTATION + 4,
    COLUMNS = HEAD_POSITION + 3,
};

/* clang-format off */
static const char *const static_names[COLUMNS] = {
    "OcutimeStamp", "UnityTimeStamp",
    "leftEyeDirection.x", "leftEyeDirection.y", "leftEyeDirection.z",
    "rightEyeDirection.x", "rightEyeDirection.y", "rightEyeDirection.z",
    "leftBasePoint.x", "leftBasePoint.y", "leftBasePoint.z",
    "rightBasePoint.x", "rightBasePoint.y", "rightBasePoint.z",
    "cameraRotation.x", "cameraRotation.y", "cameraRotation.z", "cameraRotation.w",
    "cameraPosition.x", "cameraPosition.y", "cameraPosition.z",
};
static const char *const dynamic_names[HEAD_ROTATION + 3] = {
    "oculoTS", "unityTS",
    "leftGazeDir.x", "leftGazeDir.y", "leftGazeDir.z",
    "rightGazeDir.x", "rightGazeDir.y", "rightGazeDir.z",
    "leftBasePt.x", "leftBasePt.y", "leftBasePt.z",
    "rightBasePt.x", "rightBasePt.y", "rightBasePt.z",
    "cam_pitch", "cam_yaw", "cam_roll",
};
/* clang-format on */

struct reader {
    struct trk_table table;
    struct trk_frame frame;
    struct trk_log_clock device, host;
    double device_unit_ns;
    int place[COLUMNS];
    int valid[2]; /* columns of the validity of each eye */
    bool is_dynamic;
    size_t mended;
    int64_t first_host_ms;
    uint64_t sequence;
};

/* Insert the separator that rows of the dynamic family lack: it belongs before a True or False that directly
 * follows a number. */
static size_t mend_row(void *context, struct trk_table *table, size_t count)
{
    static char words[2][6] = {"False", "True"};
    struct reader *reader = context;
    if (count + 1 != table->reading->header.count) return count;
    for (size_t i = 0; i < count; i++)
        for (int k = 0; k < 2; k++) {
            size_t length = strlen(table->fields[i]), size = strlen(words[k]);
            if (length <= size || strcasecmp(table->fields[i] + length - size, words[k]) != 0) continue;
            table->fields[i][length - size] = '\0';
            memmove(&table->fields[i + 2], &table->fields[i + 1], (count - i - 1) * sizeof *table->fields);
            table->fields[i + 1] = words[k];
            reader->mended++;
            return count + 1;
        }
    return count;
}

static bool read_flag(struct reader *reader, int column, bool *out_flag, char out_error[TRK_ERROR_SIZE])
{
    const char *field = reader->table.fields[column];
    *out_flag = strcasecmp(field, "true") == 0 || strcmp(field, "1") == 0;
    if (*out_flag || strcasecmp(field, "false") == 0 || strcmp(field, "0") == 0 || trk_is_missing(field))
        return true;
    return trk_lines_fail(&reader->table.reading->lines, out_error, "%s is '%.40s', expected True or False",
                          reader->table.reading->header.names[column], field);
}

static bool read_head(struct reader *reader, struct trk_sample *sample, char out_error[TRK_ERROR_SIZE])
{
    float rotation[4], position[3] = {0}, angles[3];
    if (reader->is_dynamic) {
        if (!trk_table_numbers(&reader->table, &reader->place[HEAD_ROTATION], 3, angles, out_error))
            return false;
        trk_unity_euler(angles, rotation);
    } else if (!trk_table_numbers(&reader->table, &reader->place[HEAD_ROTATION], 4, rotation, out_error) ||
               !trk_table_numbers(&reader->table, &reader->place[HEAD_POSITION], 3, position, out_error)) {
        return false;
    }
    trk_set_unity_head(sample, position, rotation);
    return true;
}

/* The host counts ms from the year 1. In ns that does not fit in an int64_t, so the times are counted from
 * the first one. */
static bool read_host(struct reader *reader, int64_t *out_ns, char out_error[TRK_ERROR_SIZE])
{
    int64_t ms;
    if (!trk_table_time(&reader->table, reader->place[HOST], 1, &ms, out_error)) return false;
    if (!reader->host.started) reader->first_host_ms = ms;
    if (!__builtin_mul_overflow(ms - reader->first_host_ms, INT64_C(1000000), out_ns) &&
        llabs(*out_ns) < INT64_C(1) << 62)
        return true;
    return trk_lines_fail(&reader->table.reading->lines, out_error,
                          "%s is far from the first, expected a time",
                          reader->table.reading->header.names[reader->place[HOST]]);
}

static bool read_row(void *context, struct trk_sample *sample, char out_error[TRK_ERROR_SIZE])
{
    struct reader *reader = context;
    int64_t device_ns, host_ns;
    if (!trk_table_time(&reader->table, reader->place[DEVICE], reader->device_unit_ns, &device_ns,
                        out_error) ||
        !read_host(reader, &host_ns, out_error))
        return false;
    sample->sequence = ++reader->sequence;
    if (!trk_log_clock_count(&reader->device, device_ns, reader->table.reading, &sample->device_ns,
                             out_error) ||
        !trk_log_clock_count(&reader->host, host_ns, reader->table.reading, &sample->arrival_ns, out_error))
        return false;
    for (int eye = 0; eye < 2; eye++) {
        bool valid;
        float direction[3], origin[3];
        if (!read_flag(reader, reader->valid[eye], &valid, out_error) ||
            !trk_table_numbers(&reader->table, &reader->place[LEFT_DIRECTION + 3 * eye], 3, direction,
                               out_error) ||
            !trk_table_numbers(&reader->table, &reader->place[LEFT_ORIGIN + 3 * eye], 3, origin, out_error))
            return false;
        if (!valid) continue;
        trk_set_direction(sample, eye, direction, &reader->frame);
        trk_set_origin(sample, eye, origin, 1, &reader->frame);
    }
    reader->table.reading->eyes_mean += trk_combine(sample);
    return read_head(reader, sample, out_error);
}

static bool read_rows(struct reader *reader, struct trk_reading *reading, char out_error[TRK_ERROR_SIZE])
{
    reading->clock_names[0] = reading->header.names[reader->place[DEVICE]];
    reading->clock_names[1] = reading->header.names[reader->place[HOST]];
    if (!trk_table_read(&reader->table, read_row, reader, out_error)) return false;
    if (reader->mended) trk_assume(reading, "rows whose missing comma was put back: %zu", reader->mended);
    return true;
}

static bool read_static(struct trk_reading *reading, char out_error[TRK_ERROR_SIZE])
{
    static const char *const flags[] = {"valL", "valR"};
    struct reader reader = {.frame = trk_reading_frame(reading, "RUF"),
                            .device_unit_ns = trk_time_unit(reading, 1e3)};
    trk_table_init(&reader.table, reading);
    if (!trk_table_need(&reader.table, static_names, COLUMNS, reader.place, out_error) ||
        !trk_table_need(&reader.table, flags, 2, reader.valid, out_error))
        return false;
    return read_rows(&reader, reading, out_error);
}

static bool read_dynamic(struct trk_reading *reading, char out_error[TRK_ERROR_SIZE])
{
    static const char *const flags[] = {"Lval", "Rval"};
    struct reader reader = {.frame = trk_reading_frame(reading, "RUF"),
                            .device_unit_ns = trk_time_unit(reading, 1),
                            .is_dynamic = true};
    trk_table_init(&reader.table, reading);
    if (!trk_table_need(&reader.table, dynamic_names, HEAD_ROTATION + 3, reader.place, out_error) ||
        !trk_table_need(&reader.table, flags, 2, reader.valid, out_error))
        return false;
    reader.table.separator = reading->header.separator;
    reader.table.mend = mend_row;
    reader.table.reader = &reader;
    if (trk_header_find(&reading->header, "sphere_yaw") >= 0)
        trk_assume(reading, "sphere_yaw (how the picture was turned) is not applied");
    return read_rows(&reader, reading, out_error);
}

const struct trk_log_format trk_log_salient360_static = {
    .id = "salient360-static",
    .name = "Salient360 static",
    .takes = TRK_TAKES_TIME_UNIT | TRK_TAKES_FRAME | TRK_TAKES_RECORDING,
    .says_mean = "gaze is the mean of the eyes (the file's own mean is in no known frame)",
    .columns = {"OcutimeStamp", "leftEyeDirection.x", "cameraRotation.x"},
    .read = read_static,
};

const struct trk_log_format trk_log_salient360_dynamic = {
    .id = "salient360-dynamic",
    .name = "Salient360 dynamic",
    .takes = TRK_TAKES_TIME_UNIT | TRK_TAKES_FRAME | TRK_TAKES_RECORDING,
    .says_mean = "gaze is the mean of the eyes, and not the file's meanGazeDir",
    .columns = {"oculoTS", "leftGazeDir.x", "cam_pitch"},
    .read = read_dynamic,
};
