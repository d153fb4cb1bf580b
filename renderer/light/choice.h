/* Which light a point asks: how often which, and what one that was drawn gives. */
#ifndef FOVEAD_RENDERER_CHOICE_H
#define FOVEAD_RENDERER_CHOICE_H

#include "scene/lights.h"

/* How often points ask for which light. */
struct rnd_light_choice {
    float group[RND_LIGHT_GROUPS];                      /* one in all; never 0 for one that gives light */
    struct rnd_env_choice env;                          /* unused without an environment */
    const struct rnd_alias *emitters[RND_LIGHT_GROUPS]; /* the lights' own, or these: */
    struct rnd_alias own[RND_LIGHT_GROUPS];
};

/* A light of a group seen from a point: where to look for it, what comes from there, with which density it
 * was drawn within the group. */
struct rnd_light_sample {
    struct rnd_v3 direction; /* unit, towards the light */
    float distance;          /* INFINITY for env and sun */
    struct rnd_v3 radiance;  /* for lights without extent, the irradiance facing it */
    float pdf;               /* per steradian; for lights without extent, of the choice alone */
    bool delta;              /* no extent: cannot be hit by chance */
    uint32_t part;           /* of emitters, or region of the environment */
};

struct rnd_scene;

/* A kind of light. */
struct rnd_light_kind {
    /* After the geometry: make the tables of all lights of the kind. *out_power: of all of them together, by
     * any factor; 0 if they give no light. False if memory is short. */
    bool (*build)(struct rnd_scene *scene, double *out_power);
    /* Draw one for a point from four numbers in [0,1). False if what was drawn does not reach the point. */
    bool (*draw)(const struct rnd_scene *scene, const struct rnd_light_choice *choice, struct rnd_v3 point,
                 const float u[4], struct rnd_light_sample *out);
};

#endif
