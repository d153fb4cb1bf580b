/* A wave of paths in structures of arrays: what the stages of the integrator hand to each other.
 *
 * The stages (start, rays, surface, lights, scatter) are compiled once for every instruction set that is
 * worth it; ISA() tells their names apart, and rnd_tracer_create() takes the best that the processor has.
 */
#ifndef FOVEAD_RENDERER_WAVE_H
#define FOVEAD_RENDERER_WAVE_H

#include "light/choice.h"
#include "material/shading.h"
#include "material/surface.h"
#include "math/sampler.h"
#include "math/v3.h"
#include "path/media.h"
#include "path/wave_io.h"

#define RND_JOIN_(a, b) a##_##b
#define RND_JOIN(a, b)  RND_JOIN_(a, b)
#ifndef RND_ISA
#define RND_ISA plain
#endif
#define ISA(name) RND_JOIN(name, RND_ISA)
/* Declares a stage as it is compiled for every instruction set. */
#define RND_EACH_ISA(type, name, ...)                                                                        \
    type name##_plain(__VA_ARGS__);                                                                          \
    type name##_v3(__VA_ARGS__);                                                                             \
    type name##_v4(__VA_ARGS__)

/* One value of every path. */
typedef float rnd_floats[RND_WAVE] __attribute__((aligned(64)));
typedef uint32_t rnd_words[RND_WAVE] __attribute__((aligned(64)));
typedef rnd_media rnd_medias[RND_WAVE] __attribute__((aligned(64)));

struct rnd_vectors {
    rnd_floats x, y, z;
};

/* Paths under way, dense: those that end leave no holes. */
struct rnd_paths {
    struct rnd_vectors origin, direction; /* of the ray; at a surface, origin is the point that was hit */
    struct rnd_vectors throughput;
    rnd_floats first; /* largest throughput behind the first surface */
    /* With which the direction was drawn, per steradian; 0: a single direction, which next-event estimation
     * could not have found. */
    rnd_floats pdf;
    /* Width of the cone that the path stands for, m. The film's pixels open the cone, and no bounce widens
     * it: at mipmaps that coarse, texels that no face shows would light a room. */
    rnd_floats width;
    rnd_words seed, index; /* identifies the path's random numbers */
    rnd_words id;          /* index of the wave's answer that the path adds to */
    /* In scenes with clear glass: 1 while the path has only passed clear glass since a surface that drew a
     * light through it, so that light found now is counted already; else 0. */
    rnd_words stood_for;
    rnd_medias media; /* in scenes with media: those that the ray goes through */
};

/* What rays hit, in the order of the paths that they belong to. */
struct rnd_hits {
    rnd_floats distance, u, v;
    struct rnd_vectors normal; /* of the triangle, of any length; outside is where the vertices turn left */
    rnd_words geometry, primitive, instance;
};

/* Points on surfaces, in the order of the paths; sorted by kind of material. */
struct rnd_surfaces {
    uint32_t end[RND_RICH + 1]; /* where each kind's points end; it begins where the one before ended */
    rnd_words mesh, instance, corners, material, triangle;
    rnd_floats distance, u, v;
    rnd_floats footprint;                 /* width of the path's cone here, in the mesh's own metres */
    struct rnd_vectors normal, geometric; /* unit; both face where the ray came from */
    rnd_words front;                      /* hit from the outside: 0 or 1 */
    struct rnd_vectors base;
    rnd_floats metallic, alpha; /* GGX alpha: roughness squared */
    rnd_floats f0, f90;         /* reflectance of the non-metal ahead and at grazing angles */
    rnd_medias behind;          /* in scenes with media: those behind the surface */
};

/* A light chosen for each point; pdf 0: none. */
struct rnd_light_choices {
    struct rnd_vectors direction, radiance;
    rnd_floats distance, pdf;
    rnd_words delta;
};

/* Emissive triangles that were chosen, and where on them. */
struct rnd_areas {
    struct rnd_vectors corner, e1, e2;
    rnd_floats probability, s, t;
    rnd_words flags;
};

/* What surfaces do: with the chosen light, and where the paths go on. */
struct rnd_scatters {
    struct rnd_vectors contribution; /* radiance that the path contributes if the light is not hidden */
    rnd_floats share;                /* MIS weight of the chosen light */
    struct rnd_vectors direction, weight;
    rnd_floats pdf; /* of the direction; 0: a single direction; negative: the path ends */
};

/* The look-up of a texture, whose texel is on its way from memory. */
struct rnd_lookup {
    const struct rnd_texture *texture;
    const struct rnd_map *map;
    size_t texel;
    uint32_t point;
};

enum { RND_LISTS = 4 };
_Static_assert((int)RND_LISTS >= (int)RND_LIGHT_GROUPS && (int)RND_LISTS >= (int)RND_RICH + 2,
               "a list for each, and one of misses");

/* Shadow rays, and what their paths bring if they get through. */
struct rnd_shadows {
    uint32_t count;
    struct rnd_vectors origin, direction, radiance;
    rnd_floats distance; /* -INFINITY once something was found in between */
    /* In scenes with clear glass: factor of light that came through it, which takes the MIS weight away,
     * since no path finds that light by chance; 0: light through glass does not count. */
    rnd_floats through;
    rnd_medias media; /* in scenes with clear glass and media: those that the ray begins in */
    rnd_words id;     /* as of paths */
};

/* Room of the stage under way. */
union rnd_scratch {
    struct {
        rnd_words order;     /* of each point, its path among paths 0 */
        rnd_words corner[3]; /* normals at the triangle's corners, as rnd_corners has them */
    } surface;
    struct {
        rnd_words surface;          /* room of surface.order, which is still in use */
        rnd_words near, in, region; /* texels of the environment map: looked up, met; the latter's region */
    } sky;
    struct {
        rnd_words group, rank; /* of each point: its group of lights, and its place in that group's list */
        rnd_words drawn;       /* entries of a group's list: texels, or areas */
        rnd_words near;        /* texel that is looked up in place of the drawn one */
        rnd_words region;      /* of the environment */
    } lights;
    struct {
        rnd_words folds; /* of each point: does a lobe have to be folded there? */
        rnd_words lit;   /* points that a light may reach */
        rnd_words alive; /* points whose paths go on */
    } scatter;
};

enum rnd_stage { RND_STAGE_RAYS, RND_STAGE_SURFACE, RND_STAGE_LIGHT, RND_STAGE_SCATTER, RND_STAGES };

struct stages;
struct rnd_tape;

struct rnd_tracer {
    const struct rnd_scene *scene;
    int max_bounces;
    float firefly; /* luminance that indirect light is clamped to; INFINITY: it is not */
    int width;     /* of the film, pixels */
    float spread;  /* angle between neighbouring pixels, rad */
    uint32_t seed; /* of the pixels' random numbers */
    const struct rnd_light_choice *choice;
    const struct stages *stages; /* for this processor */
    uint64_t rays;
    uint64_t stage_ns[RND_STAGES];
    struct rnd_tape *tape; /* NULL unless calls are recorded */

    /* of the wave under way */
    struct rnd_wave_io *io;
    rnd_media camera_media; /* that the camera is in */
    int depth;
    struct rnd_paths paths[2]; /* paths of the step, and where those that go on are put */
    struct rnd_hits hits;
    struct rnd_surfaces surfaces;
    struct rnd_areas areas;
    struct rnd_light_choices chosen, lights; /* in the order of the groups' lists, and of the points */
    struct rnd_scatters scatters;
    rnd_floats number[4];              /* random ones of the stage under way */
    struct rnd_surface rich[RND_WAVE]; /* of the points whose material is rich, in their order */
    struct rnd_shadows shadows;
    rnd_words list[RND_LISTS]; /* of misses, kinds of material, groups of lights */
    union rnd_scratch scratch;
    struct rnd_lookup lookup[RND_WAVE];
    rnd_floats lookup_x, lookup_y; /* texture coordinates */
    rnd_floats lookup_level;       /* of mipmaps */
};

RND_INLINE struct rnd_v3 rnd_get(const struct rnd_vectors *from, size_t i)
{
    return rnd_v3(from->x[i], from->y[i], from->z[i]);
}

RND_INLINE void rnd_put(struct rnd_vectors *to, size_t i, struct rnd_v3 value)
{
    to->x[i] = value.x;
    to->y[i] = value.y;
    to->z[i] = value.z;
}

RND_INLINE bool rnd_has_media(const struct rnd_tracer *tracer)
{
    return tracer->scene->medium_count > 0;
}

/* Do paths end at the surfaces of this step? */
RND_INLINE bool rnd_is_last(const struct rnd_tracer *tracer)
{
    return tracer->max_bounces > 0 && tracer->depth >= tracer->max_bounces;
}

/* Dimensions that a vertex of a path uses, from RND_DIMENSION_PATH on. */
enum { RND_DIM_DIRECTION, RND_DIM_LOBE, RND_DIM_LIGHT, RND_DIM_LIGHT_PLACE, RND_DIM_COUNT };

RND_INLINE uint32_t rnd_dimension(const struct rnd_tracer *tracer, uint32_t which)
{
    return RND_DIMENSION_PATH + RND_DIM_COUNT * (uint32_t)tracer->depth + which;
}

/* The numbers of that dimension for points first to end of paths 1. */
RND_INLINE void rnd_draw_numbers(struct rnd_tracer *tracer, uint32_t which, uint32_t first, uint32_t end,
                                 float *restrict u, float *restrict v)
{
    const struct rnd_paths *paths = &tracer->paths[1];
    const uint32_t dimension = rnd_dimension(tracer, which);
#pragma GCC ivdep
    for (size_t j = first; j < end; j++) {
        const struct rnd_two two = rnd_two(paths->seed[j], dimension, paths->index[j]);
        u[j] = two.u;
        v[j] = two.v;
    }
}

/* Limit of the luminance of light that arrives at a surface of the path; the first surface that the camera
 * sees is 0. Only indirect light is clamped, however it was found. */
RND_INLINE float rnd_firefly_limit(const struct rnd_tracer *tracer, int surface)
{
    return surface > 0 ? tracer->firefly : INFINITY;
}

RND_INLINE struct rnd_v3 rnd_clamp_firefly(struct rnd_v3 radiance, float limit)
{
    const float bright = rnd_v3_luminance(radiance);
    return rnd_v3_scale(radiance, bright > limit ? limit / bright : 1.0f);
}

/* Add light that a path found at the end of its ray: it lights the surface that the ray left. */
RND_INLINE void rnd_add_radiance(struct rnd_tracer *tracer, uint32_t id, struct rnd_v3 found)
{
    const struct rnd_v3 radiance = rnd_clamp_firefly(found, rnd_firefly_limit(tracer, tracer->depth - 1));
    tracer->io->radiance[0][id] += radiance.x;
    tracer->io->radiance[1][id] += radiance.y;
    tracer->io->radiance[2][id] += radiance.z;
}

#endif
