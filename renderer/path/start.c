/* Where paths begin. The place within the pixel, and every later random number of a path, come from the
 * random sequence of its pixel. */
#include "path/start.h"
#include "math/uv.h"

#include <string.h>

void ISA(rnd_start)(struct rnd_tracer *tracer, const struct rnd_camera *camera, uint32_t count)
{
    struct rnd_paths *paths = &tracer->paths[0];
    struct rnd_wave_io *io = tracer->io;
    const uint32_t width = (uint32_t)tracer->width, seed = tracer->seed;
    const float pixel = 1.0f / (float)tracer->width;
#pragma GCC ivdep
    for (size_t i = 0; i < count; i++) {
        const uint32_t x = io->x[i], y = io->y[i], number = io->number[i];
        /* one sequence for each half of the pixel's paths */
        const uint32_t own = rnd_hash2(seed, 2 * (y * width + x) + (number & 1)), index = number >> 1;
        const struct rnd_two two = rnd_two(own, RND_DIMENSION_PIXEL, index);
        rnd_put(
            &paths->direction, i,
            rnd_v3_from_uv(((float)(int32_t)x + two.u) * pixel, ((float)(int32_t)y + two.v) * 2.0f * pixel));
        paths->seed[i] = own;
        paths->index[i] = index;
    }
    if (tracer->scene->clear_tree) memset(paths->stood_for, 0, count * sizeof *paths->stood_for);
    for (uint32_t i = 0; rnd_has_media(tracer) && i < count; i++) paths->media[i] = tracer->camera_media;
    const float *at = camera->position;
    const float index = tracer->scene->medium[rnd_media_innermost(tracer->camera_media)].ior,
                whole = 1.0f / (index * index);
    for (uint32_t i = 0; i < count; i++) {
        rnd_put(&paths->origin, i, rnd_v3(at[0], at[1], at[2]));
        rnd_put(&paths->throughput, i, rnd_v3(whole, whole, whole));
        paths->pdf[i] = paths->width[i] = 0.0f;
        paths->id[i] = i;
        for (int c = 0; c < 3; c++) io->radiance[c][i] = 0.0f;
    }
}
