/* encoding.c: the table of tile encodings. */
#include "encoding.h"

static const struct pro_codec *const codecs[] = {&pro_half_zstd, &pro_jpeg, &pro_rgb9e5};

static const struct pro_codec *find(Fovea__Encoding encoding, unsigned size)
{
    if (size < 1 || size > PRO_MAX_TILE) return NULL;
    for (size_t i = 0; i < sizeof codecs / sizeof *codecs; i++)
        if (codecs[i]->encoding == encoding) return codecs[i];
    return NULL;
}

bool pro_encodes(Fovea__Encoding encoding)
{
    return find(encoding, 1);
}

uint8_t *pro_encode(Fovea__Encoding encoding, const float *rgb, unsigned size, size_t *out_count)
{
    const struct pro_codec *codec = find(encoding, size);
    return codec ? codec->encode(rgb, size, out_count) : NULL;
}

bool pro_decode(Fovea__Encoding encoding, const uint8_t *bytes, size_t count, unsigned size, float *out_rgb)
{
    const struct pro_codec *codec = find(encoding, size);
    return codec && codec->decode(bytes, count, size, out_rgb);
}
