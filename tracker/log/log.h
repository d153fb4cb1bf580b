/* What every log format is made with: lines of a file, the columns of a table, numbers, times, frames,
 * screens, rows, and messages that name file and line.
 *
 * Only tracker/log/ includes this. A format is one file with a `const struct trk_log_format` (declared in
 * formats.h), and one line in the table in log.c. Formats are told by what a file begins with and never by
 * its name.
 */
#ifndef FOVEAD_TRACKER_LOG_H
#define FOVEAD_TRACKER_LOG_H

#include "events.h"
#include "tracker.h"

#include <stdio.h>
#include <zlib.h>

enum {
    TRK_LINE_SIZE = 1 << 20,         /* bytes of a line with its end: Tobii names a column for every area */
    TRK_HEAD_SIZE = 16384,           /* bytes of a file that tell its format */
    TRK_MAX_FIELDS = 1 << 14,        /* columns of a line */
    TRK_MAX_ROWS = 64 * 1024 * 1024, /* 6 days at 120 Hz */
};

/* The longest span of device time, 104 days in ns: beyond 2^53 a double no longer counts nanoseconds, and a
 * speed factor could not be applied exactly. */
#define TRK_MAX_DEVICE_NS (UINT64_C(1) << 53)

/* The most bytes that a compressed log may unpack to: gzip folds a thousand to one, and nobody waits for
 * that. */
#define TRK_MAX_UNPACKED (UINT64_C(2) << 30)

/* How far a recorded unit vector or quaternion may be from length 1: a decimal log of three digits passes, a
 * vector in other units does not. */
#define TRK_UNIT_TOLERANCE 1e-3

/* --- lines ---------------------------------------------------------------------------------------------- */

enum { TRK_BUFFER_SIZE = 65536 };

/* A file, line by line; gzip is unpacked on the way. */
struct trk_lines {
    const char *path; /* borrowed */
    gzFile file;
    uint64_t bytes;           /* unpacked so far */
    size_t number;            /* of the line in text, from 1 */
    char end;                 /* of lines: LF, or CR in a file that has no LF */
    bool has_end;             /* the line was ended, not cut off by the end of the file */
    bool is_gzip_cut;         /* the gzip data ended too soon: so did the lines */
    bool ends_in_zeros;       /* the last line was followed by zero bytes alone, up to the end of the file */
    size_t taken, filled;     /* of buffer, bytes */
    char text[TRK_LINE_SIZE]; /* without its end (LF, CR, CR LF, CR CR LF) and mark of UTF-8; holds no NUL
                                 byte but the last */
    char buffer[TRK_BUFFER_SIZE];
};

enum trk_line { TRK_LINE, TRK_LINE_END, TRK_LINE_FAILED };

/* Take the next line into lines->text. TRK_LINE_FAILED, with the reason in out_error: a read error, a line
 * that is too long, a NUL byte that is not of the file's end (it is no text), damaged or oversized gzip. */
enum trk_line trk_lines_next(struct trk_lines *lines, char out_error[TRK_ERROR_SIZE]);

/* Go back to before the first line. */
void trk_lines_rewind(struct trk_lines *lines);

/* Write "PATH:LINE: <message>" for the line that was read last; returns false. */
bool trk_lines_fail(const struct trk_lines *lines, char out_error[TRK_ERROR_SIZE], const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* --- numbers -------------------------------------------------------------------------------------------- */

/* Whole-field numbers: false if the field is empty, has anything before or after the number, or is out of
 * range. Decimal point only: no program of the project calls setlocale(), so strtof() and strtoll() read in
 * the C locale. A float may be read as infinite or NaN: the caller judges. */
bool trk_parse_float(const char *field, float *out_value);
bool trk_parse_double(const char *field, double *out_value);
bool trk_parse_int64(const char *field, int64_t *out_value);

/* A time in ticks of unit_ns, with or without a fraction, to whole nanoseconds. False if it is no finite
 * number or does not fit. Exact for the nanoseconds of today where long double has 64 bits of mantissa. */
bool trk_parse_time(const char *field, double unit_ns, int64_t *out_ns);

/* True if v, of n numbers, has a length within TRK_UNIT_TOLERANCE of 1 (NaN never has). */
bool trk_is_unit(const float *v, int n);

/* --- the reading of one log ----------------------------------------------------------------------------- */

/* The names of a table's columns, from its first line. */
struct trk_header {
    char line[TRK_LINE_SIZE]; /* cut into names */
    char *names[TRK_MAX_FIELDS];
    size_t count;   /* of columns; more than TRK_MAX_FIELDS is no table */
    char separator; /* tab, ';', ',' or TRK_BLANKS */
};

/* Whose rows they are, where a table holds several recordings: participant and recording. */
enum { TRK_MAX_RECORDINGS = 1024, TRK_RECORDING_SIZE = 128 };
struct trk_recording {
    char participant[TRK_RECORDING_SIZE], name[TRK_RECORDING_SIZE]; /* "" where there is no column */
};

struct trk_reading {
    struct trk_lines lines;
    const struct trk_log_options *options;
    char head[TRK_HEAD_SIZE + 1]; /* what the file begins with, CRs as LFs, no BOM */
    struct trk_header header;     /* its first line */
    char separator;               /* that a line sep=; before the header names; 0: none does */
    const struct trk_log_format *format;
    struct trk_log *log;
    uint64_t last_ns, last_arrival_ns, last_sequence; /* of the sample that was appended last; 0: none was */
    /* Set by a format whose rows may come out of order by up to TRK_MAX_DISORDER_NS; they are sorted in the
     * end. */
    bool disordered;
    size_t late; /* rows that came after a later one */
    /* What the file calls the clocks of device_ns and of arrival_ns; NULL: arrival_ns is that of the first.
     */
    const char *clock_names[2];
    /* What was met on the way and is said in the end. */
    bool has_decimal_commas;
    size_t rows;      /* taken, however often */
    size_t cut_line;  /* the number of a line that was cut off; 0: none was */
    size_t held;      /* times that went back a little: see trk_log_clock */
    size_t eyes_mean; /* samples whose gaze is the mean of two eyes */
    /* Times with an exponent, as spreadsheets write them (1.70000E+18): the first, what its last digit is
     * worth (ns), and whether there are others without. */
    char exponent_time[32];
    double exponent_step_ns;
    bool has_plain_times;
    struct trk_recording recordings[TRK_MAX_RECORDINGS]; /* that were met */
    size_t recordings_wanted; /* of them, those that the option may mean; without one, all */
    size_t recording_count;
    bool has_more_recordings; /* than there is room for */
    char scratch[TRK_LINE_SIZE];
};

#define TRK_MAX_DISORDER_NS UINT64_C(1000000000)

/* Options that a format can make use of; one that it cannot is refused. */
enum { TRK_TAKES_TIME_UNIT = 1, TRK_TAKES_FRAME = 2, TRK_TAKES_SCREEN = 4, TRK_TAKES_RECORDING = 8 };

struct trk_log_format {
    const char *id;   /* what trk_log_options.format calls it */
    const char *name; /* goes to trk_log.format */
    unsigned takes;   /* TRK_TAKES_* */
    /* Told by columns that its header has, up to six; or, where that does not do, by a function. */
    const char *columns[7];
    bool (*detect)(const struct trk_reading *reading);
    /* What a row ends with that is surely whole, even if it is the file's last one and has no line end; NULL:
     * no row is. */
    const char *closes;
    /* What is said where gaze is the mean of the eyes; NULL: just that. */
    const char *says_mean;
    /* Read the whole file; lines.text holds the first line. On failure the caller frees what the log has. */
    bool (*read)(struct trk_reading *reading, char out_error[TRK_ERROR_SIZE]);
};

/* Append a sample. Checks what every format must hold: sequence and the times never go back, the device clock
 * stays within TRK_MAX_DEVICE_NS, rows within TRK_MAX_ROWS. */
bool trk_log_append(struct trk_reading *reading, const struct trk_sample *sample,
                    char out_error[TRK_ERROR_SIZE]);

/* Note what was taken for granted, for trk_log.assumed. */
void trk_assume(struct trk_reading *reading, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* --- dialects ------------------------------------------------------------------------------------------- */

/* What every format lets a file vary in, as programs and spreadsheets write them: ends of lines, empty lines,
 * quotes, separators, decimal commas, words for what is missing, an end that was cut off. */

/* A separator that is any run of spaces and tabs; those at the ends of a line separate nothing. */
enum { TRK_BLANKS = 1 };

/* Cut text in place at every separator; fields that are adjacent to nothing are empty. Returns their number,
 * and fills the first TRK_MAX_FIELDS of out_fields, which point into text. At commas, semicolons, tabs and
 * bars, blanks around a field go, and so do quotes, inside of which a separator is none and "" is a quote. */
size_t trk_split(char *text, char separator, char *out_fields[TRK_MAX_FIELDS]);

/* The separator that a line of names has most of, outside of quotes; TRK_BLANKS if it has none. */
char trk_separator_of(const char *line);

/* Take the first line that is not empty, past one that names the separator (sep=;). */
enum trk_line trk_first_row(struct trk_reading *reading, char out_error[TRK_ERROR_SIZE]);

/* Take the next line that is not empty. TRK_LINE_END too if the file ends without ending that line, unless
 * the line ends with what closes a row of its format: the line was cut off, is left out, and is noted. */
enum trk_line trk_next_row(struct trk_reading *reading, char out_error[TRK_ERROR_SIZE]);

/* What becomes of a row that is too short: TRK_LINE_END, noted, if it is the last of several, so that the
 * file was cut off; else TRK_LINE_FAILED. */
enum trk_line trk_short_row(struct trk_reading *reading);

/* A field that says that there is no value: empty, NaN, -nan(ind), n/a, #N/A, ?, `.` and others. */
bool trk_is_missing(const char *field);

/* A number, with a decimal point or comma; NaN where it is missing. False if it is anything else or infinite.
 * A comma is changed in place. */
bool trk_field_number(struct trk_reading *reading, char *field, double *out_value);

/* The same for a time, which must not be missing: see trk_parse_time(). */
bool trk_field_time(struct trk_reading *reading, char *field, double unit_ns, int64_t *out_ns);

/* Say what was met on the way: to be called when all rows are read. */
void trk_say_dialect(struct trk_reading *reading);

/* --- tables --------------------------------------------------------------------------------------------- */

/* A table that is being read: rows under the reading's header. */
struct trk_table {
    struct trk_reading *reading;
    char separator;               /* of the rows; 0 until the first one tells it */
    bool may_be_short;            /* fields at a row's end may be left off: they are empty */
    char comment;                 /* that a line begins with which is no row; 0: none */
    int participant, recording;   /* columns that tell recordings apart; -1: none */
    char *fields[TRK_MAX_FIELDS]; /* of the row that was taken last */
    /* Called when a row has been cut into so many fields; returns how many it makes of them. NULL: as many.
     */
    size_t (*mend)(void *reader, struct trk_table *table, size_t count);
    void *reader;
};

/* separator 0: the one that trk_separator_of() finds. */
void trk_header_parse(struct trk_header *header, const char *line, char separator);

/* The column of that name; names are compared by their letters and digits alone, without regard to case and
 * to what stands in square brackets. -1: there is none. The first of several. */
int trk_header_find(const struct trk_header *header, const char *name);

/* Has it all of these columns? The list ends with NULL; an empty one is no header's. */
bool trk_header_has(const struct trk_header *header, const char *const columns[]);

/* The one that has unit in its square brackets too, or has no brackets. */
int trk_header_find_unit(const struct trk_header *header, const char *name, const char *unit);

/* Under the reading's header. */
void trk_table_init(struct trk_table *table, struct trk_reading *reading);

/* Find n columns; false with a message if one is missing. */
bool trk_table_need(struct trk_table *table, const char *const names[], int n, int out_columns[],
                    char out_error[TRK_ERROR_SIZE]);

/* Take the next row that is not empty and belongs to the recording that is asked for. TRK_LINE_FAILED too if
 * its number of fields is not the header's (empty ones after the last are let pass), or if it is of another
 * recording than the rows before and none was asked for. */
enum trk_line trk_table_next(struct trk_table *table, char out_error[TRK_ERROR_SIZE]);

/* The same with the line that was taken already. */
enum trk_line trk_table_first(struct trk_table *table, char out_error[TRK_ERROR_SIZE]);

/* Read all rows: read_row makes a sample of the row in hand, or leaves its sequence 0 if the row is none; it
 * gets reader. False with a message when a row is refused. */
bool trk_table_read(struct trk_table *table,
                    bool (*read_row)(void *reader, struct trk_sample *out_sample,
                                     char out_error[TRK_ERROR_SIZE]),
                    void *reader, char out_error[TRK_ERROR_SIZE]);

/* A number of the row; NaN where it is missing, or column is -1. False with a message if it is anything else
 * or infinite. */
bool trk_table_number(struct trk_table *table, int column, double *out_value, char out_error[TRK_ERROR_SIZE]);

/* n numbers in the columns given, as floats. */
bool trk_table_numbers(struct trk_table *table, const int *columns, int n, float *out_values,
                       char out_error[TRK_ERROR_SIZE]);

/* A whole number; false with a message if it is missing or anything else. */
bool trk_table_integer(struct trk_table *table, int column, int64_t *out_value,
                       char out_error[TRK_ERROR_SIZE]);

bool trk_table_time(struct trk_table *table, int column, double unit_ns, int64_t *out_ns,
                    char out_error[TRK_ERROR_SIZE]);

/* The ns of a tick in a column of times of unknown unit, told from the middle step of the first rows, or else
 * from their mean step: gaze is recorded at 20 to 2500 Hz, and of s, ms, us and ns only one puts it there.
 * Leaves the reading at the first row. 0 with a message when none does. An option that names the unit is
 * followed instead. */
double trk_table_guess_unit(struct trk_table *table, int column, char out_error[TRK_ERROR_SIZE]);

/* Whose the row in hand is. SEVERAL: the option fits more than one recording, or no option was given and
 * earlier rows are of another recording. */
enum trk_recording_row { TRK_RECORDING_WANTED, TRK_RECORDING_OTHER, TRK_RECORDING_SEVERAL };
enum trk_recording_row trk_recording_of_row(struct trk_table *table);

/* At the end of the rows: is there one recording that was asked for? False with a message that names those
 * that there are. */
bool trk_recording_is_met(const struct trk_table *table, char out_error[TRK_ERROR_SIZE]);

/* --- time, frames, screens ------------------------------------------------------------------------------ */

/* The ns of a tick: what the options say, else own_ns. */
double trk_time_unit(const struct trk_reading *reading, double own_ns);

/* How far a time may go back and still count as the one before it: trackers and hosts stamp in a hurry. */
#define TRK_MAX_STEP_BACK_NS UINT64_C(100000000)

/* A clock that counts from its first time and never goes back: what is a little earlier than the last time
 * counts as that one, and is counted in reading->held. Further back is refused. */
struct trk_log_clock {
    bool started;
    int64_t first_ns;
    uint64_t last_ns;
};
bool trk_log_clock_count(struct trk_log_clock *clock, int64_t time_ns, struct trk_reading *reading,
                         uint64_t *out_ns, char out_error[TRK_ERROR_SIZE]);

/* Check that the times of the samples so far are those of a clock: not all the same, not the same for most
 * rows and then far apart, not rounded by a spreadsheet. Where they are not, the log's other clock is taken,
 * which is noted; false with a message if that is none either. */
bool trk_check_clocks(struct trk_reading *reading, char out_error[TRK_ERROR_SIZE]);

/* How a file's vectors turn into ours (+X right, +Y up, -Z forward): three letters say where its +X, +Y and
 * +Z point, of L left or R right, U up or D down, F forward or B back. */
struct trk_frame {
    int axis[3]; /* of the file's vector, for each of ours */
    float sign[3];
};
bool trk_frame_parse(const char *letters, struct trk_frame *out_frame);

/* The frame that the options say, else the format's own, which must be right. */
struct trk_frame trk_reading_frame(const struct trk_reading *reading, const char *own);
void trk_frame_turn(const struct trk_frame *frame, const float v[3], float out[3]);

/* Signs of x to the right and y upwards for formats with two numbers and no vectors; false with a message if
 * the options name a frame in which they are not across and upright. */
bool trk_reading_signs(struct trk_reading *reading, const char *own, double out_signs[2],
                       char out_error[TRK_ERROR_SIZE]);

/* A flat screen, or a camera's picture, straight ahead: direction = ((x - middle) / focal, ..., -1). */
struct trk_plane {
    double middle[2], focal[2]; /* both in the unit of x and y */
    double sign[2];             /* 1 where x grows to the right, y upwards */
};

/* Its geometry from the options, else the default of own_fov_deg across, which is noted (not if what is
 * NULL). width and height in the unit of x and y; aspect is the true width by height. */
bool trk_plane_init(struct trk_plane *plane, struct trk_reading *reading, double width, double height,
                    double aspect, double own_fov_deg, const char *what, char out_error[TRK_ERROR_SIZE]);
void trk_plane_direction(const struct trk_plane *plane, double x, double y, float out_direction[3]);

/* 0.52 m of screen at 0.65 m, for logs that do not know theirs. */
#define TRK_SCREEN_FOV_DEG 43.6028

/* A direction from yaw to the right and pitch upwards, degrees. */
void trk_angles_direction(double yaw_deg, double pitch_deg, float out_direction[3]);

/* --- samples -------------------------------------------------------------------------------------------- */

/* An eye's direction (eye 0 left, 1 right, 2 both together), turned from the file's frame and made unit. Not
 * finite or shorter than 1e-6: lost, nothing is set. */
void trk_set_direction(struct trk_sample *sample, int eye, const float direction[3],
                       const struct trk_frame *frame);

/* An eye's origin, the same way, scaled to metres; lost if not finite. */
void trk_set_origin(struct trk_sample *sample, int eye, const float origin[3], float metres,
                    const struct trk_frame *frame);

/* Pupil in mm (not finite or not above 0: unknown) and openness 0..1 (not finite: unknown) of eye 0 or 1. */
void trk_set_pupil(struct trk_sample *sample, int eye, double mm);
void trk_set_openness(struct trk_sample *sample, int eye, double openness);

/* Unity's frame is left-handed, +X right, +Y up, +Z forward, in metres; mirroring Z takes it to ours. Its
 * Euler angles are degrees, applied about Z, then X, then Y. Numbers that are not finite leave the pose
 * unset. */
void trk_set_unity_head(struct trk_sample *sample, const float position[3], const float rotation[4]);
void trk_unity_euler(const float angles_deg[3], float out_rotation[4]);

/* --- files ---------------------------------------------------------------------------------------------- */

/* Files that are no gaze log, and are refused by name: what their first bytes, of which head holds size, or
 * their header tell. False with a message if it is one. */
bool trk_check_magic(const struct trk_reading *reading, size_t size, char out_error[TRK_ERROR_SIZE]);
bool trk_check_namesakes(const struct trk_reading *reading, char out_error[TRK_ERROR_SIZE]);

/* Keep in mind that the log was made from this file: it is not to be written over. */
void trk_note_source(struct trk_log *log, int fd);

#endif
