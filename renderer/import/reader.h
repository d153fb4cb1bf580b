/* Programs that read files for this one: a file that crashes its reader, or makes it take endless memory or
 * time, harms nothing else.
 *
 * fovead-reader reads a scene file and hands it over in memory that is sealed against writing (flat.h). It
 * lies beside the program that starts it. */
#ifndef FOVEAD_RENDERER_READER_H
#define FOVEAD_RENDERER_READER_H

#include "renderer.h"

#include <sys/types.h>

/* How a reader ends: 0 if all went well, else these. */
enum { RND_READER_REFUSES = 1, RND_READER_MEMORY = 3 };
/* A reader is killed when this many times its limit of processor time has passed on the clock: it must be
 * waiting for something that does not come. */
enum { RND_READER_PATIENCE = 10 };

struct rnd_reader_limits {
    uint32_t mib;     /* of memory, without its code; 0: no limit */
    uint32_t seconds; /* of processor time; 0: no limit */
};

/* The limits of the options; by default 4096 MiB, or half of the machine's memory if that is less, and 20 s
 * and one more for every 2 MiB of the file. */
struct rnd_reader_limits rnd_reader_limits(const struct rnd_scene_options *options, const char *path);

/* Seconds of CLOCK_MONOTONIC. */
double rnd_reader_now(void);

/* Call this first in a reader: it then ends with its parent, and at this limit of memory, if that is not 0.
 */
void rnd_reader_begin(pid_t parent, uint32_t mib);
/* Call this in a reader for each file: it then ends after so much more processor time; 0: no limit. */
void rnd_reader_limit_time(uint32_t seconds);

/* Start a program that lies beside this one. count descriptors become its 3, 4, ...; it gets no others, and
 * no token in the environment. SIGINT, SIGTERM and SIGHUP do not end it. 0 and a line in out_error on
 * failure. */
pid_t rnd_reader_start(const char *name, char *const arguments[], const int *fd, int count,
                       char out_error[RND_ERROR_SIZE]);
/* Write a line such as "the reader crashed (signal 11)". who names the program; status is that of wait(), and
 * neither success nor RND_READER_REFUSES. */
void rnd_reader_why(const char *who, int status, const struct rnd_reader_limits *limits, char *out,
                    size_t size);

#endif
