/* fovea-bench: one file a measurement. Each prints a table for people, or one JSON object with --json. */
#ifndef FOVEAD_BENCH_H
#define FOVEAD_BENCH_H

#include <stdbool.h>
#include <stdio.h>

/* arguments as main's, from the measurement's name on; returns the exit code. */
int bench_converge(int count, char **arguments);
int bench_foveation(int count, char **arguments);

/* gnuplot, to write commands to; NULL if there can be no pipe. bench_drawn() ends it (accepts NULL): false
 * after a line on stderr if it has not drawn path. */
FILE *bench_draw(void);
bool bench_drawn(FILE *gnuplot, const char *path);

#endif
