/* EyeLink's ASC files, as edf2asc writes them: lines with tabs and spaces.
 *
 *   ** ...                                                 comments at the start
 *   MSG <ms> GAZE_COORDS <left> <top> <right> <bottom>     the screen in pixels; older DISPLAY_COORDS
 *   SAMPLES GAZE LEFT RIGHT RATE 1000.00 ...               what samples hold, and how often
 *   1408660  964.3 541.5 288.0  960.5 538.8 305.0  .....   ms; x, y and pupil of each eye, `.` is lost
 *   SBLINK L <ms>, EBLINK L <ms> <ms> ...                  and other events
 *   END <ms> SAMPLES EVENTS RES 35.18 35.14                pixels per degree across and down, on average
 *
 * Times are whole ms. At 2000 Hz they are halves of a ms, or each ms occurs twice; then the reader moves the
 * later samples of equal time by periods of the rate. Pixels count from the top left corner, with x to the
 * right and y down. A real blink agrees with that: as the lid closes, the eyes roll down and towards the
 * nose, and in the file the right eye's y grows and its x falls before it is lost (a test checks it). The
 * screen's angle follows from RES, unless the options give another; without either, a default is used.
 * Resolution and coordinates may change from one recording (START to END) to the next; each recording is
 * converted with its own. The reader ignores the pupil, which has arbitrary units. During a blink the eye has
 * openness 0; at other times openness is unknown. Only GAZE samples have a place on the screen, so files with
 * HREF or PUPIL samples are refused. Between recordings time goes on, and no sample counts as lost. */
#include "error.h"
#include "log/formats.h"
#include "log/samples.h"

#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { LEFT_EYE = 1, RIGHT_EYE = 2 };

/* Consecutive samples that were seen on the same screen. */
struct segment {
    size_t first;         /* index of its first sample in the log */
    double edges[4];      /* left, top, right, bottom: px; NaN if unknown */
    double resolution[2]; /* px per degree, across and down; NaN if unknown */
};

struct reader {
    struct trk_reading *reading;
    struct segment *segments;
    size_t segment_count, block; /* block: the first segment since the last START */
    bool has_gaze_coords;
    struct trk_log_clock clock;
    unsigned eyes, closed; /* LEFT_EYE, RIGHT_EYE */
    double rate_hz;
    double edges[4]; /* of the current screen, as in a segment */
    int64_t last_ns;
    size_t equal, spread; /* samples that repeat the last time; samples moved for that reason */
    uint64_t sequence;
};

/* Read up to n numbers that follow a word in a line. Returns how many were read. */
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
        return trk_lines_fail(&reader->reading->lines, out_error,
                              "samples are '%.40s', expected GAZE (others give no place on the screen)",
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

/* Begin a segment, because the screen may change from the next sample on. */
static bool begin_segment(struct reader *reader, char out_error[TRK_ERROR_SIZE])
{
    const size_t first = reader->reading->log->count;
    size_t count = reader->segment_count;
    if (count && reader->segments[count - 1].first == first) count--; /* it has no samples */
    if ((count & (count - 1)) == 0) {
        size_t room = count ? 2 * count : 1;
        struct segment *grown = realloc(reader->segments, room * sizeof *grown);
        if (!grown) return trk_lines_fail(&reader->reading->lines, out_error, "no memory");
        reader->segments = grown;
    }
    struct segment *segment = &reader->segments[count];
    *segment = (struct segment){.first = first, .resolution = {NAN, NAN}};
    memcpy(segment->edges, reader->edges, sizeof segment->edges);
    reader->segment_count = count + 1;
    return true;
}

/* DISPLAY_COORDS counts only as long as there was no GAZE_COORDS. */
static bool read_coordinates(struct reader *reader, char out_error[TRK_ERROR_SIZE])
{
    const char *text = reader->reading->lines.text;
    double numbers[4];
    if (numbers_after(text, " GAZE_COORDS", numbers, 4) == 4)
        reader->has_gaze_coords = true;
    else if (reader->has_gaze_coords || numbers_after(text, " DISPLAY_COORDS", numbers, 4) != 4)
        return true;
    if (!(numbers[2] > numbers[0] && numbers[3] > numbers[1])) return true;
    if (memcmp(reader->edges, numbers, sizeof numbers) == 0) return true;
    memcpy(reader->edges, numbers, sizeof numbers);
    return begin_segment(reader, out_error);
}

/* Read a line that is not a sample. Unknown lines are ignored, because calibration writes many kinds of
 * lines. */
static bool read_event(struct reader *reader, char out_error[TRK_ERROR_SIZE])
{
    const char *text = reader->reading->lines.text;
    double numbers[2];
    if (strncmp(text, "SAMPLES", 7) == 0) return read_samples_line(reader, out_error);
    if (strncmp(text, "SBLINK", 6) == 0) reader->closed |= eye_of(text);
    if (strncmp(text, "EBLINK", 6) == 0) reader->closed &= ~eye_of(text);
    if (strncmp(text, "MSG", 3) == 0) return read_coordinates(reader, out_error);
    if (strncmp(text, "START", 5) == 0) {
        reader->closed = 0;
        if (!begin_segment(reader, out_error)) return false;
        reader->block = reader->segment_count - 1;
    }
    if (strncmp(text, "END", 3) == 0 && numbers_after(text, "RES", numbers, 2) == 2 && numbers[0] > 1 &&
        numbers[1] > 1)
        for (size_t i = reader->block; i < reader->segment_count; i++)
            memcpy(reader->segments[i].resolution, numbers, sizeof numbers);
    return true;
}

/* Keep the gaze in pixels for now: RES, which the conversion needs, comes only at the end. */
static bool read_eye(struct reader *reader, int eye, char *const fields[2], struct trk_sample *sample,
                     char out_error[TRK_ERROR_SIZE])
{
    double place[2];
    for (int i = 0; i < 2; i++) {
        bool is_number = trk_field_number(reader->reading, fields[i], &place[i]);
        if (is_number && isnan(place[i])) return true;
        if (!is_number || !(fabs(place[i]) < 1e6))
            return trk_lines_fail(&reader->reading->lines, out_error,
                                  "gaze is '%.20s', expected pixels or '.'", fields[i]);
        sample->eye[eye].direction[i] = (float)place[i];
    }
    sample->valid |= TRK_LEFT_DIRECTION << 4 * eye;
    return true;
}

/* place: x, y and pupil of each recorded eye. */
static bool take_sample(struct reader *reader, int64_t time_ns, char *const *place,
                        char out_error[TRK_ERROR_SIZE])
{
    if (reader->segment_count == 0 && !begin_segment(reader, out_error)) return false;
    struct trk_sample sample = {.sequence = ++reader->sequence};
    reader->equal = reader->sequence > 1 && time_ns == reader->last_ns ? reader->equal + 1 : 0;
    reader->last_ns = time_ns;
    double later_ns = reader->rate_hz > 0 ? (double)reader->equal * 1e9 / reader->rate_hz : 0;
    if (later_ns > 0 && later_ns < 1e6) {
        time_ns += (int64_t)later_ns;
        reader->spread++;
    }
    if (!trk_log_clock_count(&reader->clock, time_ns, reader->reading, &sample.device_ns, out_error))
        return false;
    sample.arrival_ns = sample.device_ns;
    for (int eye = 0; eye < 2; eye++) {
        if (reader->closed >> eye & 1) trk_set_openness(&sample, eye, 0);
        if (!(reader->eyes >> eye & 1)) continue;
        if (!read_eye(reader, eye, place, &sample, out_error)) return false;
        place += 3;
    }
    return trk_log_append(reader->reading, &sample, out_error);
}

static enum trk_line read_sample(struct reader *reader, char out_error[TRK_ERROR_SIZE])
{
    struct trk_lines *lines = &reader->reading->lines;
    char *fields[TRK_MAX_FIELDS];
    int64_t time_ns;
    size_t count = trk_split(lines->text, TRK_BLANKS, fields);
    size_t eyes = (reader->eyes & LEFT_EYE ? 1 : 0) + (reader->eyes & RIGHT_EYE ? 1 : 0);
    if (eyes == 0) {
        trk_lines_fail(lines, out_error, "sample of unknown eyes, expected a line SAMPLES before it");
        return TRK_LINE_FAILED;
    }
    if (count < 1 + 3 * eyes) {
        trk_lines_fail(lines, out_error, "%zu columns, expected at least %zu", count, 1 + 3 * eyes);
        return trk_short_row(reader->reading);
    }
    if (!trk_field_time(reader->reading, fields[0], trk_time_unit(reader->reading, 1e6), &time_ns)) {
        trk_lines_fail(lines, out_error, "time is '%.20s', expected ms", fields[0]);
        return TRK_LINE_FAILED;
    }
    return take_sample(reader, time_ns, &fields[1], out_error) ? TRK_LINE : TRK_LINE_FAILED;
}

static bool is_same_screen(const struct segment *a, const struct segment *b)
{
    return memcmp(a->edges, b->edges, sizeof a->edges) == 0;
}

/* The mean resolution of all segments with the same screen as `of`; NaN if none of them has one. */
static void mean_resolution(const struct reader *reader, const struct segment *of, double out_resolution[2])
{
    double sum[2] = {0, 0};
    size_t count = 0;
    for (size_t i = 0; i < reader->segment_count; i++) {
        const struct segment *segment = &reader->segments[i];
        if (isnan(segment->resolution[0]) || !is_same_screen(segment, of)) continue;
        for (int k = 0; k < 2; k++) sum[k] += segment->resolution[k];
        count++;
    }
    for (int k = 0; k < 2; k++) out_resolution[k] = count ? sum[k] / (double)count : NAN;
}

/* Set up the plane of a segment from a resolution. `says`: add notes about the screen; the caller sets it for
 * the first segment of each screen. */
static bool init_plane(struct reader *reader, const struct segment *segment, const double resolution[2],
                       bool says, struct trk_plane *out_plane, char out_error[TRK_ERROR_SIZE])
{
    const double *edges = segment->edges;
    double width = edges[2] - edges[0] + 1, height = edges[3] - edges[1] + 1, fov_deg = TRK_SCREEN_FOV_DEG;
    double squeeze = 1;
    char what[96] = "screen";
    if (isfinite(resolution[0])) {
        fov_deg = 2 * atan(width / 2 * tan(M_PI / 180) / resolution[0]) * 180 / M_PI;
        squeeze = resolution[1] / resolution[0];
        snprintf(what, sizeof what, "by the file's %.1f px per degree the screen%s is", resolution[0],
                 segment->first ? " from there on" : "");
    }
    if (says && segment->first)
        trk_assume(reader->reading, "from sample %zu on the screen is %.0f x %.0f px", segment->first + 1,
                   width, height);
    if (!trk_plane_init(out_plane, reader->reading, (double[]){width, height}, width / height * squeeze,
                        fov_deg, says ? what : NULL, out_error))
        return false;
    out_plane->middle[0] += edges[0];
    out_plane->middle[1] += edges[1];
    return true;
}

static bool turn_segment(struct reader *reader, const struct trk_plane *plane, size_t first, size_t end,
                         char out_error[TRK_ERROR_SIZE])
{
    struct trk_log *log = reader->reading->log;
    for (size_t i = first; i < end; i++) {
        struct trk_sample sample;
        trk_log_sample(log, i, &sample);
        for (int eye = 0; eye < 2; eye++) {
            float *direction = sample.eye[eye].direction;
            if (sample.valid & TRK_LEFT_DIRECTION << 4 * eye)
                trk_plane_direction(plane, direction[0], direction[1], direction);
        }
        reader->reading->eyes_mean += trk_combine(&sample);
        trk_set_screen(&sample, plane);
        if (!trk_samples_put(log, i, &sample))
            return trk_fail(out_error, "%s: no memory", reader->reading->lines.path);
    }
    return true;
}

/* Convert all gaze from pixels to directions, now that the whole file is known. */
static bool turn_samples(struct reader *reader, char out_error[TRK_ERROR_SIZE])
{
    bool is_default = false;
    for (size_t i = 0; i < reader->segment_count; i++) {
        double *edges = reader->segments[i].edges;
        if (!isnan(edges[0])) continue;
        memcpy(edges, (double[]){0, 0, 1919, 1079}, 4 * sizeof *edges);
        is_default = true;
    }
    if (is_default && reader->reading->log->count) trk_assume(reader->reading, "screen of 1920 x 1080 px");
    double mean[2] = {NAN, NAN}; /* of the segments with the same screen */
    for (size_t i = 0; i < reader->segment_count; i++) {
        const struct segment *segment = &reader->segments[i];
        const bool is_last = i + 1 == reader->segment_count;
        struct trk_plane plane;
        bool says = i == 0 || !is_same_screen(segment, segment - 1);
        /* The note gives the mean resolution; the conversion uses the segment's own one if it has one. */
        if (says) {
            mean_resolution(reader, segment, mean);
            if (!init_plane(reader, segment, mean, true, &plane, out_error)) return false;
        }
        if (!init_plane(reader, segment, isnan(segment->resolution[0]) ? mean : segment->resolution, false,
                        &plane, out_error))
            return false;
        if (!turn_segment(reader, &plane, segment->first,
                          is_last ? reader->reading->log->count : segment[1].first, out_error))
            return false;
    }
    return true;
}

static bool read_rows(struct reader *reader, char out_error[TRK_ERROR_SIZE])
{
    struct trk_reading *reading = reader->reading;
    enum trk_line line = TRK_LINE;
    while (line == TRK_LINE) {
        bool is_sample = isdigit((unsigned char)reading->lines.text[0]);
        if (is_sample)
            line = read_sample(reader, out_error);
        else if (!read_event(reader, out_error))
            return false;
        if (line == TRK_LINE) line = trk_next_row(reading, out_error);
    }
    return line == TRK_LINE_END;
}

static bool read_eyelink(struct trk_reading *reading, char out_error[TRK_ERROR_SIZE])
{
    struct reader reader = {.reading = reading, .edges = {NAN, NAN, NAN, NAN}};
    reading->clock_names[0] = "time";
    bool ok = read_rows(&reader, out_error);
    if (ok && reader.spread)
        trk_assume(reading,
                   "samples with the same millisecond as the one before, spread evenly at %g Hz: %zu",
                   reader.rate_hz, reader.spread);
    ok = ok && turn_samples(&reader, out_error);
    free(reader.segments);
    return ok;
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
