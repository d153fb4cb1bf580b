/* The first stage: paths begin. */
#ifndef FOVEAD_RENDERER_PATH_START_H
#define FOVEAD_RENDERER_PATH_START_H

#include "path/wave.h"
#include "space/camera.h"

/* Begin count paths through the wave's pixels, at the camera: paths 0. */
RND_EACH_ISA(void, rnd_start, struct rnd_tracer *tracer, const struct rnd_camera *camera, uint32_t count);

#endif
