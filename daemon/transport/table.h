/* table: the transports. */
#ifndef FOVEAD_DAEMON_TRANSPORT_TABLE_H
#define FOVEAD_DAEMON_TRANSPORT_TABLE_H

#include "transport/transport.h"

/* The transport by HTTP comes first: see dmn_transport.host. */
enum { DMN_TRANSPORTS = 2 };
extern const struct dmn_transport *const dmn_transports[DMN_TRANSPORTS];

/* Index of the transport that serves a listener. */
int dmn_transport_of(const struct dmn_listener *listener);

#endif
