/* What the camera sees: the film's planes, gathered where paths first hit a surface. */
#ifndef FOVEAD_RENDERER_VISIBLE_H
#define FOVEAD_RENDERER_VISIBLE_H

#include "path/wave.h"

/* Of a wave of so many paths, of which those hit a surface, in paths 1: fill its plane values. */
void rnd_visible(struct rnd_tracer *tracer, uint32_t paths, uint32_t hits);

#endif
