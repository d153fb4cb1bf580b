/* Tobii Pro Lab's data export: a table with tabs. Names of columns carry the unit in square brackets; older
 * exports have the same names without.
 *
 * Recording timestamp is the recording computer's clock and becomes arrival_ns: [ms] or [μs], and without
 * brackets either, which its steps tell. Eyetracker timestamp [μs] is the tracker's and becomes device_ns;
 * where there is none, the first serves for both. Rows of other sensors (mouse, gyroscope, events) lie
 * between those of "Eye Tracker" and are skipped. Validity is Valid or Invalid, in older exports 0 (best) to
 * 4 (lost), of which Tobii advises to use 0 and 1; where it was not exported, gaze that is there is valid.
 * Missing is empty. A decimal comma is understood.
 *
 * Trackers on a screen: Gaze point X, Y [DACS px] are pixels from the top left corner of the display, whose
 * size is Recording resolution width and height. Glasses: Gaze direction left X.. [HUCS norm] are unit
 * vectors in the head unit, +X to the wearer's left, +Y up, +Z forward, as in Tobii Pro Glasses 3 (see
 * glasses3.c), and Eye position.. or Pupil position.. [HUCS mm] where they start. Only they export a Gaze
 * point 3D, which is how they are told without brackets.
 *
 * No real export of gaze was at hand: the rows of the tests are made from the documentation, from what public
 * readers expect, and, for times without a unit, after real rows of a glasses' export without gaze. */
#include "log/formats.h"

#include <math.h>
#include <string.h>

enum {
    EYE_POINT,
    EYE_DIRECTION = EYE_POINT + 2,
    EYE_ORIGIN = EYE_DIRECTION + 3,
    EYE_PUPIL = EYE_ORIGIN + 3,
    EYE_VALID,
    EYE_COLUMNS
};

struct reader {
    struct trk_table table;
    struct trk_frame frame;
    struct trk_plane plane;
    bool has_plane, on_screen;
    int recording, tracker, sensor, point[2], resolution[2];
    int eye[2][EYE_COLUMNS];
    double recording_unit_ns;
    struct trk_log_clock device, host;
    size_t others;
    uint64_t sequence;
};

static void find_eye(struct reader *reader, const struct trk_header *header, int eye)
{
    static const struct {
        const char *name, *unit;
    } columns[EYE_COLUMNS] = {
        {"Gaze point %s X", "DACS px"},  {"Gaze point %s Y", "DACS px"},
        {"Gaze direction %s X", "HUCS"}, {"Gaze direction %s Y", "HUCS"},
        {"Gaze direction %s Z", "HUCS"}, {"Eye position %s X", "HUCS"},
        {"Eye position %s Y", "HUCS"},   {"Eye position %s Z", "HUCS"},
        {"Pupil diameter %s", "mm"},     {"Validity %s", ""},
    };
    for (int i = 0; i < EYE_COLUMNS; i++) {
        const char *side = strstr(columns[i].name, "%s");
        char name[64];
        snprintf(name, sizeof name, "%.*s%s%s", (int)(side - columns[i].name), columns[i].name,
                 eye ? "right" : "left", side + 2);
        reader->eye[eye][i] = trk_header_find_unit(header, name, columns[i].unit);
        if (i < EYE_ORIGIN || i >= EYE_PUPIL || reader->eye[eye][i] >= 0) continue;
        snprintf(name, sizeof name, "Pupil position %s %c", eye ? "right" : "left", "XYZ"[i - EYE_ORIGIN]);
        reader->eye[eye][i] = trk_header_find_unit(header, name, columns[i].unit);
    }
}

/* Where the unit is not in the header: what the steps of all rows tell. */
static bool find_unit(struct reader *reader, char out_error[TRK_ERROR_SIZE])
{
    struct trk_reading *reading = reader->table.reading;
    const char *unit = strchr(reading->header.names[reader->recording], '[');
    reader->recording_unit_ns = unit ? (strstr(unit, "ms") ? 1e6 : 1e3)
                                     : trk_table_guess_unit(&reader->table, reader->recording, out_error);
    return reader->recording_unit_ns > 0;
}

static bool begin(struct reader *reader, struct trk_reading *reading, char out_error[TRK_ERROR_SIZE])
{
    const struct trk_header *header = &reading->header;
    static const char *const needed[] = {"Recording timestamp"};
    trk_table_init(&reader->table, reading);
    reader->table.decimal_comma = true;
    if (!trk_table_need(&reader->table, needed, 1, &reader->recording, out_error)) return false;
    if (!find_unit(reader, out_error)) return false;
    reader->tracker = trk_header_find(header, "Eyetracker timestamp");
    reader->sensor = trk_header_find(header, "Sensor");
    reader->point[0] = trk_header_find_unit(header, "Gaze point X", "DACS px");
    reader->point[1] = trk_header_find_unit(header, "Gaze point Y", "DACS px");
    reader->resolution[0] = trk_header_find(header, "Recording resolution width");
    reader->resolution[1] = trk_header_find(header, "Recording resolution height");
    find_eye(reader, header, 0);
    find_eye(reader, header, 1);
    /* Directions without brackets are of the display's frame where there is a display. */
    const int x = reader->eye[0][EYE_DIRECTION];
    reader->on_screen = x < 0 || (!strchr(header->names[x], '[') &&
                                  trk_header_find_unit(header, "Gaze point 3D X", "HUCS") < 0);
    reader->frame = trk_reading_frame(reading, "LUF");
    if (!reader->on_screen || reader->point[0] >= 0 || reader->eye[0][EYE_POINT] >= 0 ||
        reader->eye[1][EYE_POINT] >= 0)
        return true;
    return trk_lines_fail(
        &reading->lines, out_error,
        "header has neither 'Gaze direction left X [HUCS norm]' nor 'Gaze point X [DACS px]', "
        "expected one of them");
}

/* Rows of the tracker alone. */
static bool is_gaze(const struct reader *reader)
{
    char *const *fields = reader->table.fields;
    if (reader->sensor >= 0) return strcmp(fields[reader->sensor], "Eye Tracker") == 0;
    return reader->tracker < 0 || *fields[reader->tracker];
}

static bool begin_plane(struct reader *reader, char out_error[TRK_ERROR_SIZE])
{
    struct trk_reading *reading = reader->table.reading;
    double width, height;
    if (reader->has_plane) return true;
    reader->has_plane = true;
    if (!trk_table_number(&reader->table, reader->resolution[0], &width, out_error) ||
        !trk_table_number(&reader->table, reader->resolution[1], &height, out_error))
        return false;
    if (!(width >= 1 && width < 1e6 && height >= 1 && height < 1e6)) {
        width = 1920;
        height = 1080;
        trk_assume(reading, "display of 1920 x 1080 px");
    }
    return trk_plane_init(&reader->plane, reading, width, height, width / height, TRK_SCREEN_FOV_DEG,
                          "screen", out_error);
}

static bool is_valid(const struct reader *reader, int eye)
{
    double level;
    if (reader->eye[eye][EYE_VALID] < 0) return true;
    const char *field = reader->table.fields[reader->eye[eye][EYE_VALID]];
    return strcmp(field, "Valid") == 0 || (trk_parse_double(field, &level) && level <= 1);
}

static bool read_eye(struct reader *reader, int eye, struct trk_sample *sample,
                     char out_error[TRK_ERROR_SIZE])
{
    const int *columns = reader->eye[eye];
    double pupil, x, y;
    float direction[3], origin[3];
    if (!trk_table_number(&reader->table, columns[EYE_PUPIL], &pupil, out_error) ||
        !trk_table_number(&reader->table, columns[EYE_POINT], &x, out_error) ||
        !trk_table_number(&reader->table, columns[EYE_POINT + 1], &y, out_error) ||
        !trk_table_numbers(&reader->table, &columns[EYE_DIRECTION], 3, direction, out_error) ||
        !trk_table_numbers(&reader->table, &columns[EYE_ORIGIN], 3, origin, out_error))
        return false;
    trk_set_pupil(sample, eye, pupil);
    if (!is_valid(reader, eye)) return true;
    if (!reader->on_screen) {
        trk_set_direction(sample, eye, direction, &reader->frame);
        trk_set_origin(sample, eye, origin, 1e-3f, &reader->frame);
    } else if (isfinite(x) && isfinite(y)) {
        trk_plane_direction(&reader->plane, x, y, sample->eye[eye].direction);
        sample->valid |= TRK_LEFT_DIRECTION << 4 * eye;
    }
    return true;
}

static bool read_times(struct reader *reader, struct trk_sample *sample, char out_error[TRK_ERROR_SIZE])
{
    const struct trk_lines *lines = &reader->table.reading->lines;
    int64_t host_ns, device_ns;
    if (!trk_table_time(&reader->table, reader->recording, reader->recording_unit_ns, &host_ns, out_error))
        return false;
    device_ns = host_ns;
    /* Glasses have no such clock, and leave its column empty. */
    if (!reader->device.started && reader->tracker >= 0 && !*reader->table.fields[reader->tracker])
        reader->tracker = -1;
    if (reader->tracker >= 0 && !trk_table_time(&reader->table, reader->tracker, 1e3, &device_ns, out_error))
        return false;
    return trk_log_clock_count(&reader->device, device_ns, lines, &sample->device_ns, out_error) &&
           trk_log_clock_count(&reader->host, host_ns, lines, &sample->arrival_ns, out_error);
}

static bool read_row(void *context, struct trk_sample *sample, char out_error[TRK_ERROR_SIZE])
{
    struct reader *reader = context;
    double x, y;
    if (!is_gaze(reader)) {
        reader->others++;
        return true;
    }
    sample->sequence = ++reader->sequence;
    if (!read_times(reader, sample, out_error) || (reader->on_screen && !begin_plane(reader, out_error)) ||
        !read_eye(reader, 0, sample, out_error) || !read_eye(reader, 1, sample, out_error))
        return false;
    if (reader->on_screen) {
        if (!trk_table_number(&reader->table, reader->point[0], &x, out_error) ||
            !trk_table_number(&reader->table, reader->point[1], &y, out_error))
            return false;
        if (isfinite(x) && isfinite(y) && (is_valid(reader, 0) || is_valid(reader, 1))) {
            trk_plane_direction(&reader->plane, x, y, sample->direction);
            sample->valid |= TRK_DIRECTION;
        }
    }
    trk_combine(sample);
    return true;
}

static bool read_tobii_lab(struct trk_reading *reading, char out_error[TRK_ERROR_SIZE])
{
    struct reader reader = {0};
    if (!begin(&reader, reading, out_error)) return false;
    if (!trk_table_read(&reader.table, read_row, &reader, out_error)) return false;
    if (reader.others) trk_assume(reading, "rows of other sensors, skipped: %zu", reader.others);
    if (reader.table.was_comma) trk_assume(reading, "commas in numbers are decimal");
    return true;
}

/* Which columns there are is for whoever exports to say. */
static bool detect(const struct trk_reading *reading)
{
    static const char *const gaze[] = {"Gaze point X", "Gaze direction left X", "Validity left"};
    bool found = false;
    for (size_t i = 0; i < sizeof gaze / sizeof *gaze; i++)
        found |= trk_header_find(&reading->header, gaze[i]) >= 0;
    return found && trk_header_find(&reading->header, "Recording timestamp") >= 0;
}

const struct trk_log_format trk_log_tobii_lab = {
    .id = "tobii-lab",
    .name = "Tobii Pro Lab",
    .takes = TRK_TAKES_TIME_UNIT | TRK_TAKES_FRAME | TRK_TAKES_SCREEN,
    .detect = detect,
    .read = read_tobii_lab,
};
