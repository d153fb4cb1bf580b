/* tiles: the tiles that a client is sent, read and encoded when it can take them. */
#ifndef FOVEAD_DAEMON_TILES_H
#define FOVEAD_DAEMON_TILES_H

#include "client.h"

/* The time in messages: CLOCK_MONOTONIC, or the virtual clock. */
uint64_t dmn_clock_ns(const struct dmn_handles *handles);

/* Is there a tile to send, and may the client be sent one? */
bool dmn_tile_is_due(struct dmn_client *client);
/* The tile that is due, packed as by dmn_client_pack(). It is then no longer due. NULL if it cannot be read,
 * or memory is short. */
uint8_t *dmn_tile_pack(struct dmn_client *client, size_t *out_count);

#endif
