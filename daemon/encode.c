/* Encoded tiles that clients share. */
#include <stdlib.h>

#include "encode.h"

/* Is it the tile that is wanted, and has the picture no newer one? */
static bool is_fresh(const struct dmn_encoded *kept, const struct dmn_picture *picture, size_t index,
                     Fovea__Encoding encoding)
{
    return kept->bytes && kept->index == index && kept->encoding == encoding &&
           kept->read.generation == picture->generation &&
           kept->read.samples >= picture->pyramid.tile[index].samples;
}

const struct dmn_encoded *dmn_encode(struct dmn_encoder *encoder, const struct dmn_picture *picture,
                                     const struct dmn_place *place, Fovea__Encoding encoding)
{
    struct dmn_encoded *kept = &encoder->kept[(place->index + (size_t)encoding * 89) % DMN_ENCODED];
    float rgb[RND_TILE * RND_TILE * 3];

    if (is_fresh(kept, picture, place->index, encoding)) return kept;
    free(kept->bytes);
    kept->bytes = NULL;
    if (!rnd_render_read(picture->render, place->level, place->x, place->y, rgb, &kept->read)) return NULL;
    kept->index = place->index;
    kept->encoding = encoding;
    kept->bytes = pro_encode(encoding, rgb, RND_TILE, &kept->count);
    return kept->bytes ? kept : NULL;
}

void dmn_encoder_finish(struct dmn_encoder *encoder)
{
    for (int i = 0; i < DMN_ENCODED; i++) free(encoder->kept[i].bytes);
}
