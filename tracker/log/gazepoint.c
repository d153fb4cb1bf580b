/* Logs of Gazepoint trackers: the CSV export, and records of the Open Gaze API as the socket delivers them.
 *
 *   MEDIA_ID,MEDIA_NAME,CNT,TIME(<when it began>),TIMETICK(f=10000000),FPOGX,...,BPOGX,BPOGY,BPOGV,...
 *   <REC CNT="34" TIME="0.5" TIME_TICK="463" BPOGX="0.5" BPOGY="0.5" BPOGV="1" ... />
 *
 * Points of gaze are fractions of the screen from its top left corner, x to the right and y down, and may be
 * outside 0..1. The API's manual says so; we had no recording to confirm it, and the rows of the tests are
 * invented. BPOG is the gaze of both eyes; LPOG and RPOG are those of each eye. V says whether the point is
 * valid: a lost sample repeats the last point with V 0. FPOG stays at the fixation during saccades, so it is
 * used only if there is no BPOG. LPMM and RPMM are the pupils in mm. BKID is not 0 during a blink. TIME, in
 * seconds, is the tracker's clock. TIME_TICK is the host's clock, with f ticks per second. In an export of
 * several media, TIME restarts with each medium but the ticks go on, so they tell how much time has passed
 * since the last sample. CNT counts samples: a gap in CNT means lost samples. */
#include "log/formats.h"

#include "error.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* clang-format off */
enum { CNT, TIME, TICK, BPOG, LPOG = BPOG + 3, RPOG = LPOG + 3, FPOG = RPOG + 3, LPMM = FPOG + 3, RPMM = LPMM + 2,
       BKID = RPMM + 2, FPOGID, VALUES };
static const char *const names[VALUES] = {
    "CNT", "TIME", "TIME_TICK",
    "BPOGX", "BPOGY", "BPOGV", "LPOGX", "LPOGY", "LPOGV", "RPOGX", "RPOGY", "RPOGV", "FPOGX", "FPOGY", "FPOGV",
    "LPMM", "LPMMV", "RPMM", "RPMMV", "BKID", "FPOGID",
};
/* clang-format on */

#define DEFAULT_TICK_HZ 1e7

struct reader {
    struct trk_reading *reading;
    struct trk_plane plane;
    struct trk_log_clock device, host;
    char *fields[VALUES]; /* of one record; NULL: value absent */
    double tick_hz;
    bool has_count, is_fixation; /* is_fixation: gaze is FPOG, for lack of BPOG */
    int64_t first_count;
    uint64_t sequence;
    bool has_last;
    int64_t last_time_ns, last_tick_ns, shift_ns; /* shift_ns: added to TIME after it restarted */
    size_t restarts;
    size_t fixations; /* changes of FPOGID from one record to the next */
    double fixation;  /* FPOGID of the last record; NaN: none */
};

static bool number(struct reader *reader, int i, double *out_value, char out_error[TRK_ERROR_SIZE])
{
    *out_value = NAN;
    char *field = reader->fields[i];
    if (!field || trk_field_number(reader->reading, field, out_value)) return true;
    return trk_lines_fail(&reader->reading->lines, out_error, "%s is '%.40s', expected a finite number",
                          names[i], field);
}

/* If TIME has restarted, correct it: the ticks tell how much time has passed. Both times count from a
 * start, and are far below the limit of an int64_t. */
static void join(struct reader *reader, int64_t *time_ns, int64_t tick_ns)
{
    const int64_t max_ns = (int64_t)TRK_MAX_DEVICE_NS, now_ns = *time_ns, last_ns = reader->last_time_ns;
    const int64_t step_ns = reader->has_last ? tick_ns - reader->last_tick_ns : -1;
    if (step_ns >= 0 && step_ns <= max_ns && now_ns >= 0 && last_ns <= max_ns &&
        last_ns - now_ns > (int64_t)TRK_MAX_STEP_BACK_NS) {
        reader->shift_ns += last_ns - now_ns + step_ns;
        reader->restarts++;
    }
    reader->has_last = true;
    reader->last_time_ns = now_ns;
    reader->last_tick_ns = tick_ns;
    *time_ns += reader->shift_ns;
}

static bool read_times(struct reader *reader, struct trk_sample *sample, char out_error[TRK_ERROR_SIZE])
{
    const struct trk_lines *lines = &reader->reading->lines;
    char *time = reader->fields[TIME], *tick = reader->fields[TICK];
    int64_t time_ns, tick_ns;
    if (!time || !trk_field_time(reader->reading, time, trk_time_unit(reader->reading, 1e9), &time_ns))
        return trk_lines_fail(lines, out_error, "TIME is '%.40s', expected seconds", time ? time : "");
    if (tick && !trk_field_time(reader->reading, tick, 1e9 / reader->tick_hz, &tick_ns))
        return trk_lines_fail(lines, out_error, "TIME_TICK is '%.40s', expected ticks", tick);
    if (tick) join(reader, &time_ns, tick_ns);
    if (!trk_log_clock_count(&reader->device, time_ns, reader->reading, &sample->device_ns, out_error))
        return false;
    sample->arrival_ns = sample->device_ns;
    return !tick ||
           trk_log_clock_count(&reader->host, tick_ns, reader->reading, &sample->arrival_ns, out_error);
}

/* CNT may restart too; then the sequence continues from its last number. */
static void count(struct reader *reader, struct trk_sample *sample)
{
    const char *field = reader->fields[CNT];
    int64_t counted;
    sample->sequence = reader->sequence + 1;
    if (field && trk_parse_int64(field, &counted) && llabs(counted) < INT64_MAX / 4) {
        if (!reader->has_count || counted - reader->first_count < (int64_t)reader->sequence)
            reader->first_count = counted - (int64_t)reader->sequence;
        reader->has_count = true;
        sample->sequence = (uint64_t)(counted - reader->first_count) + 1;
    }
    reader->sequence = sample->sequence;
}

/* Read a point of gaze; *out_valid: the point is present and marked as valid. */
static bool point(struct reader *reader, int i, float out_direction[3], bool *out_valid,
                  char out_error[TRK_ERROR_SIZE])
{
    double x, y, valid;
    if (!number(reader, i, &x, out_error) || !number(reader, i + 1, &y, out_error) ||
        !number(reader, i + 2, &valid, out_error))
        return false;
    *out_valid = valid == 1 && isfinite(x) && isfinite(y);
    if (*out_valid) trk_plane_direction(&reader->plane, x, y, out_direction);
    return true;
}

static bool read_record(struct reader *reader, char out_error[TRK_ERROR_SIZE])
{
    struct trk_sample sample = {0};
    bool valid;
    double blink, fixation;
    int both = reader->fields[BPOG] ? BPOG : FPOG;
    reader->is_fixation |= both == FPOG;
    if (!number(reader, FPOGID, &fixation, out_error)) return false;
    reader->fixations += fixation != reader->fixation && !isnan(fixation) && !isnan(reader->fixation);
    reader->fixation = fixation;
    if (!read_times(reader, &sample, out_error) || !number(reader, BKID, &blink, out_error) ||
        !point(reader, both, sample.direction, &valid, out_error))
        return false;
    count(reader, &sample);
    if (valid) sample.valid |= TRK_DIRECTION;
    for (int eye = 0; eye < 2; eye++) {
        double pupil, pupil_valid;
        if (!point(reader, LPOG + 3 * eye, sample.eye[eye].direction, &valid, out_error) ||
            !number(reader, LPMM + 2 * eye, &pupil, out_error) ||
            !number(reader, LPMM + 2 * eye + 1, &pupil_valid, out_error))
            return false;
        if (valid) sample.valid |= TRK_LEFT_DIRECTION << 4 * eye;
        if (pupil_valid == 1) trk_set_pupil(&sample, eye, pupil);
        if (isfinite(blink) && blink != 0) trk_set_openness(&sample, eye, 0);
    }
    trk_set_screen(&sample, &reader->plane);
    return trk_log_append(reader->reading, &sample, out_error);
}

static bool begin(struct reader *reader, char out_error[TRK_ERROR_SIZE])
{
    reader->tick_hz = DEFAULT_TICK_HZ;
    reader->fixation = NAN;
    reader->reading->clock_names[0] = names[TIME];
    return trk_plane_init(&reader->plane, reader->reading, (double[]){1, 1}, 16.0 / 9, TRK_SCREEN_FOV_DEG,
                          "screen of 16:9", out_error);
}

static bool finish(struct reader *reader, char out_error[TRK_ERROR_SIZE])
{
    const size_t count = reader->reading->log->count;
    /* In a log of gaze, many samples in a row share a fixation's number. */
    if (count > 2 && reader->fixations == count - 1)
        return trk_fail(
            out_error,
            "%s: holds fixations (one a row: FPOGID is another in every row), expected the export of "
            "all gaze, ..._all_gaze.csv",
            reader->reading->lines.path);
    if (reader->is_fixation) trk_assume(reader->reading, "no BPOG: gaze is taken from fixations (FPOG)");
    if (reader->restarts)
        trk_assume(reader->reading, "restarts of TIME, joined by the ticks: %zu", reader->restarts);
    return true;
}

/* --- the export --- */

/* The names of the columns TIME and TIMETICK hold more: when the recording began, and the frequency of the
 * ticks. */
static bool find_times(struct reader *reader, int place[VALUES], char out_error[TRK_ERROR_SIZE])
{
    struct trk_reading *reading = reader->reading;
    for (size_t i = 0; i < reading->header.count; i++) {
        const char *name = reading->header.names[i];
        bool is_tick = strncasecmp(name, "TIMETICK", 8) == 0 || strncasecmp(name, "TIME_TICK", 9) == 0;
        if (is_tick && place[TICK] < 0) {
            const char *frequency = strstr(name, "f=");
            double hz = frequency ? strtod(frequency + 2, NULL) : 0;
            place[TICK] = (int)i;
            if (hz >= 1 && hz <= 1e10) reader->tick_hz = hz;
        } else if (!is_tick && strncasecmp(name, "TIME", 4) == 0 && place[TIME] < 0) {
            place[TIME] = (int)i;
        }
    }
    return place[TIME] >= 0 ||
           trk_lines_fail(&reading->lines, out_error, "header lacks a column, expected 'TIME'");
}

static bool read_export(struct trk_reading *reading, char out_error[TRK_ERROR_SIZE])
{
    struct reader reader = {.reading = reading};
    struct trk_table table;
    int place[VALUES];
    trk_table_init(&table, reading);
    if (reading->header.count > TRK_MAX_FIELDS && !trk_table_need(&table, names, 1, place, out_error))
        return false;
    if (!begin(&reader, out_error)) return false;
    for (int i = 0; i < VALUES; i++) place[i] = i == TIME ? -1 : trk_header_find(&reading->header, names[i]);
    if (!find_times(&reader, place, out_error)) return false;
    if (place[TICK] >= 0) reading->clock_names[1] = names[TICK];
    for (;;) {
        enum trk_line line = trk_table_next(&table, out_error);
        if (line == TRK_LINE_END) return finish(&reader, out_error);
        if (line == TRK_LINE_FAILED) return false;
        for (int i = 0; i < VALUES; i++) reader.fields[i] = place[i] < 0 ? NULL : table.fields[place[i]];
        if (!read_record(&reader, out_error)) return false;
    }
}

const struct trk_log_format trk_log_gazepoint = {
    .id = "gazepoint",
    .name = "Gazepoint",
    .takes = TRK_TAKES_TIME_UNIT | TRK_TAKES_FRAME | TRK_TAKES_SCREEN | TRK_TAKES_RECORDING,
    .columns = {"CNT", "FPOGX", "FPOGY", "FPOGV"},
    .read = read_export,
};

/* --- the API's records --- */

/* Cut the next NAME="VALUE" out of an element, in place. NULL at the end of the element. */
static char *next_attribute(char **at, char **out_value)
{
    char *name = *at + strspn(*at, " \t"), *equals = strchr(name, '=');
    if (!equals || equals[1] != '"') return NULL;
    char *end = strchr(equals + 2, '"');
    if (!end) return NULL;
    *equals = *end = '\0';
    *out_value = equals + 2;
    *at = end + 1;
    return name;
}

/* <ACK ID="TIME_TICK_FREQUENCY" FREQ="10000000" /> gives the frequency of the ticks. */
static void read_answer(struct reader *reader, char *at)
{
    bool is_frequency = false;
    char *name, *value;
    while ((name = next_attribute(&at, &value))) {
        double hz;
        is_frequency |= strcmp(name, "ID") == 0 && strcmp(value, "TIME_TICK_FREQUENCY") == 0;
        if (is_frequency && strcmp(name, "FREQ") == 0 && trk_parse_double(value, &hz) && hz >= 1 &&
            hz <= 1e10)
            reader->tick_hz = hz;
    }
}

/* Take the values of a record; those that it lacks become NULL. False if the element does not end with "/>".
 */
static bool take_attributes(struct reader *reader, char *at)
{
    char *name, *value;
    memset(reader->fields, 0, sizeof reader->fields);
    while ((name = next_attribute(&at, &value)))
        for (int i = 0; i < VALUES; i++)
            if (strcmp(name, names[i]) == 0) reader->fields[i] = value;
    at += strspn(at, " \t");
    return strncmp(at, "/>", 2) == 0;
}

static bool read_open_gaze(struct trk_reading *reading, char out_error[TRK_ERROR_SIZE])
{
    struct reader reader = {.reading = reading};
    enum trk_line line = TRK_LINE;
    if (!begin(&reader, out_error)) return false;
    for (; line == TRK_LINE; line = trk_next_row(reading, out_error)) {
        char *at = reading->lines.text + strspn(reading->lines.text, " \t");
        if (strncmp(at, "<ACK", 4) == 0) read_answer(&reader, at + 4);
        if (strncmp(at, "<REC", 4) != 0) continue;
        bool is_empty = at[4 + strspn(at + 4, " \t")] == '/';
        if (!take_attributes(&reader, at + 4)) {
            trk_lines_fail(&reading->lines, out_error, "'%.40s', expected NAME=\"VALUE\" or />", at);
            line = trk_short_row(reading);
            break;
        }
        if (is_empty) continue; /* the client had not asked for any value yet */
        if (reader.fields[TICK]) reading->clock_names[1] = names[TICK];
        if (!read_record(&reader, out_error)) return false;
    }
    return line == TRK_LINE_END && finish(&reader, out_error);
}

static bool detect_open_gaze(const struct trk_reading *reading)
{
    const char *text = reading->lines.text + strspn(reading->lines.text, " \t");
    if (*text != '<') return false;
    for (const char *at = reading->head; (at = strstr(at, "<REC")); at++)
        if (strchr(" \t/", at[4])) return true;
    return false;
}

const struct trk_log_format trk_log_open_gaze = {
    .id = "open-gaze",
    .name = "Open Gaze API",
    .takes = TRK_TAKES_TIME_UNIT | TRK_TAKES_FRAME | TRK_TAKES_SCREEN,
    .detect = detect_open_gaze,
    .closes = "/>",
    .read = read_open_gaze,
};
