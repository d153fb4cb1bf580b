/* dial: connects to an address without making the caller wait, neither for names to be looked up nor for a
 * machine that does not answer. A thread of its own does so, and ends with the attempt. */
#ifndef FOVEAD_DAEMON_DIAL_H
#define FOVEAD_DAEMON_DIAL_H

#include "protocol.h"

/* What became of an attempt: a connected non-blocking socket, which the caller owns; or -1 and why, one
 * line. */
struct dmn_dialled {
    int fd;
    char why[PRO_ERROR_SIZE];
};

/* Begin an attempt. Returns a descriptor that becomes readable when the attempt has ended. The caller must
 * close it, and may do so before that. -1 if no thread can be made. */
int dmn_dial(const struct pro_address *address);
/* Take the result from such a readable descriptor. */
void dmn_dial_take(int fd, struct dmn_dialled *out_dialled);

#endif
