/* Logs of Pico Neo headsets (Tobii inside), from Unity: a table with tabs.
 *
 * Timeline is in seconds. Combine Eye Gaze Vector is the gaze in the head: a unit vector, or zeros when lost.
 * Pose Status of an eye is a mask: 52 if the tracker sees the eye, 0 if it does not. Openness is 0 or 1. Head
 * Rotation holds Unity's Euler angles in degrees; Head Position, which some logs lack, is in metres. The
 * maker's interface to Unity gives vectors in Unity's frame (+X right, +Y up, +Z forward). The reader assumes
 * this frame, and says so in a note. We had no real log; the rows of the tests follow the documentation. */
#include "log/formats.h"

#include <math.h>

enum { TIME, GAZE, ROTATION = GAZE + 3, NEEDED = ROTATION + 3 };
enum { STATUS, OPENNESS = STATUS + 2, POSITION = OPENNESS + 2, OPTIONAL = POSITION + 3 };

/* clang-format off */
static const char *const needed[NEEDED] = {
    "Timeline",
    "Combine Eye Gaze Vector. x", "Combine Eye Gaze Vector. y", "Combine Eye Gaze Vector. z",
    "Head Rotation. x", "Head Rotation. y", "Head Rotation. z",
};
static const char *const optional[OPTIONAL] = {
    "Left Eye Pose Status", "Right Eye Pose Status",
    "Left Eye Gaze Openness", "Right Eye Gaze Openness",
    "Head Position. x", "Head Position. y", "Head Position. z",
};
/* clang-format on */

struct reader {
    struct trk_table table;
    struct trk_frame frame;
    struct trk_log_clock clock;
    double unit_ns;
    int place[NEEDED], extra[OPTIONAL];
    uint64_t sequence;
};

static bool read_row(void *context, struct trk_sample *sample, char out_error[TRK_ERROR_SIZE])
{
    struct reader *reader = context;
    struct trk_table *table = &reader->table;
    float gaze[3], angles[3], rotation[4], position[3];
    double status[2], openness;
    int64_t time_ns;
    sample->sequence = ++reader->sequence;
    if (!trk_table_time(table, reader->place[TIME], reader->unit_ns, &time_ns, out_error) ||
        !trk_log_clock_count(&reader->clock, time_ns, table->reading, &sample->device_ns, out_error) ||
        !trk_table_numbers(table, &reader->place[GAZE], 3, gaze, out_error) ||
        !trk_table_numbers(table, &reader->place[ROTATION], 3, angles, out_error) ||
        !trk_table_numbers(table, &reader->extra[POSITION], 3, position, out_error))
        return false;
    sample->arrival_ns = sample->device_ns;
    for (int eye = 0; eye < 2; eye++) {
        if (!trk_table_number(table, reader->extra[STATUS + eye], &status[eye], out_error) ||
            !trk_table_number(table, reader->extra[OPENNESS + eye], &openness, out_error))
            return false;
        trk_set_openness(sample, eye, openness);
    }
    /* A missing status says nothing about the eye. */
    if (!(status[0] == 0 && status[1] == 0)) trk_set_direction(sample, 2, gaze, &reader->frame);
    for (int i = 0; i < 3; i++)
        if (isnan(position[i])) position[i] = 0;
    trk_unity_euler(angles, rotation);
    trk_set_unity_head(sample, position, rotation);
    return true;
}

static bool read_pico(struct trk_reading *reading, char out_error[TRK_ERROR_SIZE])
{
    struct reader reader = {.frame = trk_reading_frame(reading, "RUF"),
                            .unit_ns = trk_time_unit(reading, 1e9)};
    trk_table_init(&reader.table, reading);
    if (!trk_table_need(&reader.table, needed, NEEDED, reader.place, out_error)) return false;
    reading->clock_names[0] = needed[TIME];
    for (int i = 0; i < OPTIONAL; i++) reader.extra[i] = trk_header_find(&reading->header, optional[i]);
    if (!reading->options->frame) trk_assume(reading, "gaze is in Unity's frame (RUF)");
    if (!trk_table_read(&reader.table, read_row, &reader, out_error)) return false;
    return true;
}

const struct trk_log_format trk_log_pico = {
    .id = "pico",
    .name = "Pico",
    .takes = TRK_TAKES_TIME_UNIT | TRK_TAKES_FRAME | TRK_TAKES_RECORDING,
    .columns = {"Timeline", "Combine Eye Gaze Vector. x"},
    .read = read_pico,
};
