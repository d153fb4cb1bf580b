/* table: the transports that there are. */
#ifndef FOVEAD_DAEMON_TRANSPORT_TABLE_H
#define FOVEAD_DAEMON_TRANSPORT_TABLE_H

#include "transport/transport.h"

/* In 0.. for a list, which NULL ends. The first serves every listener. */
const struct dmn_transport *dmn_transport_at(size_t index);

#endif
