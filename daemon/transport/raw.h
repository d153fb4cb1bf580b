/* raw: frames on a Unix or TCP socket (fovea.proto), for foveactl and other viewers. */
#ifndef FOVEAD_DAEMON_TRANSPORT_RAW_H
#define FOVEAD_DAEMON_TRANSPORT_RAW_H

#include "transport/transport.h"

extern const struct dmn_transport dmn_raw;

#endif
