/* hello: a client's Hello, and the check of its token. */
#ifndef FOVEAD_DAEMON_HELLO_H
#define FOVEAD_DAEMON_HELLO_H

#include "client.h"

/* Take the client's Hello: check its token, or hold the message until its turn (in client->held, which then
 * owns it). False with a line in out_error if the client must be dropped. */
bool dmn_hello_take(struct dmn_client *client, Fovea__Message *message, char out_error[PRO_ERROR_SIZE]);
/* The turn of the held Hello has come: check its token, and free it. False as above. */
bool dmn_hello_turn(struct dmn_client *client, char out_error[PRO_ERROR_SIZE]);

#endif
