/* A tape of the calls that a tracer made to Embree, to make them again with nothing in between: what
 * traversal alone costs. */
#ifndef FOVEAD_RENDERER_TAPE_H
#define FOVEAD_RENDERER_TAPE_H

#include "scene/embree.h"

struct rnd_tape;

struct rnd_tape *rnd_tape_create(void);       /* NULL if memory is short */
void rnd_tape_destroy(struct rnd_tape *tape); /* accepts NULL */

/* Called by the tracer before a call, with what Embree is given. When memory is short the tape stops and
 * rnd_tape_play() says so. */
void rnd_tape_intersect(struct rnd_tape *tape, bool coherent, const struct rnd_embree_rays *rays,
                        uint32_t count);
void rnd_tape_occlude(struct rnd_tape *tape, const struct rnd_embree_rays *rays, uint32_t count);

/* Make all recorded calls once more. False if the tape is not whole. It is used up: rays end where they hit.
 */
bool rnd_tape_play(struct rnd_tape *tape, RTCScene scene);

#endif
