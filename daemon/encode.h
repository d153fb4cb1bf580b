/* encode: tiles as clients are sent them. The newest are kept, so that clients that want the same tile in the
 * same encoding share the work of reconstructing and encoding it. For the loop's thread alone. */
#ifndef FOVEAD_DAEMON_ENCODE_H
#define FOVEAD_DAEMON_ENCODE_H

#include "next.h"
#include "picture.h"
#include "protocol.h"

/* A tile, encoded. */
struct dmn_encoded {
    size_t index; /* in the pyramid */
    Fovea__Encoding encoding;
    struct rnd_tile read; /* as it was when it was read */
    uint8_t *bytes;       /* NULL: there is none */
    size_t count;
};

enum { DMN_ENCODED = 256 }; /* tiles that are kept */

/* All zero: none are kept. */
struct dmn_encoder {
    struct dmn_encoded kept[DMN_ENCODED];
};

/* The tile at a place: as it was encoded last, unless more is known of it by now. Valid until the next call.
 * NULL if it cannot be read, or memory is short. */
const struct dmn_encoded *dmn_encode(struct dmn_encoder *encoder, const struct dmn_picture *picture,
                                     const struct dmn_place *place, Fovea__Encoding encoding);
void dmn_encoder_finish(struct dmn_encoder *encoder);

#endif
