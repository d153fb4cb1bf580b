/* The standard streams of a program, at its start and end. */
#include "streams.h"
#include "file.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const char *name;

static void close_output(void)
{
    if (dmn_file_is_written(stdout) && !fclose(stdout)) return;
    /* Whoever closed the pipe knows that. */
    if (errno != EPIPE) fprintf(stderr, "%s: the output cannot be written: %s\n", name, strerror(errno));
    _exit(1);
}

void dmn_streams_open(const char *program)
{
    int fd;

    do fd = open("/dev/null", O_RDWR);
    while (fd >= 0 && fd <= STDERR_FILENO);
    if (fd >= 0) close(fd);
    signal(SIGPIPE, SIG_IGN);
    signal(SIGXFSZ, SIG_IGN);
    name = program;
    atexit(close_output);
}
