/* trackers: fovead --list-trackers. */
#ifndef FOVEAD_DAEMON_TRACKERS_H
#define FOVEAD_DAEMON_TRACKERS_H

#include <stdbool.h>

/* Print on stdout what eye trackers are plugged in, what each can do, and why one cannot be opened. False
 * after a line on stderr if memory is short. */
bool dmn_list_trackers(bool json);

#endif
