/* Tobii Pro Lab's data export: a table with tabs. Column names give the unit in square brackets; older
 * exports have the same names without brackets.
 *
 * Recording timestamp is the recording computer's clock, and becomes arrival_ns. It is in [ms] or [μs];
 * without brackets it may be in either, and the reader guesses the unit from the steps. Eyetracker timestamp
 * [μs] is the tracker's clock, and becomes device_ns; if it is absent, Recording timestamp serves as both.
 * Between the rows of "Eye Tracker" there are rows of other sensors (mouse, gyroscope, events), which the
 * reader skips. If there is no column Sensor, the reader recognises the tracker's rows by the first of these
 * columns that was exported: the tracker's time, the validity of an eye, gaze. Without gaze in it, a row
 * still counts as the tracker's if it is neither an event nor a mouse position. Validity is Valid or Invalid;
 * in older exports it is 0 (best) to 4 (lost), and Tobii advises to use 0 and 1. If no validity was exported,
 * all gaze counts as valid. A missing value is an empty field. Numbers may have a decimal comma.
 *
 * Trackers on a display have their own frame, DACS: from the display's top left corner, +X right, +Y down, +Z
 * towards the viewer. The reader takes gaze from the first of these that is there: Gaze direction left X..
 * [DACS norm]; the direction from Eye position left X.. to Gaze point left X.., both in [DACS mm]; Gaze point
 * X, Y [DACS px]. The size of the display in pixels is Recording resolution width and height; how far away it
 * was comes from the options or is assumed. The first row with gaze decides for all rows. For glasses, Gaze
 * direction left X.. [HUCS norm] are unit vectors in the head unit's frame, +X to the wearer's left, +Y up,
 * +Z forward, as in Tobii Pro Glasses 3 (see glasses3.c), and Eye position.. or Pupil position.. [HUCS mm]
 * are the origins. In exports without brackets, the reader recognises glasses by a column Gaze point 3D,
 * which only glasses export, or by directions whose Z is positive, that is, forward.
 *
 * We had no real export of gaze. The rows of the tests follow the documentation, and what public readers
 * expect; rows of times without a unit follow a real export from glasses that holds no gaze. */
#include "log/formats.h"

#include <math.h>
#include <string.h>
#include <strings.h>

enum {
    EYE_POINT,
    EYE_DIRECTION = EYE_POINT + 2,
    EYE_ORIGIN = EYE_DIRECTION + 3,
    EYE_PUPIL = EYE_ORIGIN + 3,
    EYE_VALID,
    EYE_PLACE, /* the eye's place; EYE_POINT_MM is its point of gaze: mm, DACS */
    EYE_POINT_MM = EYE_PLACE + 3,
    EYE_COLUMNS = EYE_POINT_MM + 2
};

/* The columns that the gaze comes from. */
enum way { UNDECIDED, GLASSES, DIRECTIONS, MILLIMETRES, PIXELS };

struct reader {
    struct trk_table table;
    struct trk_frame frame;
    struct trk_plane plane;
    enum way way;
    int recording, tracker, sensor, event, mouse, point[2], resolution[2];
    int eye[2][EYE_COLUMNS];
    double recording_unit_ns;
    struct trk_log_clock device, host;
    size_t others;
    uint64_t sequence;
};

static const struct {
    const char *name, *unit;
} eye_columns[EYE_COLUMNS] = {
    {"Gaze point %s X", "DACS px"},   {"Gaze point %s Y", "DACS px"},
    {"Gaze direction %s X", "HUCS"},  {"Gaze direction %s Y", "HUCS"},
    {"Gaze direction %s Z", "HUCS"},  {"Eye position %s X", "HUCS"},
    {"Eye position %s Y", "HUCS"},    {"Eye position %s Z", "HUCS"},
    {"Pupil diameter %s", "mm"},      {"Validity %s", ""},
    {"Eye position %s X", "DACS mm"}, {"Eye position %s Y", "DACS mm"},
    {"Eye position %s Z", "DACS mm"}, {"Gaze point %s X", "DACS mm"},
    {"Gaze point %s Y", "DACS mm"},
};

static int find_of_eye(const struct trk_header *header, const char *pattern, const char *unit, int eye)
{
    const char *side = strstr(pattern, "%s");
    char name[64];
    snprintf(name, sizeof name, "%.*s%s%s", (int)(side - pattern), pattern, eye ? "right" : "left", side + 2);
    return trk_header_find_unit(header, name, unit);
}

static void find_eye(struct reader *reader, const struct trk_header *header, int eye)
{
    int *columns = reader->eye[eye];
    for (int i = 0; i < EYE_COLUMNS; i++) {
        columns[i] = find_of_eye(header, eye_columns[i].name, eye_columns[i].unit, eye);
        if (i >= EYE_DIRECTION && i < EYE_ORIGIN && columns[i] < 0)
            columns[i] = find_of_eye(header, eye_columns[i].name, "DACS", eye);
        if (i >= EYE_ORIGIN && i < EYE_PUPIL && columns[i] < 0) {
            char name[] = "Pupil position %s X";
            name[sizeof name - 2] = "XYZ"[i - EYE_ORIGIN];
            columns[i] = find_of_eye(header, name, eye_columns[i].unit, eye);
        }
        /* Points without a unit are in pixels. */
        if (i >= EYE_POINT_MM && columns[i] >= 0 && !strchr(header->names[columns[i]], '[')) columns[i] = -1;
    }
}

/* Find the unit of Recording timestamp: from its brackets, or else from the steps of the first rows. */
static bool find_unit(struct reader *reader, char out_error[TRK_ERROR_SIZE])
{
    struct trk_reading *reading = reader->table.reading;
    const char *unit = strchr(reading->header.names[reader->recording], '[');
    reader->recording_unit_ns = unit ? (strstr(unit, "ms") ? 1e6 : 1e3)
                                     : trk_table_guess_unit(&reader->table, reader->recording, out_error);
    return reader->recording_unit_ns > 0;
}

/* Does the header show that the export is of glasses? Directions without a frame are of a display, unless
 * there is a Gaze point 3D. */
static bool is_of_glasses(const struct reader *reader, const struct trk_header *header)
{
    for (int eye = 0; eye < 2; eye++) {
        const int x = reader->eye[eye][EYE_DIRECTION];
        const char *bracket = x < 0 ? NULL : strchr(header->names[x], '[');
        if (x >= 0 && (bracket ? strstr(bracket, "HUCS") != NULL
                               : trk_header_find_unit(header, "Gaze point 3D X", "HUCS") >= 0))
            return true;
    }
    return false;
}

static bool begin(struct reader *reader, struct trk_reading *reading, char out_error[TRK_ERROR_SIZE])
{
    const struct trk_header *header = &reading->header;
    static const char *const needed[] = {"Recording timestamp"};
    trk_table_init(&reader->table, reading);
    if (!trk_table_need(&reader->table, needed, 1, &reader->recording, out_error)) return false;
    if (!find_unit(reader, out_error)) return false;
    reader->tracker = trk_header_find(header, "Eyetracker timestamp");
    reader->sensor = trk_header_find(header, "Sensor");
    reader->event = trk_header_find(header, "Event");
    reader->mouse = trk_header_find(header, "Mouse position X");
    reader->point[0] = trk_header_find_unit(header, "Gaze point X", "DACS px");
    reader->point[1] = trk_header_find_unit(header, "Gaze point Y", "DACS px");
    reader->resolution[0] = trk_header_find(header, "Recording resolution width");
    reader->resolution[1] = trk_header_find(header, "Recording resolution height");
    find_eye(reader, header, 0);
    find_eye(reader, header, 1);
    if (is_of_glasses(reader, header)) reader->way = GLASSES;
    reader->frame = trk_reading_frame(reading, reader->way == GLASSES ? "LUF" : "RDB");
    bool found = reader->point[0] >= 0;
    for (int eye = 0; eye < 2; eye++) {
        const int *columns = reader->eye[eye];
        found |= columns[EYE_DIRECTION] >= 0 || columns[EYE_POINT] >= 0 ||
                 (columns[EYE_PLACE] >= 0 && columns[EYE_POINT_MM] >= 0);
    }
    return found ||
           trk_lines_fail(
               &reading->lines, out_error,
               "header has neither 'Gaze direction left X' nor 'Gaze point X [DACS px]', expected one "
               "of them");
}

static bool has(const struct reader *reader, int column)
{
    return column >= 0 && !trk_is_missing(reader->table.fields[column]);
}

/* Is the row a sample of the tracker? */
static bool is_gaze(const struct reader *reader)
{
    if (reader->sensor >= 0) return strcasecmp(reader->table.fields[reader->sensor], "Eye Tracker") == 0;
    if (reader->tracker >= 0) return has(reader, reader->tracker);
    if (reader->eye[0][EYE_VALID] >= 0 || reader->eye[1][EYE_VALID] >= 0)
        return has(reader, reader->eye[0][EYE_VALID]) || has(reader, reader->eye[1][EYE_VALID]);
    bool found = has(reader, reader->point[0]);
    for (int eye = 0; eye < 2; eye++)
        for (int i = 0; i < EYE_COLUMNS; i++) found |= has(reader, reader->eye[eye][i]);
    return found || (!has(reader, reader->event) && !has(reader, reader->mouse));
}

static bool begin_plane(struct reader *reader, char out_error[TRK_ERROR_SIZE])
{
    struct trk_reading *reading = reader->table.reading;
    double width, height;
    if (!trk_table_number(&reader->table, reader->resolution[0], &width, out_error) ||
        !trk_table_number(&reader->table, reader->resolution[1], &height, out_error))
        return false;
    if (!(width >= 1 && width < 1e6 && height >= 1 && height < 1e6)) {
        width = 1920;
        height = 1080;
        trk_assume(reading, "display of 1920 x 1080 px");
    }
    return trk_plane_init(&reader->plane, reading, (double[]){width, height}, width / height,
                          TRK_SCREEN_FOV_DEG, "screen", out_error);
}

static bool is_valid(const struct reader *reader, int eye)
{
    double level;
    if (reader->eye[eye][EYE_VALID] < 0) return true;
    const char *field = reader->table.fields[reader->eye[eye][EYE_VALID]];
    return strcasecmp(field, "Valid") == 0 || (trk_parse_double(field, &level) && level <= 1);
}

/* The fields of one eye in a row. */
struct eye {
    float direction[3], origin[3], place[3], point_mm[2];
    double pupil, point[2];
};

static bool read_eye(struct reader *reader, int eye, struct eye *out, char out_error[TRK_ERROR_SIZE])
{
    const int *columns = reader->eye[eye];
    struct trk_table *table = &reader->table;
    return trk_table_number(table, columns[EYE_PUPIL], &out->pupil, out_error) &&
           trk_table_number(table, columns[EYE_POINT], &out->point[0], out_error) &&
           trk_table_number(table, columns[EYE_POINT + 1], &out->point[1], out_error) &&
           trk_table_numbers(table, &columns[EYE_DIRECTION], 3, out->direction, out_error) &&
           trk_table_numbers(table, &columns[EYE_ORIGIN], 3, out->origin, out_error) &&
           trk_table_numbers(table, &columns[EYE_PLACE], 3, out->place, out_error) &&
           trk_table_numbers(table, &columns[EYE_POINT_MM], 2, out->point_mm, out_error);
}

static bool is_finite(const float *v, int n)
{
    float sum = 0;
    for (int i = 0; i < n; i++) sum += v[i];
    return isfinite(sum);
}

/* Decide where gaze comes from: directions if there are any, else positions in mm, else pixels, because for
 * pixels the screen must be assumed. If the options describe the screen, pixels come first. */
static bool decide(struct reader *reader, const struct eye eyes[2], const double both[2],
                   char out_error[TRK_ERROR_SIZE])
{
    struct trk_reading *reading = reader->table.reading;
    const bool is_told = reading->options->screen_fov_deg > 0 || reading->options->screen_width_m > 0;
    bool pixels = isfinite(both[0] + both[1]);
    for (int i = 0; i < 2; i++) pixels |= isfinite(eyes[i].point[0] + eyes[i].point[1]);
    for (int i = 0; i < 2 && reader->way == UNDECIDED && !(is_told && pixels); i++) {
        const int x = reader->eye[i][EYE_DIRECTION];
        if (!is_finite(eyes[i].direction, 3) || eyes[i].direction[2] == 0) continue;
        reader->way =
            eyes[i].direction[2] > 0 && !strchr(reading->header.names[x], '[') ? GLASSES : DIRECTIONS;
        if (reader->way == GLASSES) reader->frame = trk_reading_frame(reading, "LUF");
        trk_assume(reading, reader->way == GLASSES
                                ? "directions are of glasses (HUCS): their Z is forward"
                                : "gaze is the eyes' directions in the display's frame (DACS)");
    }
    for (int i = 0; i < 2 && reader->way == UNDECIDED && !(is_told && pixels); i++) {
        if (!is_finite(eyes[i].place, 3) || !is_finite(eyes[i].point_mm, 2)) continue;
        reader->way = MILLIMETRES;
        trk_assume(reading,
                   "gaze is the direction from the eyes' positions to the gaze points, in mm (DACS)");
    }
    if (reader->way != UNDECIDED || !pixels) return true;
    reader->way = PIXELS;
    return begin_plane(reader, out_error);
}

static void set_eye(const struct reader *reader, int index, const struct eye *eye, struct trk_sample *sample)
{
    trk_set_pupil(sample, index, eye->pupil);
    if (!is_valid(reader, index)) return;
    if (reader->way == GLASSES || reader->way == DIRECTIONS)
        trk_set_direction(sample, index, eye->direction, &reader->frame);
    if (reader->way == GLASSES) trk_set_origin(sample, index, eye->origin, 1e-3f, &reader->frame);
    if (reader->way == MILLIMETRES) {
        const float way[3] = {eye->point_mm[0] - eye->place[0], eye->point_mm[1] - eye->place[1],
                              -eye->place[2]};
        trk_set_direction(sample, index, way, &reader->frame);
    }
    if (reader->way == PIXELS && isfinite(eye->point[0] + eye->point[1])) {
        trk_plane_direction(&reader->plane, eye->point[0], eye->point[1], sample->eye[index].direction);
        sample->valid |= TRK_LEFT_DIRECTION << 4 * index;
    }
}

static bool read_times(struct reader *reader, struct trk_sample *sample, char out_error[TRK_ERROR_SIZE])
{
    int64_t host_ns, device_ns;
    if (!trk_table_time(&reader->table, reader->recording, reader->recording_unit_ns, &host_ns, out_error))
        return false;
    device_ns = host_ns;
    /* Glasses have no such clock: they leave this column empty. */
    if (!reader->device.started && reader->tracker >= 0 && !has(reader, reader->tracker))
        reader->tracker = -1;
    if (reader->tracker >= 0 && !trk_table_time(&reader->table, reader->tracker, 1e3, &device_ns, out_error))
        return false;
    struct trk_reading *reading = reader->table.reading;
    reading->clock_names[0] =
        reading->header.names[reader->tracker >= 0 ? reader->tracker : reader->recording];
    reading->clock_names[1] = reader->tracker >= 0 ? reading->header.names[reader->recording] : NULL;
    return trk_log_clock_count(&reader->device, device_ns, reader->table.reading, &sample->device_ns,
                               out_error) &&
           trk_log_clock_count(&reader->host, host_ns, reader->table.reading, &sample->arrival_ns, out_error);
}

/* The point on the display that the gaze is at: by the plane that its pixels were taken for, or, where gaze
 * is made from something better, by its pixels, if they were exported with the display's size. */
static bool set_point(struct reader *reader, const struct eye eyes[2], const double both[2],
                      struct trk_sample *sample, char out_error[TRK_ERROR_SIZE])
{
    double point[2] = {both[0], both[1]}, size;
    float head[3];
    if (reader->way == PIXELS) trk_set_screen(sample, &reader->plane);
    if (reader->way == PIXELS || reader->way == GLASSES || !trk_gaze_direction(sample, head, NULL))
        return true;
    for (int i = 0; i < 2; i++) {
        const double left = eyes[0].point[i], right = eyes[1].point[i];
        if (!isfinite(point[i]))
            point[i] = !isfinite(left) ? right : !isfinite(right) ? left : (left + right) / 2;
        if (!trk_table_number(&reader->table, reader->resolution[i], &size, out_error)) return false;
        if (!isfinite(point[i]) || !(size >= 1 && size < 1e6)) return true;
        sample->screen[i] = (float)(point[i] / size);
    }
    sample->valid |= TRK_SCREEN;
    return true;
}

static bool read_row(void *context, struct trk_sample *sample, char out_error[TRK_ERROR_SIZE])
{
    struct reader *reader = context;
    struct eye eyes[2];
    double both[2];
    if (!is_gaze(reader)) {
        reader->others++;
        return true;
    }
    sample->sequence = ++reader->sequence;
    if (!read_times(reader, sample, out_error) || !read_eye(reader, 0, &eyes[0], out_error) ||
        !read_eye(reader, 1, &eyes[1], out_error) ||
        !trk_table_number(&reader->table, reader->point[0], &both[0], out_error) ||
        !trk_table_number(&reader->table, reader->point[1], &both[1], out_error) ||
        !decide(reader, eyes, both, out_error))
        return false;
    for (int i = 0; i < 2; i++) set_eye(reader, i, &eyes[i], sample);
    if (reader->way == PIXELS && isfinite(both[0] + both[1]) &&
        (is_valid(reader, 0) || is_valid(reader, 1))) {
        trk_plane_direction(&reader->plane, both[0], both[1], sample->direction);
        sample->valid |= TRK_DIRECTION;
    }
    reader->table.reading->eyes_mean += trk_combine(sample);
    return set_point(reader, eyes, both, sample, out_error);
}

static bool read_tobii_lab(struct trk_reading *reading, char out_error[TRK_ERROR_SIZE])
{
    struct reader reader = {0};
    if (!begin(&reader, reading, out_error)) return false;
    if (!trk_table_read(&reader.table, read_row, &reader, out_error)) return false;
    if (reader.others) trk_assume(reading, "rows of other sensors, skipped: %zu", reader.others);
    return true;
}

/* The user of Tobii Pro Lab chooses which columns to export. */
static bool detect(const struct trk_reading *reading)
{
    static const char *const gaze[] = {
        "Gaze point X",           "Gaze point left X", "Gaze point right X", "Gaze direction left X",
        "Gaze direction right X", "Validity left",     "Validity right"};
    bool found = false;
    for (size_t i = 0; i < sizeof gaze / sizeof *gaze; i++)
        found |= trk_header_find(&reading->header, gaze[i]) >= 0;
    return found && trk_header_find(&reading->header, "Recording timestamp") >= 0;
}

const struct trk_log_format trk_log_tobii_lab = {
    .id = "tobii-lab",
    .name = "Tobii Pro Lab",
    .takes = TRK_TAKES_TIME_UNIT | TRK_TAKES_FRAME | TRK_TAKES_SCREEN | TRK_TAKES_RECORDING,
    .detect = detect,
    .read = read_tobii_lab,
};
