/* The JSON of a glTF file, and its lists. */
#ifndef FOVEAD_RENDERER_GLTF_JSON_H
#define FOVEAD_RENDERER_GLTF_JSON_H

#include "import/gltf_document.h"

/* Read the JSON, and check its version and required extensions. False and a line in gltf->in->error. */
bool rnd_gltf_open(struct rnd_gltf *gltf, struct rnd_import *in);
void rnd_gltf_close(struct rnd_gltf *gltf);

const json_t *rnd_gltf_extension(const json_t *object, const char *name);
/* Number of elements of a list of the root. */
size_t rnd_gltf_length(const struct rnd_gltf *gltf, const char *list);
/* Read object[key] as a whole number from 0 to most. A missing key gives otherwise; if otherwise is SIZE_MAX,
 * it is an error. where is the object's place. False and a line in the import's error. */
bool rnd_gltf_size(struct rnd_gltf *gltf, const json_t *object, const char *key, size_t otherwise,
                   size_t most, const char *where, size_t *out);
/* The element that index names; NULL, without a line, if it names none. */
static inline const json_t *rnd_gltf_element(const json_t *list, const json_t *index)
{
    return json_is_integer(index) ? json_array_get(list, (size_t)json_integer_value(index)) : NULL;
}
/* The element of a list of the root whose index is value; where is the place of value. NULL and a line. */
const json_t *rnd_gltf_at(struct rnd_gltf *gltf, const char *list, const json_t *value, const char *where,
                          size_t *out_index);
/* Report the features that the file uses and that are not done. */
void rnd_gltf_name_unsupported(struct rnd_gltf *gltf);

#endif
