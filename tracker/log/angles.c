/* Logs that hold gaze as angles: GazeBase, GazeBaseVR, and the tables of pymovements.
 *
 * GazeBase (EyeLink at 1000 Hz, one eye; Griffith et al. 2021): n is the time in ms. x and y are degrees of
 * visual angle from the middle of a screen, to the right and up. Each angle is measured in its own plane: the
 * tangent of x is the distance to the right divided by the viewing distance. The screen
 * is 47.4 x 29.7 cm large and 55 cm away. A sample with val above 0 is lost. dP is the pupil in an arbitrary
 * unit.
 *
 * GazeBaseVR (HTC Vive Pro with ET5, 250 Hz; Lohr et al. 2023): n is the time in ms. x and y belong to both
 * eyes together, lx and ly to the left eye, rx and ry to the right eye; all are degrees to the right and up
 * in the head, with up applied after right (azimuth and elevation). clx.. and crx.. are the eyes' centres in
 * metres, +X right, +Y up; xT, yT, zT are the target. How the signs are known: clx is -0.032 and crx is
 * +0.033, and for a target 0.44 m ahead the left eye turns to lx = +3.5 and the right eye to rx = -2.1,
 * inwards, so x grows to the right. The paper says that y grows upwards.
 *
 * pymovements writes time, pixel_x, pixel_y, position_x, position_y; position is in degrees as in GazeBase.
 * The table does not state the unit of time; the reader guesses it from the steps. The reader assumes that y
 * points up, although pixels would point down. The size of the screen is assumed, or an option gives it. */
#include "log/formats.h"

#include <math.h>
#include <string.h>

enum {
    TIME,
    X,
    Y,
    LEFT_X,
    LEFT_Y,
    RIGHT_X,
    RIGHT_Y,
    LOST,
    LEFT_CENTRE,
    RIGHT_CENTRE = LEFT_CENTRE + 3,
    COLUMNS = RIGHT_CENTRE + 3
};

struct layout {
    const char *names[COLUMNS]; /* NULL: the format lacks this column */
    bool
        apart; /* x and y are measured in separate planes, not as azimuth and elevation: gaze is at a screen */
    double half[2];    /* half the width and height of that screen, in viewing distances; 0: unknown */
    bool may_be_short; /* rows may lack the last columns */
    double unit_ns;    /* of one unit of time; 0: guess it */
};

static const struct layout gazebase = {
    .names = {"n", "x", "y", [LOST] = "val"},
    .apart = true,
    .half = {0.237 / 0.55, 0.1485 / 0.55},
    .unit_ns = 1e6,
};
static const struct layout gazebase_vr = {
    .names = {"n", "x", "y", "lx", "ly", "rx", "ry", NULL, "clx", "cly", "clz", "crx", "cry", "crz"},
    .unit_ns = 1e6,
};
static const struct layout pymovements = {
    .names = {"time", "position_x", "position_y"},
    .apart = true,
    .may_be_short = true,
};

struct reader {
    struct trk_table table;
    const struct layout *layout;
    struct trk_frame frame;
    struct trk_plane screen; /* if the layout is apart */
    struct trk_log_clock clock;
    double signs[2], unit_ns;
    int place[COLUMNS]; /* -1: none */
    uint64_t sequence;
};

static bool begin(struct reader *reader, struct trk_reading *reading, char out_error[TRK_ERROR_SIZE])
{
    const struct layout *layout = reader->layout;
    trk_table_init(&reader->table, reading);
    reader->table.may_be_short = layout->may_be_short;
    for (int i = 0; i < COLUMNS; i++) {
        reader->place[i] = -1;
        if (layout->names[i] &&
            !trk_table_need(&reader->table, &layout->names[i], 1, &reader->place[i], out_error))
            return false;
    }
    reading->clock_names[0] = reading->header.names[reader->place[TIME]];
    reader->frame = trk_reading_frame(reading, "RUF");
    if (!trk_reading_signs(reading, "RUF", reader->signs, out_error)) return false;
    memcpy(reader->screen.half, layout->half, sizeof layout->half);
    if (layout->apart && layout->half[0] == 0 &&
        !trk_plane_init(&reader->screen, reading, (double[]){1, 1}, 16.0 / 9, TRK_SCREEN_FOV_DEG,
                        "screen of 16:9", out_error))
        return false;
    reader->unit_ns = layout->unit_ns > 0
                          ? trk_time_unit(reading, layout->unit_ns)
                          : trk_table_guess_unit(&reader->table, reader->place[TIME], out_error);
    return reader->unit_ns > 0;
}

/* Read the gaze of one eye: 0 left, 1 right, 2 both. */
static bool read_gaze(struct reader *reader, int eye, int x_column, struct trk_sample *sample,
                      char out_error[TRK_ERROR_SIZE])
{
    static const struct trk_frame ours = {{0, 1, 2}, {1, 1, 1}};
    double x, y;
    float direction[3];
    if (!trk_table_number(&reader->table, reader->place[x_column], &x, out_error) ||
        !trk_table_number(&reader->table, reader->place[x_column + 1], &y, out_error))
        return false;
    /* A flat screen cannot be seen at 90 degrees or more. NaN marks lost gaze. */
    if (!(fabs(x) < (reader->layout->apart ? 89 : 180) && fabs(y) < 89)) return true;
    x *= reader->signs[0];
    y *= reader->signs[1];
    if (reader->layout->apart) {
        direction[0] = (float)tan(x * M_PI / 180);
        direction[1] = (float)tan(y * M_PI / 180);
        direction[2] = -1;
    } else {
        trk_angles_direction(x, y, direction);
    }
    trk_set_direction(sample, eye, direction, &ours);
    return true;
}

static bool read_row(void *context, struct trk_sample *sample, char out_error[TRK_ERROR_SIZE])
{
    struct reader *reader = context;
    double lost;
    int64_t time_ns;
    float centre[3];
    if (!trk_table_time(&reader->table, reader->place[TIME], reader->unit_ns, &time_ns, out_error) ||
        !trk_table_number(&reader->table, reader->place[LOST], &lost, out_error))
        return false;
    sample->sequence = ++reader->sequence;
    if (!trk_log_clock_count(&reader->clock, time_ns, reader->table.reading, &sample->device_ns, out_error))
        return false;
    sample->arrival_ns = sample->device_ns;
    if (lost > 0) return true;
    if (!read_gaze(reader, 2, X, sample, out_error)) return false;
    if (reader->layout->apart) trk_set_screen(sample, &reader->screen);
    if (reader->place[LEFT_X] < 0) return true;
    for (int eye = 0; eye < 2; eye++) {
        if (!read_gaze(reader, eye, LEFT_X + 2 * eye, sample, out_error) ||
            !trk_table_numbers(&reader->table, &reader->place[LEFT_CENTRE + 3 * eye], 3, centre, out_error))
            return false;
        trk_set_origin(sample, eye, centre, 1, &reader->frame);
    }
    reader->table.reading->eyes_mean += trk_combine(sample);
    return true;
}

static bool read_layout(const struct layout *layout, struct trk_reading *reading,
                        char out_error[TRK_ERROR_SIZE])
{
    struct reader reader = {.layout = layout};
    if (!begin(&reader, reading, out_error)) return false;
    if (!trk_table_read(&reader.table, read_row, &reader, out_error)) return false;
    return true;
}

static bool read_gazebase(struct trk_reading *reading, char out_error[TRK_ERROR_SIZE])
{
    return read_layout(&gazebase, reading, out_error);
}

static bool read_gazebase_vr(struct trk_reading *reading, char out_error[TRK_ERROR_SIZE])
{
    return read_layout(&gazebase_vr, reading, out_error);
}

static bool read_pymovements(struct trk_reading *reading, char out_error[TRK_ERROR_SIZE])
{
    trk_assume(reading, "position is in degrees, to the right and up");
    return read_layout(&pymovements, reading, out_error);
}

const struct trk_log_format trk_log_gazebase = {
    .id = "gazebase",
    .name = "GazeBase",
    .takes = TRK_TAKES_TIME_UNIT | TRK_TAKES_FRAME | TRK_TAKES_RECORDING,
    .columns = {"n", "x", "y", "val", "dP", "lab"},
    .read = read_gazebase,
};

const struct trk_log_format trk_log_gazebase_vr = {
    .id = "gazebase-vr",
    .name = "GazeBaseVR",
    .takes = TRK_TAKES_TIME_UNIT | TRK_TAKES_FRAME | TRK_TAKES_RECORDING,
    .columns = {"n", "x", "y", "lx", "rx", "clx"},
    .read = read_gazebase_vr,
};

const struct trk_log_format trk_log_pymovements = {
    .id = "pymovements",
    .name = "pymovements",
    .takes = TRK_TAKES_TIME_UNIT | TRK_TAKES_FRAME | TRK_TAKES_SCREEN | TRK_TAKES_RECORDING,
    .columns = {"time", "position_x", "position_y", "pixel_x"},
    .read = read_pymovements,
};
