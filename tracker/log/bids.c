/* BIDS eye tracking (BEP020): NAME.tsv.gz, a table without a header. JSON files beside it and in the folders
 * above describe it (bids_sidecar.c).
 *
 * The sidecar's Columns lists the columns: timestamp, x_coordinate, y_coordinate, perhaps pupil_size, and
 * others, which the reader ignores. The sidecar describes each column in an object of the column's name,
 * which has its Units. SampleCoordinateSystem is gaze-on-screen (pixels, counted from the top left corner
 * unless ScreenOrigin says otherwise; or degrees), eye-in-head or gaze-in-world (degrees or radians to the
 * right and up, with up applied after right). RecordedEye is left, right or cyclopean; each eye has a file of
 * its own. SamplingFrequency is in Hz. A missing value is n/a. ScreenResolution (px), ScreenSize and
 * ScreenDistance (m) and ScreenOrigin (the corner that pixels count from) are in StimulusPresentation of the
 * events' metadata. Drafts of the specification had them in the sidecar; if they are there, the sidecar's
 * values count. BIDS does not say which way degrees count: the reader assumes right and up, and says so in a
 * note. The files that this project writes (bids_write.c) state it. Files with the suffix physioevents hold
 * the tracker's events and no gaze. We had no real file: the rows of the tests are invented; one of them
 * follows the specification's example. */
#include "log/bids_sidecar.h"
#include "log/formats.h"

#include "error.h"

#include <math.h>
#include <string.h>
#include <strings.h>

enum { TIME, X, Y, PUPIL, COLUMNS };
static const char *const names[COLUMNS] = {"timestamp", "x_coordinate", "y_coordinate", "pupil_size"};

enum place { ON_SCREEN_PX, ON_SCREEN_DEG, IN_ANGLES };

struct reader {
    struct trk_reading *reading;
    json_t *sidecar, *events;
    struct trk_table table;
    struct trk_plane plane;
    struct trk_log_clock clock;
    enum place place_kind;
    double signs[2], degrees; /* degrees: per unit of x and y */
    double unit_ns;
    bool pupil_in_mm;
    int eye; /* 0 left, 1 right, 2 both */
    int place[COLUMNS];
    uint64_t sequence;
};

/* --- the sidecar --- */

static bool load_both(struct reader *reader, char out_error[TRK_ERROR_SIZE])
{
    const char *path = reader->reading->lines.path;
    struct trk_bids_places places;
    char suffix[32];
    trk_bids_suffix(path, suffix);
    if (strcmp(suffix, "physioevents") == 0)
        return trk_lines_fail(&reader->reading->lines, out_error,
                              "is BIDS events (onset, duration, ... by *_physioevents.json), expected the "
                              "_physio.tsv.gz of the gaze that lies beside it");
    reader->sidecar = trk_bids_inherit(reader->reading, NULL, &places, out_error);
    if (!reader->sidecar) return false;
    if (json_object_get(reader->sidecar, "Columns")) {
        reader->events = trk_bids_inherit(reader->reading, "events", &places, out_error);
        return reader->events;
    }
    return trk_fail(out_error,
                    "%.150s: a table without header, and no BIDS sidecar has Columns; expected them in the "
                    "%s.json beside it or in one above it, up to %.120s (%zu looked at)",
                    path, *suffix ? suffix : "NAME", places.top, places.files);
}

static const char *text_of(const json_t *object, const char *key)
{
    const char *text = json_string_value(json_object_get(object, key));
    return text ? text : "";
}

static const json_t *screen_key(const struct reader *reader, const char *key)
{
    const json_t *value = json_object_get(reader->sidecar, key);
    if (!value) value = json_object_get(json_object_get(reader->sidecar, "StimulusPresentation"), key);
    return value ? value : json_object_get(json_object_get(reader->events, "StimulusPresentation"), key);
}

/* The names in Columns become the header of the rows. */
static bool read_columns(struct reader *reader, char out_error[TRK_ERROR_SIZE])
{
    struct trk_reading *reading = reader->reading;
    const json_t *root = reader->sidecar;
    const json_t *columns = json_object_get(root, "Columns");
    char *header = reading->scratch;
    size_t used = 0;
    header[0] = '\0';
    for (size_t i = 0; i < json_array_size(columns); i++) {
        const char *name = json_string_value(json_array_get(columns, i));
        if (!name || !*name || strpbrk(name, "\t\r\n") || used + strlen(name) + 2 > sizeof reading->scratch)
            return trk_lines_fail(&reading->lines, out_error,
                                  "entry %zu of the sidecar's Columns is not a name, expected a short text",
                                  i + 1);
        used += (size_t)sprintf(header + used, "%s%s", used ? "\t" : "", name);
    }
    trk_header_parse(&reading->header, header, '\t');
    trk_table_init(&reader->table, reading);
    for (int i = 0; i < COLUMNS; i++) {
        reader->place[i] = trk_header_find(&reading->header, names[i]);
        if (reader->place[i] < 0 && i != PUPIL)
            return trk_lines_fail(&reading->lines, out_error,
                                  "the sidecar's Columns lacks a column, expected '%s'%s", names[i],
                                  trk_header_find(&reading->header, "onset") >= 0
                                      ? " (these are events: the gaze is in the _physio.tsv.gz)"
                                      : "");
    }
    reading->clock_names[0] = names[TIME];
    reader->pupil_in_mm = strcasecmp(text_of(json_object_get(root, names[PUPIL]), "Units"), "mm") == 0;
    return true;
}

static bool read_time_unit(struct reader *reader, char out_error[TRK_ERROR_SIZE])
{
    static const struct {
        const char *name;
        double ns;
    } units[] = {{"s", 1e9},  {"sec", 1e9}, {"second", 1e9}, {"seconds", 1e9},
                 {"ms", 1e6}, {"us", 1e3},  {"ns", 1},       {"milliseconds", 1e6}};
    const char *unit = text_of(json_object_get(reader->sidecar, names[TIME]), "Units");
    reader->unit_ns = trk_time_unit(reader->reading, 0);
    for (size_t i = 0; i < sizeof units / sizeof *units && reader->unit_ns == 0; i++)
        if (strcasecmp(unit, units[i].name) == 0) reader->unit_ns = units[i].ns;
    if (reader->unit_ns > 0) return true;
    /* The first row has already been read; the guess reads it again. */
    reader->unit_ns = trk_table_guess_unit(&reader->table, reader->place[TIME], out_error);
    return reader->unit_ns > 0;
}

/* Set the signs of the plane for the corner that the pixels count from. */
static bool turn_to_origin(struct reader *reader, char out_error[TRK_ERROR_SIZE])
{
    static const char *const sides[2][2] = {{"left", "right"}, {"bottom", "top"}};
    struct trk_reading *reading = reader->reading;
    const json_t *origin = screen_key(reader, "ScreenOrigin");
    bool is_seen[2] = {false, false};
    if (reading->options->frame) return true; /* the option says where x and y point */
    if (!origin) {
        trk_assume(reading, "pixels count from the screen's top left corner");
        return true;
    }
    for (size_t i = 0; i < json_array_size(origin); i++) {
        const char *side = json_string_value(json_array_get(origin, i));
        for (int axis = 0; axis < 2; axis++)
            for (int end = 0; end < 2 && side; end++) {
                if (strcasecmp(side, sides[axis][end]) != 0) continue;
                is_seen[axis] = true;
                reader->plane.sign[axis] = end ? -1 : 1;
            }
    }
    if (is_seen[0] && is_seen[1]) return true;
    return trk_lines_fail(
        &reading->lines, out_error,
        "ScreenOrigin is not a corner, expected top or bottom and left or right, or an option for the frame");
}

static bool init_screen(struct reader *reader, char out_error[TRK_ERROR_SIZE])
{
    struct trk_reading *reading = reader->reading;
    const json_t *pixels = screen_key(reader, "ScreenResolution"), *size = screen_key(reader, "ScreenSize");
    double width = json_number_value(json_array_get(pixels, 0)),
           height = json_number_value(json_array_get(pixels, 1));
    double across = json_number_value(json_array_get(size, 0)),
           up = json_number_value(json_array_get(size, 1));
    double distance = json_number_value(screen_key(reader, "ScreenDistance")), fov_deg = TRK_SCREEN_FOV_DEG;
    const char *what = "screen";
    if (!(width >= 1 && width < 1e6 && height >= 1 && height < 1e6)) {
        width = 1920;
        height = 1080;
        if (reader->place_kind == ON_SCREEN_PX) trk_assume(reading, "screen of 1920 x 1080 px");
    }
    double aspect = width / height;
    if (across > 0.01 && across < 100 && up > 0.01 && up < 100) aspect = across / up;
    if (across > 0.01 && across < 100 && distance > 0.01 && distance < 100) {
        fov_deg = 2 * atan(across / 2 / distance) * 180 / M_PI;
        what = "by the sidecar the screen is";
    }
    return trk_plane_init(&reader->plane, reading, (double[]){width, height}, aspect, fov_deg, what,
                          out_error) &&
           (reader->place_kind != ON_SCREEN_PX || turn_to_origin(reader, out_error));
}

/* What x and y are. */
static bool read_place(struct reader *reader, char out_error[TRK_ERROR_SIZE])
{
    struct trk_reading *reading = reader->reading;
    const json_t *root = reader->sidecar;
    const char *system = text_of(root, "SampleCoordinateSystem"), *eye = text_of(root, "RecordedEye");
    const char *unit = text_of(json_object_get(root, names[X]), "Units");
    if (!*unit) unit = text_of(root, "SampleCoordinateUnits");
    bool on_screen = strcmp(system, "gaze-on-screen") == 0, is_deg = strncasecmp(unit, "deg", 3) == 0;
    reader->eye = strcmp(eye, "left") == 0 ? 0 : strcmp(eye, "right") == 0 ? 1 : 2;
    if (!on_screen && strcmp(system, "eye-in-head") != 0 && strcmp(system, "gaze-in-world") != 0)
        return trk_lines_fail(
            &reading->lines, out_error,
            "the sidecar's SampleCoordinateSystem is '%.30s', expected gaze-on-screen, eye-in-head or "
            "gaze-in-world",
            system);
    if (on_screen && (strncasecmp(unit, "pixel", 5) == 0 || strcasecmp(unit, "px") == 0)) {
        reader->place_kind = ON_SCREEN_PX;
        return init_screen(reader, out_error);
    }
    if (!is_deg && (on_screen || strncasecmp(unit, "rad", 3) != 0))
        return trk_lines_fail(&reading->lines, out_error, "x_coordinate's Units are '%.20s', expected %s",
                              unit, on_screen ? "pixel or deg" : "deg or rad");
    reader->place_kind = on_screen ? ON_SCREEN_DEG : IN_ANGLES;
    reader->degrees = is_deg ? 1 : 180 / M_PI;
    if (!strstr(text_of(json_object_get(root, names[Y]), "Description"), "up"))
        trk_assume(reading, "x and y count to the right and up");
    return (!on_screen || init_screen(reader, out_error)) &&
           trk_reading_signs(reading, "RUF", reader->signs, out_error);
}

/* --- the rows --- */

static void set_gaze(struct reader *reader, double x, double y, struct trk_sample *sample)
{
    static const struct trk_frame ours = {{0, 1, 2}, {1, 1, 1}};
    float direction[3];
    if (reader->place_kind == ON_SCREEN_PX) {
        if (!isfinite(x) || !isfinite(y)) return;
        trk_plane_direction(&reader->plane, x, y, direction);
    } else {
        bool apart = reader->place_kind == ON_SCREEN_DEG;
        x *= reader->signs[0] * reader->degrees;
        y *= reader->signs[1] * reader->degrees;
        if (!(fabs(x) < (apart ? 89 : 361) && fabs(y) < (apart ? 89 : 90.01))) return;
        if (apart)
            memcpy(direction, (float[]){(float)tan(x * M_PI / 180), (float)tan(y * M_PI / 180), -1},
                   sizeof direction);
        else
            trk_angles_direction(x, y, direction);
    }
    if (reader->eye < 2) trk_set_direction(sample, reader->eye, direction, &ours);
    trk_set_direction(sample, 2, direction, &ours);
    if (reader->place_kind != IN_ANGLES) trk_set_screen(sample, &reader->plane);
}

static bool read_row(struct reader *reader, char out_error[TRK_ERROR_SIZE])
{
    struct trk_sample sample = {.sequence = ++reader->sequence};
    double x, y, pupil;
    int64_t time_ns;
    if (!trk_table_time(&reader->table, reader->place[TIME], reader->unit_ns, &time_ns, out_error) ||
        !trk_log_clock_count(&reader->clock, time_ns, reader->reading, &sample.device_ns, out_error) ||
        !trk_table_number(&reader->table, reader->place[X], &x, out_error) ||
        !trk_table_number(&reader->table, reader->place[Y], &y, out_error) ||
        !trk_table_number(&reader->table, reader->place[PUPIL], &pupil, out_error))
        return false;
    sample.arrival_ns = sample.device_ns;
    set_gaze(reader, x, y, &sample);
    if (reader->eye < 2 && reader->pupil_in_mm) trk_set_pupil(&sample, reader->eye, pupil);
    return trk_log_append(reader->reading, &sample, out_error);
}

static bool read_bids(struct trk_reading *reading, char out_error[TRK_ERROR_SIZE])
{
    struct reader reader = {.reading = reading};
    bool ok = load_both(&reader, out_error) && read_columns(&reader, out_error) &&
              read_time_unit(&reader, out_error) && read_place(&reader, out_error);
    json_decref(reader.sidecar);
    json_decref(reader.events);
    if (!ok) return false;
    enum trk_line line = trk_table_first(&reader.table, out_error);
    for (; line == TRK_LINE; line = trk_table_next(&reader.table, out_error))
        if (!read_row(&reader, out_error)) return false;
    return line == TRK_LINE_END;
}

/* The first line is already numbers, separated by tabs. If the file has a name that BIDS prescribes, other
 * columns may stand between the numbers. */
static bool detect(const struct trk_reading *reading)
{
    const struct trk_header *header = &reading->header;
    char suffix[32];
    trk_bids_suffix(reading->lines.path, suffix);
    if (header->separator != '\t' || header->count < 2 || header->count > TRK_MAX_FIELDS) return false;
    if (strcmp(suffix, "physioevents") == 0) return true;
    size_t numbers = 0;
    for (size_t i = 0; i < header->count; i++) {
        char *comma = strchr(header->names[i], ',');
        double value;
        if (comma) *comma = '.';
        numbers += trk_is_missing(header->names[i]) || trk_parse_double(header->names[i], &value);
        if (comma) *comma = ',';
    }
    return (numbers == header->count && numbers >= 3) || (strcmp(suffix, "physio") == 0 && numbers >= 2);
}

const struct trk_log_format trk_log_bids = {
    .id = "bids",
    .name = "BIDS eye tracking",
    .takes = TRK_TAKES_TIME_UNIT | TRK_TAKES_FRAME | TRK_TAKES_SCREEN | TRK_TAKES_RECORDING,
    .detect = detect,
    .read = read_bids,
};
