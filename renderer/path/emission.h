/* Light that paths find without choosing a light. */
#ifndef FOVEAD_RENDERER_EMISSION_H
#define FOVEAD_RENDERER_EMISSION_H

#include "path/wave.h"

/* Add the radiance of environment and sun to count paths of a list, which are paths 0 that left the scene. */
RND_EACH_ISA(void, rnd_sky, struct rnd_tracer *tracer, const uint32_t *list, uint32_t count);
/* Add what the surfaces of paths 1 emit themselves. */
RND_EACH_ISA(void, rnd_emission, struct rnd_tracer *tracer, uint32_t count);

#endif
