/* Lights of which there may be many: a table by power, and parts of them that are near each other. */
#ifndef FOVEAD_RENDERER_EMITTERS_H
#define FOVEAD_RENDERER_EMITTERS_H

#include "math/sphere.h"
#include "scene/lights.h"

/* position and power of count lights, power by any factor; its sum is above 0. False if memory is short. */
bool rnd_emitters_build(struct rnd_emitters *emitters, const vec3s *position, const float *power,
                        uint32_t count);

#endif
