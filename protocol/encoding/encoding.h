/* encoding.h: a way to turn a tile's pixels into bytes and back.
 *
 * To add one: its number in fovea.proto, its file here, its line in the table in encoding.c.
 */
#ifndef FOVEAD_ENCODING_H
#define FOVEAD_ENCODING_H

#include "../internal.h"

#pragma GCC visibility push(hidden)

/* As pro_encode() and pro_decode(), with size from 1 to PRO_MAX_TILE. */
struct pro_codec {
    Fovea__Encoding encoding;
    uint8_t *(*encode)(const float *rgb, unsigned size, size_t *out_count);
    bool (*decode)(const uint8_t *bytes, size_t count, unsigned size, float *out_rgb);
};

extern const struct pro_codec pro_half_zstd, pro_jpeg, pro_rgb9e5;

#pragma GCC visibility pop

#endif
