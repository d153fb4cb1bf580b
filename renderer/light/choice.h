/* The choice of a light for a shading point: how often which is drawn, and what a drawn light gives. */
#ifndef FOVEAD_RENDERER_CHOICE_H
#define FOVEAD_RENDERER_CHOICE_H

#include "scene/lights.h"

/* How often each light is drawn. */
struct rnd_light_choice {
    float group[RND_LIGHT_GROUPS];                      /* they sum to 1; above 0 for a group that gives
                                                           light */
    struct rnd_env_choice env;                          /* unused without an environment */
    const struct rnd_alias *emitters[RND_LIGHT_GROUPS]; /* by_power of the scene's, or an entry of own */
    struct rnd_alias own[RND_LIGHT_GROUPS];
};

/* A drawn light as seen from a point: its direction, the radiance from there, and the density with which it
 * was drawn within its group. */
struct rnd_light_sample {
    struct rnd_v3 direction; /* unit, towards the light */
    float distance;          /* INFINITY for env and sun */
    struct rnd_v3 radiance;  /* for lights without extent, irradiance of a surface that faces it */
    float pdf;               /* per steradian; for lights without extent, of the choice alone */
    bool delta;              /* without extent: no ray hits it by chance */
    uint32_t part;           /* rnd_emitters.part, or the region of the environment */
};

struct rnd_scene;

/* A kind of light. */
struct rnd_light_kind {
    /* Once the geometry is there: make the tables of all lights of the kind. *out_power: their power
     * together, up to a constant factor; 0 if they give no light. False if memory is short. */
    bool (*build)(struct rnd_scene *scene, double *out_power);
    /* Draw one for a point, from four numbers in [0,1). False if its light does not reach the point. */
    bool (*draw)(const struct rnd_scene *scene, const struct rnd_light_choice *choice, struct rnd_v3 point,
                 const float u[4], struct rnd_light_sample *out);
};

#endif
