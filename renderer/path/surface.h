/* The second stage: what rays have hit. */
#ifndef FOVEAD_RENDERER_PATH_SURFACE_H
#define FOVEAD_RENDERER_PATH_SURFACE_H

#include "path/wave.h"

/* Of count rays that were traced from paths 0: add the sky's radiance for those that hit nothing. The others
 * go to paths 1, sorted by kind of material, with their surfaces. Returns their number. */
RND_EACH_ISA(uint32_t, rnd_surface, struct rnd_tracer *tracer, uint32_t count);
#endif
