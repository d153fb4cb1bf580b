/* What the camera sees: the film's planes, gathered where paths first hit a surface. */
#include "path/visible.h"
#include "film/planes.h"

#include <string.h>

/* Point j as a surface. Points of rich materials have one already. */
static struct rnd_surface surface_of(const struct rnd_tracer *tracer, uint32_t j)
{
    const struct rnd_surfaces *s = &tracer->surfaces;
    const uint32_t rich = s->end[RND_METAL_ROUGH];
    if (j >= rich) return tracer->rich[j - rich];
    const bool glossy = j >= s->end[RND_DIFFUSE];
    return (struct rnd_surface){.material = &tracer->scene->material[s->material[j]],
                                .position = rnd_from_v3(rnd_get(&tracer->paths[1].origin, j)),
                                .geometric = rnd_from_v3(rnd_get(&s->geometric, j)),
                                .shading = rnd_from_v3(rnd_get(&s->normal, j)),
                                .front = s->front[j],
                                .base = rnd_from_v3(rnd_get(&s->base, j)),
                                .metallic = glossy ? s->metallic[j] : 0.0f,
                                .alpha = glossy ? s->alpha[j] : 1.0f};
}

void rnd_visible(struct rnd_tracer *tracer, uint32_t paths, uint32_t hits)
{
    const struct rnd_planes *planes = tracer->io->planes;
    const struct rnd_surfaces *s = &tracer->surfaces;
    const size_t channels = (size_t)planes->channels;
    float *values = tracer->io->plane_values;
    memset(values, 0, paths * channels * sizeof *values); /* for paths that hit nothing */
    for (uint32_t j = 0; j < hits; j++) {
        const struct rnd_surface surface = surface_of(tracer, j);
        /* the tree numbers meshes first, and then instances */
        const uint32_t number = s->instance[j] == RTC_INVALID_GEOMETRY_ID ? s->mesh[j] : s->instance[j];
        rnd_planes_gather(planes, &surface, 1 + number, values + tracer->paths[1].id[j] * channels);
    }
}
