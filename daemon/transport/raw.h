/* raw: frames on a Unix or TCP socket, as foveactl and other viewers speak (fovea.proto). */
#ifndef FOVEAD_DAEMON_TRANSPORT_RAW_H
#define FOVEAD_DAEMON_TRANSPORT_RAW_H

#include "transport/transport.h"

extern const struct dmn_transport dmn_raw;

#endif
