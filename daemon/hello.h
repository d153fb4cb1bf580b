/* hello: how a client comes in: its Hello, and the token in it. */
#ifndef FOVEAD_DAEMON_HELLO_H
#define FOVEAD_DAEMON_HELLO_H

#include "client.h"

/* Take the client's Hello: look at its token, or hold the message until its turn (client->held, which is then
 * the client's). False with a line in out_error if the client must be dropped. */
bool dmn_hello_take(struct dmn_client *client, Fovea__Message *message, char out_error[PRO_ERROR_SIZE]);
/* The turn of the Hello that is held, which is freed. */
bool dmn_hello_turn(struct dmn_client *client, char out_error[PRO_ERROR_SIZE]);

#endif
