/* The tape: a list of reels, each with the packets of many calls. */
#include "path/tape.h"

#include <stdlib.h>
#include <string.h>

enum { REEL = 1024 };

struct call {
    struct RTCRayHit8 rays;
    int valid[8] __attribute__((aligned(32)));
    bool coherent, shadows; /* of shadows the rays alone */
};

struct reel {
    struct call call[REEL];
    int count;
    struct reel *next;
};

struct rnd_tape {
    struct reel *first, *last;
    bool broken;
};

struct rnd_tape *rnd_tape_create(void)
{
    return calloc(1, sizeof(struct rnd_tape));
}

void rnd_tape_destroy(struct rnd_tape *tape)
{
    if (!tape) return;
    for (struct reel *reel = tape->first, *next; reel; reel = next) {
        next = reel->next;
        free(reel);
    }
    free(tape);
}

static struct call *add(struct rnd_tape *tape, const int valid[8])
{
    if (!tape->last || tape->last->count == REEL) {
        struct reel *reel = aligned_alloc(64, (sizeof *reel + 63) & ~(size_t)63);
        if (!reel) return tape->broken = true, NULL;
        reel->count = 0;
        reel->next = NULL;
        *(tape->last ? &tape->last->next : &tape->first) = reel;
        tape->last = reel;
    }
    struct call *call = &tape->last->call[tape->last->count++];
    memcpy(call->valid, valid, sizeof call->valid);
    return call;
}

void rnd_tape_intersect(struct rnd_tape *tape, bool coherent, const int valid[8],
                        const struct RTCRayHit8 *rays)
{
    struct call *call = add(tape, valid);
    if (!call) return;
    call->rays = *rays;
    call->coherent = coherent;
    call->shadows = false;
}

void rnd_tape_occlude(struct rnd_tape *tape, const int valid[8], const struct RTCRay8 *rays)
{
    struct call *call = add(tape, valid);
    if (!call) return;
    call->rays.ray = *rays;
    call->shadows = true;
}

bool rnd_tape_play(struct rnd_tape *tape, RTCScene scene)
{
    for (struct reel *reel = tape->first; reel; reel = reel->next)
        for (struct call *call = reel->call; call < reel->call + reel->count; call++)
            if (call->shadows)
                rnd_embree_occluded8(scene, call->valid, &call->rays.ray);
            else
                rnd_embree_intersect8(scene, call->coherent, call->valid, &call->rays);
    return !tape->broken;
}
