/* requests: the messages that clients send, one row each: who may send it, and what it does. */
#ifndef FOVEAD_DAEMON_REQUESTS_H
#define FOVEAD_DAEMON_REQUESTS_H

#include "client.h"

/* Do what a message asks for. The caller frees the message, unless it is now client->held. False with a line
 * in out_error if the client must be dropped. */
bool dmn_request_take(struct dmn_client *client, Fovea__Message *message, char out_error[PRO_ERROR_SIZE]);

#endif
