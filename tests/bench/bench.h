/* fovea-bench: one file a measurement. Each prints a table for people, or one JSON object with --json. */
#ifndef FOVEAD_BENCH_H
#define FOVEAD_BENCH_H

#include <stdbool.h>
#include <stdio.h>

#include "renderer.h"

/* arguments as main's, from the measurement's name on; returns the exit code. */
int bench_converge(int count, char **arguments);
int bench_features(int count, char **arguments);
int bench_foveation(int count, char **arguments);
int bench_sampling(int count, char **arguments);
int bench_startup(int count, char **arguments);
int bench_throughput(int count, char **arguments);

/* Options by which every measurement that renders takes its scene; for getopt_long, and their help. */
#define BENCH_SCENE_OPTIONS                                                                                  \
    {"scene", 1, NULL, 's'}, {"env", 1, NULL, 'e'}, {"sun", 1, NULL, 'u'},                                   \
    {                                                                                                        \
        "eye", 1, NULL, 'y'                                                                                  \
    }
#define BENCH_SCENE_HELP                                                                                     \
    "  --scene FILE       default: the shipped hall, with its sky\n"                                         \
    "  --env FILE         environment map\n"                                                                 \
    "  --sun A,E,S,D      azimuth, elevation, irradiance, angular diameter (deg)\n"                          \
    "  --eye X,Y,Z        m\n"
/* Take an option of them, with getopt's optarg; false if c is none. *out_ok: it could be used. */
bool bench_scene_option(int c, struct rnd_scene_options *scene, bool *out_ok);
/* Without --scene: the shipped hall. */
void bench_scene_default(struct rnd_scene_options *scene);
/* After an option that could not be used: a line on stderr; false. */
bool bench_refuse(void);

/* Median of count values, at most 99. */
double bench_median(const double *values, int count);

/* gnuplot, to write commands to; NULL if there can be no pipe. bench_drawn() ends it (accepts NULL): false
 * after a line on stderr if it has not drawn path. */
FILE *bench_draw(void);
bool bench_drawn(FILE *gnuplot, const char *path);

#endif
