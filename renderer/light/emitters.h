/* Emitters of a group: a table by power, and parts of emitters that are near each other. */
#ifndef FOVEAD_RENDERER_EMITTERS_H
#define FOVEAD_RENDERER_EMITTERS_H

#include "math/sphere.h"
#include "scene/lights.h"

/* position (m) and power of count emitters; power up to a constant factor, with a sum above 0. False if
 * memory is short. */
bool rnd_emitters_build(struct rnd_emitters *emitters, const vec3s *position, const float *power,
                        uint32_t count);

#endif
