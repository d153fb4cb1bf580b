/* fovea-bench: one file per measurement. Each prints a table for people, or with --json one JSON object. */
#ifndef FOVEAD_BENCH_H
#define FOVEAD_BENCH_H

#include <stdbool.h>
#include <stdio.h>
#include <time.h>

#include "renderer.h"

/* arguments: like main's, but they begin with the name of the measurement. Return the exit code. */
int bench_busy(int count, char **arguments);
int bench_converge(int count, char **arguments);
int bench_features(int count, char **arguments);
int bench_foveation(int count, char **arguments);
int bench_sampling(int count, char **arguments);
int bench_startup(int count, char **arguments);
int bench_stream(int count, char **arguments);
int bench_throughput(int count, char **arguments);

/* An option that takes numbers with commas between them, or a text. */
struct bench_option {
    const char *name; /* without the dashes; NULL ends a list */
    enum { BENCH_INT, BENCH_FLOAT, BENCH_DOUBLE, BENCH_TEXT } kind;
    void *to;
    int numbers;
    double least, most; /* of each number */
};

/* Parse the options of the list, --json, --help and, unless scene is NULL, those of BENCH_SCENE_HELP; without
 * --scene the scene is the shipped hall. Options that are not given leave their variables alone. Returns
 * false after a line on stderr. Ends the program if help was asked for. */
bool bench_options(int count, char **arguments, const char *help, const struct bench_option *list,
                   struct rnd_scene_options *scene, bool *json);
#define BENCH_SCENE_HELP                                                                                     \
    "  --scene FILE       default: the shipped hall, with its sky\n"                                         \
    "  --env FILE         environment map\n"                                                                 \
    "  --sun A,E,S,D      azimuth, elevation, irradiance, angular diameter (deg)\n"                          \
    "  --camera X,Y,Z     m; --eye is the older name\n"

/* Print one line to stderr. Returns false. */
bool bench_fail(const char *error);

/* The time of a clock of clock_gettime(), s. */
double bench_seconds(clockid_t clock);

/* Median of count values, at most 99. */
double bench_median(const double *values, int count);

#endif
