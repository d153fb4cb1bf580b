/* Recordings of Tobii Pro Glasses 3: gazedata.gz, one JSON object per line, compressed with gzip or not.
 *
 *   {"type":"gaze","timestamp":0.01,"data":{"gaze2d":[..],"gaze3d":[..],
 *     "eyeleft":{"gazeorigin":[..],"gazedirection":[..],"pupildiameter":..},"eyeright":{..}}}
 *
 * timestamp is in seconds since the start of the recording. For lost gaze, "data" is empty; for a lost eye,
 * its object is empty or absent. Origins and gaze3d are in mm, in the head unit's frame, whose origin is the
 * scene camera: +X to the wearer's left, +Y up, +Z forward. How this is known: in quoted rows the left eye's
 * origin has x = +28 mm and the right eye's -31 mm, and a point with x = -82 mm lies in the right half of the
 * picture (gaze2d 0.54, from the top left corner). The combined gaze is computed from the eyes; if both eyes
 * are lost, it points to gaze3d. We had no recording; the rows of the tests are invented. */
#include "log/formats.h"

#include <jansson.h>
#include <string.h>

static bool read_vector(const json_t *array, float out_vector[3])
{
    if (json_array_size(array) != 3) return false; /* the size is 0 if it is not an array */
    for (size_t i = 0; i < 3; i++) {
        const json_t *number = json_array_get(array, i);
        if (!json_is_number(number)) return false;
        out_vector[i] = (float)json_number_value(number);
    }
    return true;
}

static void read_eye(const json_t *data, int eye, const struct trk_frame *frame, struct trk_sample *sample)
{
    const json_t *object = json_object_get(data, eye ? "eyeright" : "eyeleft");
    float vector[3];
    if (read_vector(json_object_get(object, "gazedirection"), vector))
        trk_set_direction(sample, eye, vector, frame);
    if (read_vector(json_object_get(object, "gazeorigin"), vector))
        trk_set_origin(sample, eye, vector, 1e-3f, frame);
    trk_set_pupil(sample, eye, json_number_value(json_object_get(object, "pupildiameter")));
}

static bool read_object(struct trk_reading *reading, const json_t *root, struct trk_log_clock *clock,
                        const struct trk_frame *frame, char out_error[TRK_ERROR_SIZE])
{
    const json_t *stamp = json_object_get(root, "timestamp"), *data = json_object_get(root, "data");
    const char *type = json_string_value(json_object_get(root, "type"));
    double time_ns = json_number_value(stamp) * trk_time_unit(reading, 1e9);
    if (!type || strcmp(type, "gaze") != 0)
        return trk_lines_fail(&reading->lines, out_error, "type is '%.20s', expected \"gaze\"",
                              type ? type : "");
    if (!json_is_number(stamp) || !(time_ns > -0x1p60 && time_ns < 0x1p60))
        return trk_lines_fail(&reading->lines, out_error, "has no timestamp, expected seconds");
    struct trk_sample sample = {.sequence = reading->log->count + 1};
    if (!trk_log_clock_count(clock, (int64_t)time_ns, reading, &sample.device_ns, out_error)) return false;
    sample.arrival_ns = sample.device_ns;
    read_eye(data, 0, frame, &sample);
    read_eye(data, 1, frame, &sample);
    reading->eyes_mean += trk_combine(&sample);
    float point[3];
    if (!(sample.valid & TRK_DIRECTION) && read_vector(json_object_get(data, "gaze3d"), point))
        trk_set_direction(&sample, 2, point, frame);
    return trk_log_append(reading, &sample, out_error);
}

/* Python writes NaN, which JSON does not allow. Replace it by an empty text, which the readers do not take
 * for a number either. */
static void blank_nans(char *text)
{
    for (char *at = text; (at = strcasestr(at, "nan")); at += 3)
        if (at > text && strchr(":[, -", at[-1]) && strchr(",]} ", at[3])) {
            if (at[-1] == '-') at[-1] = ' ';
            memcpy(at, "\"\" ", 3);
        }
}

static bool read_glasses3(struct trk_reading *reading, char out_error[TRK_ERROR_SIZE])
{
    struct trk_lines *lines = &reading->lines;
    struct trk_frame frame = trk_reading_frame(reading, "LUF");
    struct trk_log_clock clock = {0};
    enum trk_line line = TRK_LINE;
    reading->clock_names[0] = "timestamp";
    for (; line == TRK_LINE; line = trk_next_row(reading, out_error)) {
        json_error_t error;
        blank_nans(lines->text);
        json_t *root = json_loads(lines->text, 0, &error);
        if (!root) {
            trk_lines_fail(lines, out_error, "%.100s (at byte %d), expected a JSON object", error.text,
                           error.position);
            line = trk_short_row(reading);
            break;
        }
        bool ok = read_object(reading, root, &clock, &frame, out_error);
        json_decref(root);
        if (!ok) return false;
    }
    return line == TRK_LINE_END;
}

static bool detect(const struct trk_reading *reading)
{
    const char *text = reading->lines.text;
    return text[0] == '{' && strstr(text, "\"type\"") && strstr(text, "\"gaze\"") &&
           strstr(text, "\"timestamp\"");
}

const struct trk_log_format trk_log_glasses3 = {
    .id = "glasses3",
    .name = "Tobii Pro Glasses 3",
    .takes = TRK_TAKES_TIME_UNIT | TRK_TAKES_FRAME,
    .detect = detect,
    .closes = "}",
    .says_mean =
        "gaze is the mean of the eyes' directions, and not the way to gaze3d (only where neither eye has "
        "one)",
    .read = read_glasses3,
};
