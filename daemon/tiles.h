/* tiles: the tiles that a client is sent, read and encoded at the moment it can take them. */
#ifndef FOVEAD_DAEMON_TILES_H
#define FOVEAD_DAEMON_TILES_H

#include "client.h"

/* The clock that messages have their times by: CLOCK_MONOTONIC, or the virtual one. */
uint64_t dmn_clock_ns(const struct dmn_handles *handles);

/* Is there a tile to send, and does the client have room for it? */
bool dmn_tile_is_due(struct dmn_client *client);
/* The tile that is due, packed as dmn_client_pack() does. NULL if it cannot be read, or memory is short; it
 * is then not due any more. */
uint8_t *dmn_tile_pack(struct dmn_client *client, size_t *out_count);

#endif
