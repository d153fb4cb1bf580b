/* chart: a chart that gnuplot draws, as a file that appears whole or not at all. */
#ifndef FOVEAD_DAEMON_CHART_H
#define FOVEAD_DAEMON_CHART_H

#include "file.h"

struct dmn_chart {
    FILE *commands; /* to gnuplot, which draws to its standard output */
    int drawn;      /* a file in memory, with what gnuplot has drawn */
};

/* Start gnuplot. False with a line in out_error on failure; dmn_chart_end() is then not called. */
bool dmn_chart_begin(struct dmn_chart *chart, char out_error[DMN_FILE_ERROR_SIZE]);

/* Write the chart to a path that ends in .svg or .png, as the terminal that the commands have set, as a file
 * of that mode. False with a line in out_error: gnuplot is missing or failed, or the file could not be
 * written. */
bool dmn_chart_end(struct dmn_chart *chart, const char *path, mode_t mode,
                   char out_error[DMN_FILE_ERROR_SIZE]);

#endif
