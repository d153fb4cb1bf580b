/* table: the columns of a table by name, its rows, and numbers that may be missing. */
#ifndef FOVEAD_TRACKER_LOG_TABLE_H
#define FOVEAD_TRACKER_LOG_TABLE_H

#include "log/reading.h"

/* A table that is being read: rows under the reading's header. */
struct trk_table {
    struct trk_reading *reading;
    char separator;               /* of the rows; 0 until the first one tells it */
    bool may_be_short;            /* a row may lack its last fields: they are empty */
    char comment;                 /* lines that begin with it are no rows; 0: there are none */
    int participant, recording;   /* columns that tell recordings apart; -1: none */
    char *fields[TRK_MAX_FIELDS]; /* of the row that was taken last */
    /* Called when a row has been cut into count fields, to mend it; returns how many fields there are then.
     * NULL: rows are as they are. */
    size_t (*mend)(void *reader, struct trk_table *table, size_t count);
    void *reader;
};

/* separator 0: the one that trk_separator_of() finds. */
void trk_header_parse(struct trk_header *header, const char *line, char separator);

/* The column of that name; the first of several; -1: there is none. Names are compared by their letters and
 * digits alone, without regard to case or to what stands in square brackets. */
int trk_header_find(const struct trk_header *header, const char *name);

/* Does it have all of these columns? The list ends with NULL; no header has those of an empty list. */
bool trk_header_has(const struct trk_header *header, const char *const columns[]);

/* The column of that name that has unit in its square brackets too, or has no brackets. */
int trk_header_find_unit(const struct trk_header *header, const char *name, const char *unit);

/* Under the reading's header. */
void trk_table_init(struct trk_table *table, struct trk_reading *reading);

/* Find n columns; false with a message if one is missing. */
bool trk_table_need(struct trk_table *table, const char *const names[], int n, int out_columns[],
                    char out_error[TRK_ERROR_SIZE]);

/* Take the next row that is not empty and belongs to the recording that is asked for. TRK_LINE_FAILED too if
 * it does not have as many fields as the header (empty ones after the last do not count), or if it belongs to
 * another recording than the rows before it and no recording was asked for. */
enum trk_line trk_table_next(struct trk_table *table, char out_error[TRK_ERROR_SIZE]);

/* The same with the line that was taken already. */
enum trk_line trk_table_first(struct trk_table *table, char out_error[TRK_ERROR_SIZE]);

/* Read all rows. read_row gets reader; it turns the current row into a sample, or leaves the sample's
 * sequence 0 if the row holds none. False with a message when a row is refused. */
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

/* The ns of a tick in a column of times of unknown unit, from the median step of the first rows, or else from
 * their mean step: gaze is recorded at 20 to 2500 Hz, and only one of s, ms, us and ns gives such a rate.
 * Leaves the reading at the first row. 0 with a message when none does. An option that names the unit takes
 * precedence. */
double trk_table_guess_unit(struct trk_table *table, int column, char out_error[TRK_ERROR_SIZE]);

#endif
