/* half_zstd.c: linear radiance as half floats, little endian, row by row, packed by zstd. Only the rounding
 * to half floats loses anything. */
#include "encoding.h"
#include "half.h"

#include <endian.h>
#include <stdlib.h>
#include <zstd.h>

/* Higher levels save a few per cent of noisy tiles and take several times as long. */
enum { LEVEL = 1 };

static uint8_t *encode(const float *rgb, unsigned size, size_t *out_count)
{
    size_t values = (size_t)size * size * 3;
    size_t bound = ZSTD_compressBound(values * sizeof(uint16_t));
    uint16_t *halves = malloc(values * sizeof *halves);
    uint8_t *bytes = malloc(bound);
    if (!halves || !bytes) goto fail;
    for (size_t i = 0; i < values; i++) halves[i] = htole16(half_from_float(rgb[i]));
    size_t count = ZSTD_compress(bytes, bound, halves, values * sizeof *halves, LEVEL);
    if (ZSTD_isError(count)) goto fail;
    free(halves);
    /* Tiles wait in queues: free what is beyond count. */
    uint8_t *exact = realloc(bytes, count);
    *out_count = count;
    return exact ? exact : bytes;
fail:
    free(bytes);
    free(halves);
    return NULL;
}

static bool decode(const uint8_t *bytes, size_t count, unsigned size, float *out_rgb)
{
    size_t values = (size_t)size * size * 3;
    /* It must be one frame that states its size and has all bytes, so that memory is known before. */
    if (ZSTD_getFrameContentSize(bytes, count) != values * sizeof(uint16_t)) return false;
    if (ZSTD_findFrameCompressedSize(bytes, count) != count) return false;
    uint16_t *halves = malloc(values * sizeof *halves);
    if (!halves) return false;
    bool ok = ZSTD_decompress(halves, values * sizeof *halves, bytes, count) == values * sizeof *halves;
    unsigned not_finite = 0;
    for (size_t i = 0; ok && i < values; i++) {
        uint16_t half = le16toh(halves[i]);
        not_finite |= !half_is_finite(half);
        out_rgb[i] = half_to_float(half);
    }
    free(halves);
    return ok && !not_finite;
}

const struct pro_codec pro_half_zstd = {FOVEA__ENCODING__ENCODING_HALF_ZSTD, encode, decode};
