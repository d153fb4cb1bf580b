/* table: the transports. */
#ifndef FOVEAD_DAEMON_TRANSPORT_TABLE_H
#define FOVEAD_DAEMON_TRANSPORT_TABLE_H

#include "transport/transport.h"

/* The transport of that index, from 0; NULL after the last one. The first one serves every listener. */
const struct dmn_transport *dmn_transport_at(size_t index);

#endif
