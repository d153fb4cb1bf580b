/* web: for browsers: the page's files by HTTP, and messages by WebSocket, one in each binary frame. */
#ifndef FOVEAD_DAEMON_TRANSPORT_WEB_H
#define FOVEAD_DAEMON_TRANSPORT_WEB_H

#include "transport/transport.h"

extern const struct dmn_transport dmn_web;

#endif
