/* EyeLink's ASC files, as edf2asc writes them: lines of tabs and spaces.
 *
 *   ** ...                                                 comments at the start
 *   MSG <ms> GAZE_COORDS <left> <top> <right> <bottom>     the screen in pixels; older DISPLAY_COORDS
 *   SAMPLES GAZE LEFT RIGHT RATE 1000.00 ...               what samples hold, and how often
 *   1408660  964.3 541.5 288.0  960.5 538.8 305.0  .....   ms; x, y and pupil of each eye, `.` is lost
 *   SBLINK L <ms>, EBLINK L <ms> <ms> ...                  and other events
 *   END <ms> SAMPLES EVENTS RES 35.18 35.14                pixels a degree across and down, on average
 *
 * Times are whole ms, or at 2000 Hz either halves or every ms twice: of equal times the later ones are moved
 * by what the rate says. Pixels count from the top left corner, so that x is to the right and y down. A real
 * blink agrees: as the lid closes, eyes roll down and towards the nose, and there the right eye's y grows
 * and its x falls before it is lost (the test looks at it). The screen's angle follows from RES, unless
 * options say another; without both it is a default. The pupil has arbitrary units and is left out. A closed
 * eye is marked by openness 0; outside of blinks nothing is said about it. Only GAZE samples have a place on
 * the screen: files with HREF or PUPIL ones are refused. Between recordings (START to END) time goes on and
 * no sample is lost. */
#include "log/formats.h"

#include <ctype.h>
#include <math.h>
#include <string.h>

enum { LEFT_EYE = 1, RIGHT_EYE = 2 };

struct reader {
    struct trk_reading *reading;
    struct trk_log_clock clock;
    unsigned eyes, closed; /* LEFT_EYE, RIGHT_EYE */
    double rate_hz;
    double edges[4];      /* left, top, right, bottom: px; NaN if unknown */
    double resolution[2]; /* px a degree, summed over recordings */
    size_t resolutions;
    int64_t last_ns;
    size_t equal, spread; /* samples that repeat the last time; that were moved for it */
    uint64_t sequence;
};

/* The numbers after a word of a line; how many there were. */
static int numbers_after(const char *text, const char *word, double *out_numbers, int n)
{
    const char *at = strstr(text, word);
    if (!at) return 0;
    at += strlen(word);
    for (int i = 0; i < n; i++) {
        char field[32];
        at += strspn(at, " \t");
        size_t length = strcspn(at, " \t");
        if (length >= sizeof field) return i;
        memcpy(field, at, length);
        field[length] = '\0';
        if (!trk_parse_double(field, &out_numbers[i]) || !(fabs(out_numbers[i]) < 1e6)) return i;
        at += length;
    }
    return n;
}

static bool read_samples_line(struct reader *reader, char out_error[TRK_ERROR_SIZE])
{
    const char *text = reader->reading->lines.text;
    double rate;
    if (!strstr(text, "GAZE"))
        return trk_lines_fail(
            &reader->reading->lines, out_error,
            "samples are '%.40s', expected GAZE (no place on the screen follows from others)",
            text + strlen("SAMPLES"));
    reader->eyes = (strstr(text, "LEFT") ? LEFT_EYE : 0) | (strstr(text, "RIGHT") ? RIGHT_EYE : 0);
    reader->rate_hz = numbers_after(text, "RATE", &rate, 1) == 1 && rate >= 1 && rate <= 1e5 ? rate : 0;
    return true;
}

static unsigned eye_of(const char *text)
{
    text += strcspn(text, " \t");
    text += strspn(text, " \t");
    return *text == 'L' ? LEFT_EYE : *text == 'R' ? RIGHT_EYE : 0;
}

/* Whatever is no sample. Unknown lines are let be: calibration writes all kinds. */
static bool read_event(struct reader *reader, char out_error[TRK_ERROR_SIZE])
{
    const char *text = reader->reading->lines.text;
    double numbers[4];
    if (strncmp(text, "SAMPLES", 7) == 0) return read_samples_line(reader, out_error);
    if (strncmp(text, "SBLINK", 6) == 0) reader->closed |= eye_of(text);
    if (strncmp(text, "EBLINK", 6) == 0) reader->closed &= ~eye_of(text);
    if (strncmp(text, "START", 5) == 0) reader->closed = 0;
    if (strncmp(text, "MSG", 3) == 0 &&
        (numbers_after(text, " GAZE_COORDS", numbers, 4) == 4 ||
         (isnan(reader->edges[0]) && numbers_after(text, " DISPLAY_COORDS", numbers, 4) == 4)))
        if (numbers[2] > numbers[0] && numbers[3] > numbers[1])
            memcpy(reader->edges, numbers, sizeof numbers);
    if (strncmp(text, "END", 3) == 0 && numbers_after(text, "RES", numbers, 2) == 2 && numbers[0] > 1 &&
        numbers[1] > 1) {
        reader->resolution[0] += numbers[0];
        reader->resolution[1] += numbers[1];
        reader->resolutions++;
    }
    return true;
}

/* The place on the screen is kept as it is until the whole file is read, because RES comes last. */
static bool read_eye(struct reader *reader, int eye, char *const fields[2], struct trk_sample *sample,
                     char out_error[TRK_ERROR_SIZE])
{
    double place[2];
    for (int i = 0; i < 2; i++) {
        if (strcmp(fields[i], ".") == 0) return true;
        if (!trk_parse_double(fields[i], &place[i]) || !(fabs(place[i]) < 1e6))
            return trk_lines_fail(&reader->reading->lines, out_error,
                                  "gaze is '%.20s', expected pixels or '.'", fields[i]);
        sample->eye[eye].direction[i] = (float)place[i];
    }
    sample->valid |= TRK_LEFT_DIRECTION << 4 * eye;
    return true;
}

static bool read_sample(struct reader *reader, char out_error[TRK_ERROR_SIZE])
{
    struct trk_lines *lines = &reader->reading->lines;
    char *fields[TRK_MAX_FIELDS];
    int64_t time_ns;
    size_t count = trk_split(lines->text, TRK_BLANKS, fields);
    size_t eyes = (reader->eyes & LEFT_EYE ? 1 : 0) + (reader->eyes & RIGHT_EYE ? 1 : 0);
    if (eyes == 0)
        return trk_lines_fail(lines, out_error, "sample of unknown eyes, expected a line SAMPLES before it");
    if (count < 1 + 3 * eyes)
        return trk_lines_fail(lines, out_error, "%zu columns, expected at least %zu", count, 1 + 3 * eyes);
    if (!trk_parse_time(fields[0], trk_time_unit(reader->reading, 1e6), &time_ns))
        return trk_lines_fail(lines, out_error, "time is '%.20s', expected ms", fields[0]);
    struct trk_sample sample = {.sequence = ++reader->sequence};
    reader->equal = reader->sequence > 1 && time_ns == reader->last_ns ? reader->equal + 1 : 0;
    reader->last_ns = time_ns;
    double later_ns = reader->rate_hz > 0 ? (double)reader->equal * 1e9 / reader->rate_hz : 0;
    if (later_ns > 0 && later_ns < 1e6) {
        time_ns += (int64_t)later_ns;
        reader->spread++;
    }
    if (!trk_log_clock_count(&reader->clock, time_ns, lines, &sample.device_ns, out_error)) return false;
    sample.arrival_ns = sample.device_ns;
    char **place = &fields[1];
    for (int eye = 0; eye < 2; eye++) {
        if (reader->closed >> eye & 1) trk_set_openness(&sample, eye, 0);
        if (!(reader->eyes >> eye & 1)) continue;
        if (!read_eye(reader, eye, place, &sample, out_error)) return false;
        place += 3;
    }
    return trk_log_append(reader->reading, &sample, out_error);
}

/* From pixels to directions, now that all is known. */
static bool turn_samples(struct reader *reader, char out_error[TRK_ERROR_SIZE])
{
    struct trk_reading *reading = reader->reading;
    struct trk_plane plane;
    double *edges = reader->edges, fov_deg = TRK_SCREEN_FOV_DEG, squeeze = 1;
    char what[64] = "screen";
    if (isnan(edges[0])) {
        memcpy(edges, (double[]){0, 0, 1919, 1079}, 4 * sizeof *edges);
        trk_assume(reading, "screen of 1920 x 1080 px");
    }
    double width = edges[2] - edges[0] + 1, height = edges[3] - edges[1] + 1;
    if (reader->resolutions) {
        double across = reader->resolution[0] / (double)reader->resolutions;
        fov_deg = 2 * atan(width / 2 * tan(M_PI / 180) / across) * 180 / M_PI;
        squeeze = reader->resolution[1] / reader->resolution[0];
        snprintf(what, sizeof what, "by the file's %.1f px a degree the screen is", across);
    }
    if (!trk_plane_init(&plane, reading, width, height, width / height * squeeze, fov_deg, what, out_error))
        return false;
    plane.middle[0] += edges[0];
    plane.middle[1] += edges[1];
    for (size_t i = 0; i < reading->log->count; i++) {
        struct trk_sample *sample = &reading->log->samples[i];
        for (int eye = 0; eye < 2; eye++) {
            float *direction = sample->eye[eye].direction;
            if (sample->valid & TRK_LEFT_DIRECTION << 4 * eye)
                trk_plane_direction(&plane, direction[0], direction[1], direction);
        }
        trk_combine(sample);
    }
    return true;
}

static bool read_eyelink(struct trk_reading *reading, char out_error[TRK_ERROR_SIZE])
{
    struct reader reader = {.reading = reading, .edges = {NAN, NAN, NAN, NAN}};
    enum trk_line line = TRK_LINE;
    for (; line == TRK_LINE; line = trk_lines_next(&reading->lines, out_error)) {
        bool is_sample = isdigit((unsigned char)reading->lines.text[0]);
        if (!(is_sample ? read_sample(&reader, out_error) : read_event(&reader, out_error))) return false;
    }
    if (line == TRK_LINE_FAILED) return false;
    if (reader.spread)
        trk_assume(reading,
                   "samples with the same millisecond as the one before, spread evenly at %g Hz: %zu",
                   reader.rate_hz, reader.spread);
    if (reader.clock.held) trk_assume(reading, "times that go back, held: %zu", reader.clock.held);
    return turn_samples(&reader, out_error);
}

static bool detect(const struct trk_reading *reading)
{
    const char *head = reading->head, *text = reading->lines.text;
    if (strncmp(text, "** ", 3) == 0) return strstr(head, "CONVERTED FROM") || strstr(head, "EYELINK");
    return (strncmp(text, "MSG", 3) == 0 || strncmp(text, "START", 5) == 0) && strstr(head, "\nSAMPLES");
}

const struct trk_log_format trk_log_eyelink = {
    .id = "eyelink",
    .name = "EyeLink ASC",
    .takes = TRK_TAKES_TIME_UNIT | TRK_TAKES_FRAME | TRK_TAKES_SCREEN,
    .detect = detect,
    .read = read_eyelink,
};
