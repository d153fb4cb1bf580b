/* reading: what is known of one log while it is read, and what a format is. */
#ifndef FOVEAD_TRACKER_LOG_READING_H
#define FOVEAD_TRACKER_LOG_READING_H

#include "log/lines.h"

enum {
    TRK_HEAD_SIZE = 16384,     /* bytes of a file that tell its format */
    TRK_MAX_FIELDS = 1 << 14,  /* columns of a line */
    TRK_MAX_RECORDINGS = 1024, /* in one file */
    TRK_RECORDING_SIZE = 128,
};

/* The names of a table's columns, from its first line. */
struct trk_header {
    char line[TRK_LINE_SIZE]; /* cut into names */
    char *names[TRK_MAX_FIELDS];
    size_t count;   /* of columns; more than TRK_MAX_FIELDS is no table */
    char separator; /* tab, ';', ',' or TRK_BLANKS */
};

/* One of several recordings in a table: whose rows they are. */
struct trk_recording {
    char participant[TRK_RECORDING_SIZE], name[TRK_RECORDING_SIZE]; /* "" where there is no column */
};

struct trk_reading {
    struct trk_lines lines;
    const struct trk_log_options *options;
    char head[TRK_HEAD_SIZE + 1]; /* what the file begins with, CRs as LFs, no BOM */
    struct trk_header header;     /* its first line */
    char separator;               /* named by a line sep=; before the header; 0: there is no such line */
    const struct trk_log_format *format;
    struct trk_log *log;
    uint64_t last_ns, last_arrival_ns, last_sequence; /* of the last sample appended; 0: there is none */
    /* Set by a format whose rows may be out of order by up to TRK_MAX_DISORDER_NS; they are sorted after the
     * last one. */
    bool disordered;
    size_t late; /* rows that came after a later one */
    /* What the file calls the clocks of device_ns and of arrival_ns. The second is NULL where arrival_ns
     * follows the first. */
    const char *clock_names[2];

    /* Noted on the way, and told in trk_log.assumed after the last row: */
    bool has_decimal_commas;
    size_t rows;      /* taken; a row that is read twice counts twice */
    size_t cut_line;  /* the number of a line that was cut off; 0: none was */
    size_t held;      /* times that went back a little: see trk_log_clock */
    size_t eyes_mean; /* samples whose gaze is the mean of two eyes */
    /* Times with an exponent, as spreadsheets write them (1.70000E+18): the first of them, what its last
     * digit is worth (ns), and whether there are times without an exponent. */
    char exponent_time[32];
    double exponent_step_ns;
    bool has_plain_times;

    struct trk_recording recordings[TRK_MAX_RECORDINGS]; /* met so far */
    size_t recording_count;
    size_t recordings_wanted; /* how many of them the option may mean; without an option, all */
    bool has_more_recordings; /* than there is room for */
    char scratch[TRK_LINE_SIZE];
};

/* Options that a format can make use of. The others are refused. */
enum { TRK_TAKES_TIME_UNIT = 1, TRK_TAKES_FRAME = 2, TRK_TAKES_SCREEN = 4, TRK_TAKES_RECORDING = 8 };

/* A log format: a row of the table in log/formats.h. */
struct trk_log_format {
    const char *id;   /* what trk_log_options.format calls it */
    const char *name; /* goes to trk_log.format */
    unsigned takes;   /* TRK_TAKES_* */
    /* The format is recognised by up to six columns of its header, or, where columns do not suffice, by a
     * function. */
    const char *columns[7];
    bool (*detect)(const struct trk_reading *reading);
    /* A last row without a line end is whole if it ends with this text. NULL: such a row is always taken for
     * cut off. */
    const char *closes;
    /* The note where gaze is the mean of the eyes; NULL: "gaze is the mean of the eyes". */
    const char *says_mean;
    /* Read the whole file; lines.text holds the first line. On failure the caller frees what the log has. */
    bool (*read)(struct trk_reading *reading, char out_error[TRK_ERROR_SIZE]);
};

/* Note what the reader takes for granted, for trk_log.assumed. */
void trk_assume(struct trk_reading *reading, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Remember that the log was made from this file: the file must not be overwritten. */
void trk_note_source(struct trk_log *log, int fd);

#endif
