/* Accessors of a glTF file: numbers in its buffers. */
#ifndef FOVEAD_RENDERER_GLTF_ACCESSOR_H
#define FOVEAD_RENDERER_GLTF_ACCESSOR_H

#include "import/gltf_document.h"

enum {
    RND_GLTF_BYTE = 5120,
    RND_GLTF_UNSIGNED_BYTE,
    RND_GLTF_SHORT,
    RND_GLTF_UNSIGNED_SHORT,
    RND_GLTF_UNSIGNED_INT = 5125,
    RND_GLTF_FLOAT
};

struct rnd_gltf_accessor {
    size_t count;      /* elements */
    size_t n;          /* numbers of an element, 1 to 4 */
    size_t component;  /* RND_GLTF_... */
    bool normalised;   /* integers stand for -1 to 1, or 0 to 1 */
    size_t stride;     /* bytes from element to element */
    const uint8_t *at; /* the first, or NULL: all are 0 */
    size_t sparse;     /* number of sparse elements, at rising indices */
    size_t sparse_component;
    const uint8_t *sparse_index, *sparse_value;
};

/* Find an accessor, and check that all its numbers are within the buffers. False and a line. */
bool rnd_gltf_accessor(struct rnd_gltf *gltf, const json_t *index, const char *where,
                       struct rnd_gltf_accessor *out);
/* Elements first .. first + count as floats, integers normalised as glTF 2.0 section 3.6.2.2 says. */
void rnd_gltf_floats(const struct rnd_gltf_accessor *accessor, size_t first, size_t count, float *out);
/* All elements of an accessor of unsigned integers. */
void rnd_gltf_integers(const struct rnd_gltf_accessor *accessor, uint32_t *out);

#endif
