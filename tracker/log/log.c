/* Reading a log: recognising its format, checking the options, and the checks after the last row. */
#include "error.h"
#include "log/foreign.h"
#include "log/formats.h"
#include "log/samples.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

/* clang-format off */
static const struct trk_log_format *const formats[] = {
#define ROW(format) &format,
    TRK_LOG_FORMATS(ROW)
#undef ROW
};
/* clang-format on */
enum { FORMATS = sizeof formats / sizeof *formats };

/* --- recognising the format --- */

/* Recognise the format by its content. NULL with a message if no format matches, or several do. */
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
        trk_lines_fail(&reading->lines, out_error,
                       "may be any of %s: expected an option that names the format", names);
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

/* --- reading --- */

bool trk_log_is_from(const struct trk_log *log, const char *path)
{
    struct stat status;
    if (stat(path, &status) != 0) return false;
    for (size_t i = 0; i < log->source_count; i++)
        if (log->sources[i].device == status.st_dev && log->sources[i].inode == status.st_ino) return true;
    return false;
}

/* Open a log. Only regular files are accepted, because reading others could block or never end. */
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

/* Read the first bytes of the file, and its first row. */
static bool read_head(struct trk_reading *reading, char out_error[TRK_ERROR_SIZE])
{
    struct trk_lines *lines = &reading->lines;
    int count = gzread(lines->file, reading->head, TRK_HEAD_SIZE);
    size_t size = count > 0 ? (size_t)count : 0;
    lines->number = 1;
    if (!trk_check_magic(reading, size, out_error)) return false;
    reading->head[size] = '\0';
    const char *cr = strchr(reading->head, '\r'); /* may be the last byte of the head, before its LF */
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

/* Refuse options that do not apply to this format. */
static bool check_taken(const struct trk_reading *reading, char out_error[TRK_ERROR_SIZE])
{
    static const char *const names[] = {"has a fixed time unit", "has a fixed frame",
                                        "has a fixed geometry without a screen", "holds one recording"};
    const struct trk_log_options *options = reading->options;
    const bool given[] = {options->time_unit, options->frame,
                          options->screen_width_m > 0 || options->screen_fov_deg > 0, options->recording};
    for (int i = 0; i < 4; i++)
        if (given[i] && !(reading->format->takes & 1u << i))
            return trk_fail(out_error, "%s: a log of %s %s, expected no option for it", reading->lines.path,
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
    if (reading->disordered && !trk_rows_sort(reading)) return trk_fail(out_error, "%s: no memory", path);
    if (!trk_check_clocks(reading, out_error)) return false;
    if (!trk_samples_pack(reading->log)) return trk_fail(out_error, "%s: no memory", path);
    if (reading->eyes_mean)
        trk_assume(reading, "%s",
                   reading->format->says_mean ? reading->format->says_mean : "gaze is the mean of the eyes");
    trk_say_dialect(reading);
    return true;
}

/* Refuse options that are impossible for every file. */
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
