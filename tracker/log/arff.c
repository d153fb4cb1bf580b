/* The 360_em data set (Agtzidis et al. 2019): gaze on panoramic videos in a headset, as ARFF.
 *
 *   @RELATION gaze_360
 *   %@METADATA width_px 1920        size of the equirectangular panorama; also height_px
 *   @ATTRIBUTE time INTEGER         us
 *   ...                             x, y: gaze in the panorama, from head and eye together; confidence 0..1;
 *   ...                             x_head, y_head: the head's middle; angle_deg_head: its roll; labels
 *   @DATA
 *   125000,958.00,538.00,1.00,960.00,540.00,1.26,saccade
 *
 * The panorama's middle is straight ahead; x grows to the right and y down, as in any equirectangular picture
 * that is upright. So x and y give the world direction of gaze, whatever the head does. The head pose is yaw,
 * then pitch, then roll. The description does not give the sign of the roll; in the rotations of the data
 * set's own tool a positive roll tilts the head to the left. The roll changes the direction of gaze in the
 * head, but not in the world. A sample with a confidence below 0.5 is lost. The rows of the tests follow the
 * example in the description. */
#include "log/formats.h"

#include <cglm/cglm.h>
#include <math.h>
#include <string.h>
#include <strings.h>

#define MIN_CONFIDENCE 0.5

enum { TIME, X, Y, CONFIDENCE, X_HEAD, Y_HEAD, ROLL, COLUMNS };
static const char *const names[COLUMNS] = {"time",          "x", "y", "confidence", "x_head", "y_head",
                                           "angle_deg_head"};

struct reader {
    struct trk_table table;
    struct trk_log_clock clock;
    double size_px[2];
    int place[COLUMNS];
    uint64_t sequence;
};

static bool starts(const char *text, const char *word)
{
    return strncasecmp(text, word, strlen(word)) == 0;
}

/* Append the name of an attribute to the header line that describes the rows. */
static bool add_attribute(struct trk_reading *reading, char *header, const char *text)
{
    size_t used = strlen(header);
    text += strspn(text, " \t'\"");
    size_t length = strcspn(text, " \t'\"");
    if (length == 0 || memchr(text, ',', length) || used + length + 2 > sizeof reading->scratch) return false;
    snprintf(header + used, sizeof reading->scratch - used, "%s%.*s", used ? "," : "", (int)length, text);
    return true;
}

static bool read_declarations(struct reader *reader, struct trk_reading *reading, char *header,
                              char out_error[TRK_ERROR_SIZE])
{
    struct trk_lines *lines = &reading->lines;
    enum trk_line line = TRK_LINE;
    for (; line == TRK_LINE; line = trk_next_row(reading, out_error)) {
        const char *text = lines->text + strspn(lines->text, " \t");
        if (starts(text, "@data")) break;
        if (starts(text, "@relation") && !strcasestr(text, "gaze_360"))
            return trk_lines_fail(lines, out_error, "'%.60s', expected @RELATION gaze_360", text);
        if (starts(text, "@attribute") && !add_attribute(reading, header, text + strlen("@attribute")))
            return trk_lines_fail(lines, out_error, "'%.60s', expected @ATTRIBUTE and a name", text);
        const char *width = strcasestr(text, "@metadata width_px "),
                   *height = strcasestr(text, "@metadata height_px ");
        if (width && !trk_parse_double(width + 19, &reader->size_px[0])) reader->size_px[0] = 0;
        if (height && !trk_parse_double(height + 20, &reader->size_px[1])) reader->size_px[1] = 0;
    }
    if (line == TRK_LINE_FAILED) return false;
    if (line == TRK_LINE_END) return trk_lines_fail(lines, out_error, "no @DATA, expected it before the end");
    for (int i = 0; i < 2; i++)
        if (!(reader->size_px[i] >= 1 && reader->size_px[i] < 1e6))
            return trk_lines_fail(lines, out_error,
                                  "no size of the panorama, expected %%@METADATA %s_px before @DATA",
                                  i ? "height" : "width");
    trk_header_parse(&reading->header, header, ',');
    trk_table_init(&reader->table, reading);
    reader->table.comment = '%';
    reading->clock_names[0] = names[TIME];
    for (int i = 0; i < COLUMNS; i++) reader->place[i] = trk_header_find(&reading->header, names[i]);
    return trk_table_need(&reader->table, names, Y + 1, reader->place, out_error);
}

/* The angles in degrees to the right of and above the panorama's middle. False if the point is outside the
 * panorama. */
static bool angles_of(const struct reader *reader, double x, double y, double *out_yaw, double *out_pitch)
{
    *out_yaw = (x / reader->size_px[0] - 0.5) * 360;
    *out_pitch = (0.5 - y / reader->size_px[1]) * 180;
    return fabs(*out_pitch) <= 90.5 && fabs(*out_yaw) <= 720;
}

static bool read_row(void *context, struct trk_sample *sample, char out_error[TRK_ERROR_SIZE])
{
    struct reader *reader = context;
    struct trk_table *table = &reader->table;
    double value[COLUMNS], yaw, pitch;
    int64_t time_ns;
    sample->sequence = ++reader->sequence;
    if (!trk_table_time(table, reader->place[TIME], trk_time_unit(table->reading, 1e3), &time_ns,
                        out_error) ||
        !trk_log_clock_count(&reader->clock, time_ns, table->reading, &sample->device_ns, out_error))
        return false;
    sample->arrival_ns = sample->device_ns;
    for (int i = X; i < COLUMNS; i++)
        if (!trk_table_number(table, reader->place[i], &value[i], out_error)) return false;
    versor x, y, z, head = GLM_QUAT_IDENTITY_INIT;
    if (angles_of(reader, value[X_HEAD], value[Y_HEAD], &yaw, &pitch)) {
        glm_quatv(y, (float)(-yaw * M_PI / 180), GLM_YUP);
        glm_quatv(x, (float)(pitch * M_PI / 180), GLM_XUP);
        glm_quatv(z, isnan(value[ROLL]) ? 0 : (float)(fmod(value[ROLL], 360) * M_PI / 180), GLM_ZUP);
        glm_quat_mul(y, x, head);
        glm_quat_mul(head, z, head);
        glm_quat_normalize(head);
        memcpy(&sample->head[3], head, sizeof head);
        sample->valid |= TRK_HEAD;
    }
    if (value[CONFIDENCE] < MIN_CONFIDENCE || !angles_of(reader, value[X], value[Y], &yaw, &pitch))
        return true;
    vec3 direction;
    trk_angles_direction(yaw, fmin(fmax(pitch, -90), 90), direction);
    glm_quat_inv(head, head);
    glm_quat_rotatev(head, direction, direction);
    glm_vec3_normalize_to(direction, sample->direction);
    sample->valid |= TRK_DIRECTION;
    return true;
}

static bool read_arff(struct trk_reading *reading, char out_error[TRK_ERROR_SIZE])
{
    struct reader reader = {0};
    reading->scratch[0] = '\0';
    if (!read_declarations(&reader, reading, reading->scratch, out_error) ||
        !trk_table_read(&reader.table, read_row, &reader, out_error))
        return false;
    if (reader.place[X_HEAD] >= 0) trk_assume(reading, "a positive roll is the head's tilt to the left");
    return true;
}

/* Comments may precede @RELATION. */
static bool detect(const struct trk_reading *reading)
{
    for (const char *text = reading->head; text; text = strchr(text, '\n')) {
        text += strspn(text, " \t\r\n");
        if (starts(text, "@relation")) return true;
        if (*text != '%') return false;
    }
    return false;
}

const struct trk_log_format trk_log_arff = {
    .id = "360em",
    .name = "360_em ARFF",
    .takes = TRK_TAKES_TIME_UNIT,
    .detect = detect,
    .read = read_arff,
};
