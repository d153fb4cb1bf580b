/* The tape: a list of calls, each with its own arrays. */
#include "path/tape.h"

#include <stdlib.h>
#include <string.h>

enum { RAY_ARRAYS = 7, HIT_ARRAYS = 8 };

/* With its arrays behind it: origins, directions and distances of rays, and room for hits. */
struct call {
    struct call *next;
    uint32_t count;
    bool coherent, shadows; /* of shadows without arrays of hits */
    float data[] __attribute__((aligned(64)));
};

struct rnd_tape {
    struct call *first, *last;
    bool broken;
};

struct rnd_tape *rnd_tape_create(void)
{
    return calloc(1, sizeof(struct rnd_tape));
}

void rnd_tape_destroy(struct rnd_tape *tape)
{
    if (!tape) return;
    for (struct call *call = tape->first, *next; call; call = next) {
        next = call->next;
        free(call);
    }
    free(tape);
}

/* Arrays begin at lines of the cache, as the tracer's do. */
static size_t padded(uint32_t count)
{
    return (count + 15u) & ~(size_t)15;
}

static float *array(struct call *call, int index)
{
    return call->data + (size_t)index * padded(call->count);
}

static void record(struct rnd_tape *tape, bool coherent, bool shadows, const struct rnd_embree_rays *rays,
                   uint32_t count)
{
    const float *from[RAY_ARRAYS] = {rays->origin[0],    rays->origin[1],    rays->origin[2],
                                     rays->direction[0], rays->direction[1], rays->direction[2],
                                     rays->distance};
    const size_t arrays = RAY_ARRAYS + (shadows ? 0 : HIT_ARRAYS),
                 bytes = arrays * padded(count) * sizeof(float);
    struct call *call = aligned_alloc(64, (sizeof *call + bytes + 63) & ~(size_t)63);
    if (!call) {
        tape->broken = true;
        return;
    }
    *call = (struct call){.count = count, .coherent = coherent, .shadows = shadows};
    for (int i = 0; i < RAY_ARRAYS; i++) memcpy(array(call, i), from[i], count * sizeof(float));
    *(tape->last ? &tape->last->next : &tape->first) = call;
    tape->last = call;
}

void rnd_tape_intersect(struct rnd_tape *tape, bool coherent, const struct rnd_embree_rays *rays,
                        uint32_t count)
{
    record(tape, coherent, false, rays, count);
}

void rnd_tape_occlude(struct rnd_tape *tape, const struct rnd_embree_rays *rays, uint32_t count)
{
    record(tape, false, true, rays, count);
}

static void play(struct call *call, RTCScene scene)
{
    float *f[RAY_ARRAYS + HIT_ARRAYS] = {0};
    for (int i = 0; i < RAY_ARRAYS + (call->shadows ? 0 : HIT_ARRAYS); i++) f[i] = array(call, i);
    const struct rnd_embree_rays rays = {{f[0], f[1], f[2]}, {f[3], f[4], f[5]}, f[6]};
    const struct rnd_embree_hits hits = {
        {f[7], f[8], f[9]}, f[10], f[11], (unsigned *)f[12], (unsigned *)f[13], (unsigned *)f[14]};
    if (call->shadows)
        rnd_embree_occluded(scene, &rays, call->count);
    else
        rnd_embree_intersect(scene, call->coherent, &rays, &hits, call->count);
}

bool rnd_tape_play(struct rnd_tape *tape, RTCScene scene)
{
    for (struct call *call = tape->first; call; call = call->next) play(call, scene);
    return !tape->broken;
}
