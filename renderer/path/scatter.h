/* The fourth stage: light is scattered, and paths go on. */
#ifndef FOVEAD_RENDERER_PATH_SCATTER_H
#define FOVEAD_RENDERER_PATH_SCATTER_H

#include "path/wave.h"

/* Form the shadow rays of the lights that were chosen for paths 1, with what each of them contributes; and
 * put the paths that go on into paths 0. Returns their number; the last step has none. */
RND_EACH_ISA(uint32_t, rnd_scatter, struct rnd_tracer *tracer, uint32_t count);

#endif
