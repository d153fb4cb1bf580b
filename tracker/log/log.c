/* Logs: the table of formats, how one is told from another, and what all readings share. */
#include "log/log.h"

#include "error.h"
#include "log/formats.h"
#include "log/own.h"
#include "log/samples.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

static const struct trk_log_format *const formats[] = {
    &trk_log_own,
    &trk_log_sranipal,
    &trk_log_salient360_static,
    &trk_log_salient360_dynamic,
    &trk_log_pupil_core,
    &trk_log_pupil_cloud,
    &trk_log_tobii_lab,
    &trk_log_glasses3,
    &trk_log_pico,
    &trk_log_eyelink,
    &trk_log_gazepoint,
    &trk_log_open_gaze,
    &trk_log_gazebase,
    &trk_log_gazebase_vr,
    &trk_log_arff,
    &trk_log_pymovements,
    &trk_log_bids,
};
enum { FORMATS = sizeof formats / sizeof *formats };

/* --- what all readings share ---------------------------------------------------------------------------- */

void trk_assume(struct trk_reading *reading, const char *format, ...)
{
    char *assumed = reading->log->assumed;
    size_t length = strlen(assumed);
    va_list arguments;
    if (length >= TRK_ASSUMED_SIZE - 3) return;
    if (length) length += (size_t)sprintf(assumed + length, "; ");
    va_start(arguments, format);
    vsnprintf(assumed + length, TRK_ASSUMED_SIZE - length, format, arguments);
    va_end(arguments);
    trk_make_printable(assumed + length); /* what a file names its columns */
}

static bool append(struct trk_reading *reading, const struct trk_sample *sample,
                   char out_error[TRK_ERROR_SIZE])
{
    struct trk_log *log = reading->log;
    if (sample->device_ns > TRK_MAX_DEVICE_NS)
        return trk_check_clocks(reading, out_error) &&
               trk_lines_fail(&reading->lines, out_error, "device time is %.0f days, expected at most %.0f",
                              (double)sample->device_ns / 86400e9, (double)TRK_MAX_DEVICE_NS / 86400e9);
    if (log->count == TRK_MAX_ROWS)
        return trk_lines_fail(&reading->lines, out_error, "is one row too many, expected at most %d",
                              TRK_MAX_ROWS);
    if (!trk_samples_add(log, sample))
        return trk_lines_fail(&reading->lines, out_error, "no memory for more than %zu samples", log->count);
    reading->last_ns = sample->device_ns;
    reading->last_arrival_ns = sample->arrival_ns;
    reading->last_sequence = sample->sequence;
    return true;
}

bool trk_log_append(struct trk_reading *reading, const struct trk_sample *sample,
                    char out_error[TRK_ERROR_SIZE])
{
    uint64_t slack = reading->disordered ? TRK_MAX_DISORDER_NS : 0;
    if (sample->device_ns + slack < reading->last_ns)
        return trk_lines_fail(&reading->lines, out_error, "device time goes back by %llu ns, expected %s",
                              (unsigned long long)(reading->last_ns - sample->device_ns),
                              slack ? "less than a second" : "it never to");
    if (sample->arrival_ns + slack < reading->last_arrival_ns)
        return trk_lines_fail(&reading->lines, out_error,
                              "arrival time goes back by %llu ns, expected it never to",
                              (unsigned long long)(reading->last_arrival_ns - sample->arrival_ns));
    if (sample->sequence <= reading->last_sequence)
        return trk_lines_fail(&reading->lines, out_error, "sequence %llu, expected more than %llu",
                              (unsigned long long)sample->sequence,
                              (unsigned long long)reading->last_sequence);
    if (sample->device_ns < reading->last_ns) reading->late++;
    return append(reading, sample, out_error);
}

/* Where a sample is, and when it was. */
struct moment {
    uint64_t device_ns;
    size_t place;
};

static int by_time(const void *a, const void *b)
{
    const struct moment *x = a, *y = b;
    if (x->device_ns != y->device_ns) return x->device_ns > y->device_ns ? 1 : -1;
    return (x->place > y->place) - (x->place < y->place);
}

/* Samples of the same time stay as they are. False when memory is short. */
static bool sort(struct trk_log *log)
{
    struct moment *moments = malloc(log->count * sizeof *moments);
    struct trk_log sorted = {0};
    bool ok = moments != NULL;
    for (size_t i = 0; i < log->count && ok; i++) moments[i] = (struct moment){trk_log_time(log, i), i};
    if (ok) qsort(moments, log->count, sizeof *moments, by_time);
    for (size_t i = 0; i < log->count && ok; i++) {
        struct trk_sample sample;
        trk_log_sample(log, moments[i].place, &sample);
        ok = trk_samples_add(&sorted, &sample);
    }
    free(moments);
    trk_samples_destroy(ok ? log->samples : sorted.samples);
    if (ok) log->samples = sorted.samples;
    return ok;
}

/* Sort a disordered log, whose times start at TRK_MAX_DISORDER_NS so that none is below 0, and count anew.
 * False when memory is short. */
static bool put_in_order(struct trk_reading *reading)
{
    struct trk_log *log = reading->log;
    if (reading->late) {
        if (!sort(log)) return false;
        trk_assume(reading, "rows out of order, sorted by time: %zu", reading->late);
    }
    const uint64_t first_ns = trk_log_time(log, 0);
    for (size_t i = 0; i < log->count; i++) {
        struct trk_sample sample;
        trk_log_sample(log, i, &sample);
        sample.device_ns -= first_ns;
        sample.arrival_ns = sample.device_ns;
        sample.sequence = i + 1;
        if (!trk_samples_put(log, i, &sample)) return false;
    }
    return true;
}

/* --- which format --------------------------------------------------------------------------------------- */

/* The format by its content; NULL with a message if it is none or may be several. */
static const struct trk_log_format *detect(struct trk_reading *reading, char out_error[TRK_ERROR_SIZE])
{
    const struct trk_log_format *found = NULL;
    char names[384] = "";
    int count = 0;
    if (!trk_check_namesakes(reading, out_error)) return NULL;
    for (int i = 0; i < FORMATS; i++) {
        const struct trk_log_format *format = formats[i];
        if (!(format->detect ? format->detect(reading) : trk_header_has(&reading->header, format->columns)))
            continue;
        size_t length = strlen(names);
        snprintf(names + length, sizeof names - length, "%s%s", count++ ? ", " : "", format->id);
        found = format;
    }
    if (count == 1) return found;
    if (count > 1) {
        trk_lines_fail(&reading->lines, out_error, "may be any of %s: expected the format to be told", names);
        return NULL;
    }
    for (int i = 1; i < FORMATS; i++) {
        size_t length = strlen(names);
        snprintf(names + length, sizeof names - length, "%s%s", i > 1 ? ", " : "", formats[i]->id);
    }
    trk_lines_fail(&reading->lines, out_error,
                   "unknown header '%.40s', expected 'fovead-gaze 1' or that of %s", reading->lines.text,
                   names);
    return NULL;
}

static const struct trk_log_format *by_name(const char *name, char out_error[TRK_ERROR_SIZE])
{
    char names[384] = "";
    for (int i = 0; i < FORMATS; i++) {
        if (strcasecmp(name, formats[i]->id) == 0) return formats[i];
        size_t length = strlen(names);
        snprintf(names + length, sizeof names - length, "%s%s", i ? ", " : "", formats[i]->id);
    }
    trk_fail(out_error, "unknown log format '%.40s', expected one of %s", name, names);
    return NULL;
}

/* --- reading -------------------------------------------------------------------------------------------- */

void trk_note_source(struct trk_log *log, int fd)
{
    struct stat status;
    if (fstat(fd, &status) != 0 || log->source_count == TRK_MAX_SOURCES) return;
    log->sources[log->source_count].device = status.st_dev;
    log->sources[log->source_count++].inode = status.st_ino;
}

bool trk_log_is_from(const struct trk_log *log, const char *path)
{
    struct stat status;
    if (stat(path, &status) != 0) return false;
    for (size_t i = 0; i < log->source_count; i++)
        if (log->sources[i].device == status.st_dev && log->sources[i].inode == status.st_ino) return true;
    return false;
}

/* A regular file, and nothing that could block or never end. */
static gzFile open_file(struct trk_log *log, const char *path, char out_error[TRK_ERROR_SIZE])
{
    int fd = open(strcmp(path, "-") == 0 ? "/dev/stdin" : path, O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
    if (fd < 0) {
        trk_fail(out_error, "%s: %s, expected a gaze log", path, strerror(errno));
        return NULL;
    }
    struct stat status;
    if (fstat(fd, &status) != 0 || !S_ISREG(status.st_mode)) {
        trk_fail(out_error, "%s: not a regular file%s, expected a gaze log", path,
                 S_ISFIFO(status.st_mode) ? " but a pipe (write it to a file first: a log is read twice)"
                                          : "");
        close(fd);
        return NULL;
    }
    gzFile file = gzdopen(fd, "rb");
    if (file) {
        gzbuffer(file, TRK_BUFFER_SIZE);
        trk_note_source(log, fd);
    } else {
        trk_fail(out_error, "%s: no memory", path);
        close(fd);
    }
    return file;
}

/* What the file begins with, and its first row. */
static bool read_head(struct trk_reading *reading, char out_error[TRK_ERROR_SIZE])
{
    struct trk_lines *lines = &reading->lines;
    int count = gzread(lines->file, reading->head, TRK_HEAD_SIZE);
    size_t size = count > 0 ? (size_t)count : 0;
    lines->number = 1;
    if (!trk_check_magic(reading, size, out_error)) return false;
    reading->head[size] = '\0';
    const char *cr = strchr(reading->head, '\r'); /* of a pair, the other half may lie beyond the head */
    lines->end = cr && cr[strspn(cr, "\r")] && !strchr(reading->head, '\n') ? '\r' : '\n';
    for (char *c = reading->head; (c = strchr(c, '\r'));) *c = '\n';
    if (strncmp(reading->head, "\xef\xbb\xbf", 3) == 0) memmove(reading->head, reading->head + 3, size - 2);
    trk_lines_rewind(lines);
    switch (trk_first_row(reading, out_error)) {
    case TRK_LINE_FAILED:
        return false;
    case TRK_LINE_END:
        return trk_fail(out_error, "%s: is empty, expected a gaze log", lines->path);
    case TRK_LINE:
        break;
    }
    trk_header_parse(&reading->header, lines->text, reading->separator);
    return true;
}

/* Of options that this format has no use for. */
static bool check_taken(const struct trk_reading *reading, char out_error[TRK_ERROR_SIZE])
{
    static const char *const names[] = {"has a fixed time unit", "has a fixed frame",
                                        "has a fixed geometry without a screen", "holds one recording"};
    const struct trk_log_options *options = reading->options;
    const bool given[] = {options->time_unit, options->frame,
                          options->screen_width_m > 0 || options->screen_fov_deg > 0, options->recording};
    for (int i = 0; i < 4; i++)
        if (given[i] && !(reading->format->takes & 1u << i))
            return trk_fail(out_error, "%s: a log of %s %s, expected none to be told", reading->lines.path,
                            reading->format->name, names[i]);
    return true;
}

static bool read_reading(struct trk_reading *reading, char out_error[TRK_ERROR_SIZE])
{
    const char *path = reading->lines.path, *name = reading->options->format;
    if (!read_head(reading, out_error)) return false;
    reading->format = name ? by_name(name, out_error) : detect(reading, out_error);
    if (!reading->format || !check_taken(reading, out_error)) return false;
    reading->log->format = reading->format->name;
    if (!reading->format->read(reading, out_error)) return false;
    if (reading->log->count == 0)
        return trk_fail(out_error, "%s: holds no samples, expected at least one row after the header", path);
    if (reading->disordered && !put_in_order(reading)) return trk_fail(out_error, "%s: no memory", path);
    if (!trk_check_clocks(reading, out_error)) return false;
    if (!trk_samples_pack(reading->log)) return trk_fail(out_error, "%s: no memory", path);
    if (reading->eyes_mean)
        trk_assume(reading, "%s",
                   reading->format->says_mean ? reading->format->says_mean : "gaze is the mean of the eyes");
    trk_say_dialect(reading);
    return true;
}

/* What the options say must be possible before any file is looked at. */
static bool check_options(const struct trk_log_options *options, char out_error[TRK_ERROR_SIZE])
{
    static const char *const units[] = {"s", "ms", "us", "ns"};
    const double width = options->screen_width_m, distance = options->screen_distance_m;
    struct trk_frame frame;
    bool known = !options->time_unit;
    for (size_t i = 0; i < sizeof units / sizeof *units && !known; i++)
        known = strcmp(options->time_unit, units[i]) == 0;
    if (!known) return trk_fail(out_error, "time unit '%.20s', expected s, ms, us or ns", options->time_unit);
    if (options->frame && !trk_frame_parse(options->frame, &frame))
        return trk_fail(
            out_error,
            "frame '%.20s', expected where +X, +Y and +Z point: three letters, one of L R, one of U D "
            "and one of F B",
            options->frame);
    if (!(options->screen_fov_deg >= 0 && options->screen_fov_deg < 180))
        return trk_fail(out_error, "field of view of %g degrees, expected more than 0 and less than 180",
                        options->screen_fov_deg);
    if (!(width >= 0 && width < 1000 && distance >= 0 && distance < 1000) || (width > 0) != (distance > 0))
        return trk_fail(out_error, "screen %g m wide and %g m away, expected both above 0", width, distance);
    if (width > 0 && options->screen_fov_deg > 0)
        return trk_fail(out_error, "a screen's size and its field of view, expected one of them");
    return true;
}

bool trk_log_read_with(const char *path, const struct trk_log_options *options, struct trk_log *out_log,
                       char out_error[TRK_ERROR_SIZE])
{
    *out_log = (struct trk_log){0};
    if (!check_options(options, out_error)) return false;
    struct trk_reading *reading = calloc(1, sizeof *reading);
    if (!reading) return trk_fail(out_error, "%s: no memory", path);
    reading->lines.path = path;
    reading->options = options;
    reading->log = out_log;
    reading->lines.file = open_file(out_log, path, out_error);
    bool ok = reading->lines.file && read_reading(reading, out_error);
    if (reading->lines.file) gzclose(reading->lines.file);
    free(reading);
    if (!ok) trk_log_finish(out_log);
    return ok;
}

bool trk_log_read(const char *path, struct trk_log *out_log, char out_error[TRK_ERROR_SIZE])
{
    return trk_log_read_with(path, &(const struct trk_log_options){0}, out_log, out_error);
}

void trk_log_finish(struct trk_log *log)
{
    trk_samples_destroy(log->samples);
    *log = (struct trk_log){0};
}
