/* table: the columns of a table by name, its rows, and numbers that may be missing. */
#ifndef FOVEAD_TRACKER_LOG_TABLE_H
#define FOVEAD_TRACKER_LOG_TABLE_H

#include "log/reading.h"

/* A table that is being read. Its rows follow the header of the reading. */
struct trk_table {
    struct trk_reading *reading;
    char separator;               /* of the rows; 0 until the first row shows it */
    bool may_be_short;            /* a row may lack its last fields; they then count as empty */
    char comment;                 /* lines that begin with it are comments; 0: there are none */
    int participant, recording;   /* columns that identify recordings; -1: none */
    char *fields[TRK_MAX_FIELDS]; /* of the row that was taken last */
    /* Called after a row has been split into count fields, to repair it. Returns the new number of fields.
     * NULL: rows need no repair. */
    size_t (*mend)(void *reader, struct trk_table *table, size_t count);
    void *reader;
};

/* If separator is 0, trk_separator_of() finds it. */
void trk_header_parse(struct trk_header *header, const char *line, char separator);

/* The first column with that name, or -1. Only letters and digits of names are compared, without regard to
 * case; text in square brackets is ignored. */
int trk_header_find(const struct trk_header *header, const char *name);

/* Does the header have all of these columns? The list ends with NULL. False for an empty list. */
bool trk_header_has(const struct trk_header *header, const char *const columns[]);

/* The column with that name whose square brackets contain unit, or which has no brackets. */
int trk_header_find_unit(const struct trk_header *header, const char *name, const char *unit);

/* Begin a table under the header of the reading. */
void trk_table_init(struct trk_table *table, struct trk_reading *reading);

/* Find n columns. False with a message if one is missing. */
bool trk_table_need(struct trk_table *table, const char *const names[], int n, int out_columns[],
                    char out_error[TRK_ERROR_SIZE]);

/* Take the next row that is not empty and belongs to the wanted recording. TRK_LINE_FAILED also if the row
 * does not have as many fields as the header (empty fields at its end do not count), or if no recording was
 * asked for and the table holds several. */
enum trk_line trk_table_next(struct trk_table *table, char out_error[TRK_ERROR_SIZE]);

/* Like trk_table_next(), but begin with the line that has already been taken. */
enum trk_line trk_table_first(struct trk_table *table, char out_error[TRK_ERROR_SIZE]);

/* Read all rows. read_row gets `reader` and turns the current row into a sample; it leaves the sample's
 * sequence 0 if the row holds no sample. False with a message if a row is refused. */
bool trk_table_read(struct trk_table *table,
                    bool (*read_row)(void *reader, struct trk_sample *out_sample,
                                     char out_error[TRK_ERROR_SIZE]),
                    void *reader, char out_error[TRK_ERROR_SIZE]);

/* Read a number of the row; NaN if it is missing or if column is -1. False with a message if it is anything
 * else, or infinite. */
bool trk_table_number(struct trk_table *table, int column, double *out_value, char out_error[TRK_ERROR_SIZE]);

/* Read n numbers in these columns as floats. */
bool trk_table_numbers(struct trk_table *table, const int *columns, int n, float *out_values,
                       char out_error[TRK_ERROR_SIZE]);

/* Read a whole number. False with a message if it is missing or anything else. */
bool trk_table_integer(struct trk_table *table, int column, int64_t *out_value,
                       char out_error[TRK_ERROR_SIZE]);

bool trk_table_time(struct trk_table *table, int column, double unit_ns, int64_t *out_ns,
                    char out_error[TRK_ERROR_SIZE]);

/* Guess the unit of a column of times, and return the length of its tick in ns. Gaze is recorded at 20 to
 * 2500 Hz, and the median step of the first rows, or else their mean step, has such a rate in only one of the
 * units s, ms, us and ns. An option that names the unit takes precedence. Afterwards the reading is back at
 * the line where it was. 0 with a message if no unit fits. */
double trk_table_guess_unit(struct trk_table *table, int column, char out_error[TRK_ERROR_SIZE]);

#endif
