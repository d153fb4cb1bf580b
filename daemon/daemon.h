/* daemon: the programs fovead and foveactl. This header has what both share.
 *
 * How fovead runs
 * - One thread has the event loop (loop.c): sockets, timers, sessions. It alone encodes and sends.
 * - One thread paints (paint.c): batch after batch, aimed at the newest gaze; the renderer has its own
 *   workers.
 * - With the real clock one thread reads the gaze source (gaze.c). With the virtual clock the painter reads
 *   it, so that the same log gives the same film.
 * - One thread does jobs that wait for the disk (jobs.c).
 * - While a viewer is wanted that is not there, one thread after the other tries to reach it (dial.c).
 * The others wake the loop; the loop never waits for them.
 */
#ifndef FOVEAD_DAEMON_H
#define FOVEAD_DAEMON_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "histogram.h"
#include "numbers.h"
#include "print.h"
#include "protocol.h"
#include "renderer.h"
#include "tracker.h"

#endif
