/* fovea-bench: one file a measurement. Each prints a table for people, or one JSON object with --json. */
#ifndef FOVEAD_BENCH_H
#define FOVEAD_BENCH_H

/* arguments as main's, from the measurement's name on; returns the exit code. */
int bench_converge(int count, char **arguments);
int bench_foveation(int count, char **arguments);

#endif
