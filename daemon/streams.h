/* streams: what every program of the project does first and last, for its standard streams. */
#ifndef FOVEAD_DAEMON_STREAMS_H
#define FOVEAD_DAEMON_STREAMS_H

/* Call this first in main(). Closed descriptors 0 to 2 are opened on /dev/null, since the next file that is
 * opened would otherwise get what is printed. Writing to a pipe that nobody reads, or beyond the limit of a
 * file's size, fails and does not end the program. At exit, output that could not be written is an error: a
 * line on stderr that begins with the program's name, and status 1. */
void dmn_streams_open(const char *program);

#endif
