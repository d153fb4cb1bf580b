/* reading: the state of one log while it is read, and the description of a format. */
#ifndef FOVEAD_TRACKER_LOG_READING_H
#define FOVEAD_TRACKER_LOG_READING_H

#include "log/lines.h"

enum {
    TRK_HEAD_SIZE = 16384,     /* bytes of a file that identify its format */
    TRK_MAX_FIELDS = 1 << 14,  /* columns of a line */
    TRK_MAX_RECORDINGS = 1024, /* in one file */
    TRK_RECORDING_SIZE = 128,
};

/* The column names of a table, from its first line. */
struct trk_header {
    char line[TRK_LINE_SIZE]; /* cut into names */
    char *names[TRK_MAX_FIELDS];
    size_t count;   /* of columns; a table has at most TRK_MAX_FIELDS */
    char separator; /* tab, ';', ',' or TRK_BLANKS */
};

/* One of several recordings in a table. */
struct trk_recording {
    char participant[TRK_RECORDING_SIZE], name[TRK_RECORDING_SIZE]; /* "" if the table has no such column */
};

struct trk_reading {
    struct trk_lines lines;
    const struct trk_log_options *options;
    char head[TRK_HEAD_SIZE + 1]; /* the start of the file, without BOM, with LF for each CR */
    struct trk_header header;     /* its first line */
    char separator;               /* from a line sep=; before the header; 0: the file has none */
    const struct trk_log_format *format;
    struct trk_log *log;
    uint64_t last_ns, last_arrival_ns, last_sequence; /* of the last sample; 0 before the first */
    /* A format sets this if its rows may be out of order by up to TRK_MAX_DISORDER_NS. Then the rows are
     * sorted after the last one is read. */
    bool disordered;
    size_t late; /* rows that are earlier than the row before them */
    /* The file's names for the clocks of device_ns and arrival_ns. The second is NULL if arrival_ns is
     * derived from device_ns. */
    const char *clock_names[2];

    /* Counted while reading; trk_log.assumed reports it after the last row: */
    bool has_decimal_commas;
    size_t rows;      /* rows taken; a row that is read twice counts twice */
    size_t cut_line;  /* the number of a line that was cut off; 0: none */
    size_t held;      /* times that went back a little: see trk_log_clock */
    size_t eyes_mean; /* samples whose gaze is the mean of two eyes */
    /* Times with an exponent, as spreadsheets write them (1.70000E+18): the first such time, the smallest
     * value of a last digit (ns), and whether any time has no exponent. */
    char exponent_time[32];
    double exponent_step_ns;
    bool has_plain_times;

    struct trk_recording recordings[TRK_MAX_RECORDINGS]; /* met so far */
    size_t recording_count;
    size_t recordings_wanted; /* how many of them match the option; all if there is no option */
    bool has_more_recordings; /* more than TRK_MAX_RECORDINGS */
    char scratch[TRK_LINE_SIZE];
};

/* Options that a format can use. Other options are refused. */
enum { TRK_TAKES_TIME_UNIT = 1, TRK_TAKES_FRAME = 2, TRK_TAKES_SCREEN = 4, TRK_TAKES_RECORDING = 8 };

/* A log format: a row of the table in log/formats.h. */
struct trk_log_format {
    const char *id;   /* its name in trk_log_options.format */
    const char *name; /* its name in trk_log.format */
    unsigned takes;   /* TRK_TAKES_* */
    /* How the format is recognised: by up to six columns of the header, or by a function if columns are not
     * enough. */
    const char *columns[7];
    bool (*detect)(const struct trk_reading *reading);
    /* A last row without a line end is complete if it ends with this text. NULL: such a row always counts as
     * cut off. */
    const char *closes;
    /* The note if gaze is the mean of the eyes; NULL: "gaze is the mean of the eyes". */
    const char *says_mean;
    /* Read the whole file; lines.text already holds the first line. On failure the caller frees the samples.
     */
    bool (*read)(struct trk_reading *reading, char out_error[TRK_ERROR_SIZE]);
};

/* Note in trk_log.assumed what the reader assumes. */
void trk_assume(struct trk_reading *reading, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Remember that the log was read from this file, so that nobody overwrites it. */
void trk_note_source(struct trk_log *log, int fd);

#endif
