/* The tape: a list of calls, each with its own arrays. */
#include "path/tape.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { RAY_ARRAYS = 12, HIT_ARRAYS = 8 };

/* With its rays behind it: the arrays that RTCRayNp names, in its order, and those of hits. */
struct call {
    struct call *next;
    uint32_t count;
    int flags;
    bool shadows; /* without arrays of hits */
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

static struct call *add(struct rnd_tape *tape, size_t bytes)
{
    struct call *call = aligned_alloc(64, (sizeof *call + bytes + 63) & ~(size_t)63);
    if (!call) return tape->broken = true, NULL;
    call->next = NULL;
    if (tape->last)
        tape->last->next = call;
    else
        tape->first = call;
    return tape->last = call;
}

/* Arrays begin at lines of the cache, as the tracer's do. */
static uint32_t stride(uint32_t count)
{
    return (count + 15u) & ~15u;
}

static void record(struct rnd_tape *tape, bool shadows, int flags, const struct RTCRayNp *ray, uint32_t count)
{
    const void *from[RAY_ARRAYS] = {ray->org_x, ray->org_y, ray->org_z, ray->tnear, ray->dir_x, ray->dir_y,
                                    ray->dir_z, ray->time,  ray->tfar,  ray->mask,  ray->id,    ray->flags};
    const uint32_t n = stride(count), hits = shadows ? 0 : HIT_ARRAYS;
    struct call *call = add(tape, (RAY_ARRAYS + hits) * n * sizeof(float));
    if (!call) return;
    call->count = count;
    call->flags = flags;
    call->shadows = shadows;
    for (int i = 0; i < RAY_ARRAYS; i++) memcpy(call->data + (size_t)i * n, from[i], count * sizeof(float));
    memset(call->data + (size_t)RAY_ARRAYS * n, 0xff,
           hits * n * sizeof(float)); /* no geometry, no instance */
}

void rnd_tape_intersect(struct rnd_tape *tape, int flags, const struct RTCRayHitNp *stream, uint32_t count)
{
    record(tape, false, flags, &stream->ray, count);
}

void rnd_tape_occlude(struct rnd_tape *tape, int flags, const struct RTCRayNp *stream, uint32_t count)
{
    record(tape, true, flags, stream, count);
}

static void play(struct call *call, RTCScene scene)
{
    float *f[RAY_ARRAYS + HIT_ARRAYS];
    for (int i = 0; i < RAY_ARRAYS + HIT_ARRAYS; i++) f[i] = call->data + (size_t)i * stride(call->count);
    struct RTCRayHitNp stream = {.ray = {f[0], f[1], f[2], f[3], f[4], f[5], f[6], f[7], f[8],
                                         (unsigned *)f[9], (unsigned *)f[10], (unsigned *)f[11]}};
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = (enum RTCIntersectContextFlags)call->flags;
    if (call->shadows) {
        rtcOccludedNp(scene, &context, &stream.ray, call->count);
        return;
    }
    stream.hit = (struct RTCHitNp){
        f[12], f[13], f[14], f[15], f[16], (unsigned *)f[17], (unsigned *)f[18], {(unsigned *)f[19]}};
    rtcIntersectNp(scene, &context, &stream, call->count);
}

bool rnd_tape_play(struct rnd_tape *tape, RTCScene scene)
{
    for (struct call *call = tape->first; call; call = call->next) play(call, scene);
    return !tape->broken;
}
