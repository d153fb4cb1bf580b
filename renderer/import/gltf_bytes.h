/* The bytes behind a glTF file. */
#ifndef FOVEAD_RENDERER_GLTF_BYTES_H
#define FOVEAD_RENDERER_GLTF_BYTES_H

#include "import/gltf_document.h"

/* Count numbers before memory is allocated for them. A file may refer to the same bytes many times, but only
 * up to a limit. False and a line. */
bool rnd_gltf_ask(struct rnd_gltf *gltf, size_t numbers, const char *where);
/* The bytes of a data URI. NULL if it is not one of base64, or memory is short. The caller frees. */
uint8_t *rnd_gltf_data_uri(const char *uri, size_t *out_count);
/* The bytes of a buffer view, the file's until it is closed, and the distance of elements that it asks for,
 * or 0. NULL and a line. */
const uint8_t *rnd_gltf_view(struct rnd_gltf *gltf, const json_t *index, const char *where, size_t *out_size,
                             size_t *out_stride);

#endif
