/* table: all transports, and which of them serves a listener. */
#ifndef FOVEAD_DAEMON_TRANSPORT_TABLE_H
#define FOVEAD_DAEMON_TRANSPORT_TABLE_H

#include "transport/transport.h"

enum { DMN_TRANSPORTS = 2 };
extern const struct dmn_transport *const dmn_transports[DMN_TRANSPORTS];

/* Index in dmn_transports of the transport that serves a listener. */
int dmn_transport_of(const struct dmn_listener *listener);

#endif
