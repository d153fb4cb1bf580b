/* The third stage: next-event estimation chooses lights. */
#ifndef FOVEAD_RENDERER_PATH_LIGHTS_H
#define FOVEAD_RENDERER_PATH_LIGHTS_H

#include "path/wave.h"

/* Choose a light for each point of paths 1. */
RND_EACH_ISA(void, rnd_choose_lights, struct rnd_tracer *tracer, uint32_t count);

#endif
