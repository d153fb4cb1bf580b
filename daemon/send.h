/* send: the messages that a client is sent, one row each, in the order in which they are sent: who wants it,
 * when it is due, and how it is built. */
#ifndef FOVEAD_DAEMON_SEND_H
#define FOVEAD_DAEMON_SEND_H

#include "client.h"

/* No message waits packed: a tile is read and encoded when the client can take it, so the newest always wins,
 * and a slow client gets fewer. */

/* Is there something to send? */
bool dmn_send_is_due(struct dmn_client *client);
/* The next message, packed as dmn_client_pack() does; NULL if there is nothing, or no memory. */
uint8_t *dmn_send_next(struct dmn_client *client, size_t *out_count);

/* A last message that tells a client why it is dropped or not let in, malloc'ed with headroom bytes before
 * it; the caller frees. */
uint8_t *dmn_send_farewell(const char *why, size_t headroom, size_t *out_count);

#endif
