/* The path integrator: a wave of paths, stage after stage, until none is left. */
#include "path/trace.h"
#include "path/emission.h"
#include "path/lights.h"
#include "path/rays.h"
#include "path/scatter.h"
#include "path/start.h"
#include "path/surface.h"
#include "path/visible.h"

#include <stdlib.h>
#include <string.h>
#include <time.h>

/* The stages, once for every instruction set. */
struct stages {
    void (*start)(struct rnd_tracer *, const struct rnd_camera *, uint32_t);
    uint32_t (*surface)(struct rnd_tracer *, uint32_t);
    void (*emission)(struct rnd_tracer *, uint32_t);
    void (*choose_lights)(struct rnd_tracer *, uint32_t);
    uint32_t (*scatter)(struct rnd_tracer *, uint32_t);
};

#define STAGES(isa)                                                                                          \
    static const struct stages RND_JOIN(stages, isa) = {                                                     \
        RND_JOIN(rnd_start, isa), RND_JOIN(rnd_surface, isa), RND_JOIN(rnd_emission, isa),                   \
        RND_JOIN(rnd_choose_lights, isa), RND_JOIN(rnd_scatter, isa)};
STAGES(plain)
#ifdef RND_X86
STAGES(v3)
STAGES(v4)
#endif

static const struct stages *best_stages(void)
{
#ifdef RND_X86
    __builtin_cpu_init();
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
        __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl"))
        return &stages_v4;
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi2"))
        return &stages_v3;
#endif
    return &stages_plain;
}

struct rnd_tracer *rnd_tracer_create(const struct rnd_scene *scene, const struct rnd_light_choice *choice,
                                     int max_bounces, float firefly, int width, uint32_t seed)
{
    struct rnd_tracer *tracer = aligned_alloc(64, (sizeof *tracer + 63) & ~(size_t)63);
    if (!tracer) return NULL;
    memset(tracer, 0, sizeof *tracer);
    tracer->scene = scene;
    tracer->choice = choice;
    tracer->max_bounces = max_bounces;
    tracer->firefly = firefly > 0.0f ? firefly : INFINITY;
    tracer->width = width;
    tracer->spread = 2.0f * (float)M_PI / (float)width;
    tracer->seed = seed;
    tracer->stages = best_stages();
    return tracer;
}

void rnd_tracer_destroy(struct rnd_tracer *tracer)
{
    free(tracer);
}

void rnd_tracer_scene(struct rnd_tracer *tracer, const struct rnd_scene *scene)
{
    tracer->scene = scene;
}

void rnd_tracer_tape(struct rnd_tracer *tracer, struct rnd_tape *tape)
{
    tracer->tape = tape;
}

void rnd_tracer_reset(struct rnd_tracer *tracer)
{
    memset(tracer->stage_ns, 0, sizeof tracer->stage_ns);
}

void rnd_tracer_stages(const struct rnd_tracer *tracer, struct rnd_batch *batch)
{
    batch->rays_seconds += 1e-9 * (double)tracer->stage_ns[RND_STAGE_RAYS];
    batch->surface_seconds += 1e-9 * (double)tracer->stage_ns[RND_STAGE_SURFACE];
    batch->light_seconds += 1e-9 * (double)tracer->stage_ns[RND_STAGE_LIGHT];
    batch->scatter_seconds += 1e-9 * (double)tracer->stage_ns[RND_STAGE_SCATTER];
}

static uint64_t now_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (uint64_t)t.tv_sec * 1000000000 + (uint64_t)t.tv_nsec;
}

/* Book the time since the last call to a stage. */
static void book(struct rnd_tracer *tracer, enum rnd_stage stage, uint64_t *last_ns)
{
    const uint64_t now = now_ns();
    tracer->stage_ns[stage] += now - *last_ns;
    *last_ns = now;
}

uint64_t rnd_trace(struct rnd_tracer *tracer, const struct rnd_camera *camera, rnd_media media,
                   struct rnd_wave_io *io, uint32_t count)
{
    const struct stages *stages = tracer->stages;
    const uint64_t rays = tracer->rays;
    uint64_t last_ns = now_ns();
    tracer->io = io;
    tracer->camera_media = media;
    stages->start(tracer, camera, count);
    for (tracer->depth = 0; count > 0; tracer->depth++) {
        rnd_intersect(tracer, &tracer->paths[0], count, tracer->depth == 0);
        if (tracer->depth == 0 && tracer->scene->one_sided) rnd_pass_backs(tracer, &tracer->paths[0], count);
        book(tracer, RND_STAGE_RAYS, &last_ns);
        const uint32_t paths = count;
        count = stages->surface(tracer, count);
        if (tracer->depth == 0 && io->plane_values) rnd_visible(tracer, paths, count);
        stages->emission(tracer, count);
        book(tracer, RND_STAGE_SURFACE, &last_ns);
        if (rnd_is_last(tracer)) break;
        stages->choose_lights(tracer, count);
        book(tracer, RND_STAGE_LIGHT, &last_ns);
        count = stages->scatter(tracer, count);
        book(tracer, RND_STAGE_SCATTER, &last_ns);
        rnd_occlude(tracer);
        book(tracer, RND_STAGE_RAYS, &last_ns);
    }
    return tracer->rays - rays;
}
