/* The buffers of a glTF file, and views into them. */
#ifndef FOVEAD_RENDERER_GLTF_BYTES_H
#define FOVEAD_RENDERER_GLTF_BYTES_H

#include "import/gltf_document.h"

/* Count numbers before memory is allocated for them: a file may use the same bytes many times, but only up to
 * a limit. False and a line if the limit is exceeded. */
bool rnd_gltf_ask(struct rnd_gltf *gltf, size_t numbers, const char *where);
/* Decode a data URI in base64. NULL if it is none, or memory is short. The caller frees. */
uint8_t *rnd_gltf_data_uri(const char *uri, size_t *out_count);
/* The bytes of a buffer view, valid until the file is closed, and its byteStride, or 0. NULL and a line. */
const uint8_t *rnd_gltf_view(struct rnd_gltf *gltf, const json_t *index, const char *where, size_t *out_size,
                             size_t *out_stride);

#endif
