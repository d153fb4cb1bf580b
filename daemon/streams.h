/* streams: what every program of the project does first, and what it does last. */
#ifndef FOVEAD_DAEMON_STREAMS_H
#define FOVEAD_DAEMON_STREAMS_H

/* First thing in main(). Descriptors 0 to 2 that are closed are opened on /dev/null, or the next file to be
 * opened would get what is printed. A pipe that nobody reads and a file that may grow no more are errors of
 * the write, not the end of the program. At exit, output that could not be written is an error: a line on
 * stderr that begins with the program's name, and status 1. */
void dmn_streams_open(const char *program);

#endif
